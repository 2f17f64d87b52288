//! Lines to a drive: a serial port, or a TCP connection to something that has one.

use std::fmt;
use std::io::{Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use wire::connection::{Connection, LinkError, Persistence};

use crate::Error;

/// Time for a TCP connection to come about.
const CONNECT: Duration = Duration::from_secs(5);
/// A read gives up after this, so that the time and Ctrl-C can be looked at.
const READ: Duration = Duration::from_millis(10);
/// A far end that takes nothing for this long is dead.
const WRITE: Duration = Duration::from_secs(1);

/// Bytes both ways, with reads that give up after some 10 ms.
pub trait Stream: Read + Write {}

impl<S: Read + Write> Stream for S {}

/// Where a drive's link is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A serial port.
    Serial {
        /// As the system names it.
        port: String,
        /// Baud rate, 8N1.
        baud: u32,
    },
    /// Host and port.
    Tcp(String),
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { port, .. } => f.write_str(port),
            Self::Tcp(address) => f.write_str(address),
        }
    }
}

impl Line {
    /// Opens the line.
    ///
    /// # Errors
    ///
    /// [`Error::Connection`].
    pub fn open(&self) -> Result<Box<dyn Stream>, Error> {
        match self {
            Self::Serial { port, baud } => {
                let port = serialport::new(port, *baud).timeout(READ).open_native();
                Ok(Box::new(port.map_err(|error| Error::connection(&self.to_string(), error))?))
            }
            Self::Tcp(address) => Ok(Box::new(tunnel(address)?)),
        }
    }

    /// Opens the line and a session with the drive on it.
    ///
    /// # Errors
    ///
    /// [`Error::Connection`].
    pub fn connect(&self) -> Result<Connection<Box<dyn Stream>>, Error> {
        self.connect_with(Persistence::default())
    }

    /// The same with another patience: a simulated drive may be slower than the clock.
    ///
    /// # Errors
    ///
    /// [`Error::Connection`].
    pub fn connect_with(&self, persistence: Persistence) -> Result<Connection<Box<dyn Stream>>, Error> {
        Connection::open(self.open()?, persistence).map_err(|error| self.error(error))
    }

    /// An error of the link as one of the tool.
    pub fn error(&self, error: LinkError) -> Error {
        match error {
            LinkError::Parameter(parameter) => Error::Usage(parameter.to_string()),
            LinkError::Refused(_) => Error::Refused { place: self.to_string(), message: error.to_string() },
            other => Error::connection(&self.to_string(), other),
        }
    }
}

/// A TCP connection to this very machine: the link neither encrypts nor asks who is there. To any other none is opened.
fn tunnel(address: &str) -> Result<TcpStream, Error> {
    let resolved = address.to_socket_addrs().map_err(|error| Error::connection(address, error))?;
    if let Some(other) = resolved.into_iter().find(|resolved| !resolved.ip().is_loopback()) {
        return Err(Error::Usage(format!(
            "{address}: is another machine, and the link neither encrypts nor asks who is there: tunnel it \
             (ssh -L {port}:127.0.0.1:{port} HOST) and connect to 127.0.0.1:{port}",
            port = other.port()
        )));
    }
    tcp(address)
}

/// A TCP connection whose reads and writes give up.
///
/// # Errors
///
/// [`Error::Connection`].
pub fn tcp(address: &str) -> Result<TcpStream, Error> {
    let failed = |error: std::io::Error| Error::connection(address, error);
    let mut last = Error::connection(address, "no such host");
    for resolved in address.to_socket_addrs().map_err(failed)? {
        match TcpStream::connect_timeout(&resolved, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true).map_err(failed)?;
                stream.set_read_timeout(Some(READ)).map_err(failed)?;
                stream.set_write_timeout(Some(WRITE)).map_err(failed)?;
                return Ok(stream);
            }
            Err(error) => last = failed(error),
        }
    }
    Err(last)
}
