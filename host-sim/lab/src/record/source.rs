//! Where the bytes of a log come from. A thread reads them, so that a silent origin does not keep the user waiting.

use std::fmt;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use crate::{Error, line};

/// Bytes as they come, or why no more do; a closed channel is the end of the log.
pub type Chunks = Receiver<Result<Vec<u8>, Error>>;
type Sender = SyncSender<Result<Vec<u8>, Error>>;

/// Bytes of a chunk at most, and chunks that wait at most.
const CHUNK_BYTES: usize = 16 * 1024;
const CHUNKS: usize = 64;

/// Where a log comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// Standard input.
    StandardInput,
    /// A file, or a named pipe.
    File(PathBuf),
    /// An RTT server, host and port.
    Tcp(String),
    /// A debug probe.
    #[cfg(feature = "probe")]
    Probe {
        /// Address of the recordings' control block, from the ELF file.
        address: u64,
    },
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StandardInput => f.write_str("standard input"),
            Self::File(file) => write!(f, "{}", file.display()),
            Self::Tcp(address) => f.write_str(address),
            #[cfg(feature = "probe")]
            Self::Probe { .. } => f.write_str("debug probe"),
        }
    }
}

impl Origin {
    /// An error about what came from here.
    pub fn error(&self, message: impl ToString) -> Error {
        match self {
            Self::StandardInput => Error::input("standard input".as_ref(), None, "", message.to_string()),
            Self::File(file) => Error::input(file, None, "", message.to_string()),
            _ => Error::connection(&self.to_string(), message),
        }
    }

    /// Begins to read.
    ///
    /// # Errors
    ///
    /// A file that cannot be opened, an address where nobody answers, no probe.
    pub fn open(&self) -> Result<Chunks, Error> {
        let (sender, chunks) = sync_channel(CHUNKS);
        match self {
            Self::StandardInput => self.spawn(io::stdin(), sender),
            Self::File(file) => self.spawn(File::open(file).map_err(|error| self.error(error))?, sender),
            Self::Tcp(address) => self.spawn(line::tcp(address)?, sender),
            #[cfg(feature = "probe")]
            Self::Probe { address } => {
                let mut probe = super::probe::Probe::attach(*address).map_err(|error| self.error(error))?;
                let origin = self.clone();
                thread::spawn(move || pass_on(|buffer| probe.read(buffer), &origin, &sender));
            }
        }
        Ok(chunks)
    }

    fn spawn(&self, mut from: impl Read + Send + 'static, sender: Sender) {
        let origin = self.clone();
        thread::spawn(move || pass_on(|buffer| ended(from.read(buffer)), &origin, &sender));
    }
}

/// What a read gave: bytes, none for now, or the end.
pub(super) enum Got {
    Bytes(usize),
    Nothing,
    End,
}

fn ended(read: io::Result<usize>) -> io::Result<Got> {
    match read {
        Ok(0) => Ok(Got::End),
        Ok(count) => Ok(Got::Bytes(count)),
        Err(error) => match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => Ok(Got::Nothing),
            _ => Err(error),
        },
    }
}

fn pass_on<E: ToString>(mut read: impl FnMut(&mut [u8]) -> Result<Got, E>, origin: &Origin, sender: &Sender) {
    let mut buffer = vec![0; CHUNK_BYTES];
    loop {
        let chunk = match read(&mut buffer) {
            Ok(Got::Bytes(count)) => Ok(buffer[..count].to_vec()),
            // An empty chunk finds out whether anybody still listens.
            Ok(Got::Nothing) => Ok(Vec::new()),
            Ok(Got::End) => return,
            Err(error) => Err(origin.error(error)),
        };
        let is_last = chunk.is_err();
        if sender.send(chunk).is_err() || is_last {
            return;
        }
    }
}
