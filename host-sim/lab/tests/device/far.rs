//! The drive behind two TCP ports, its link and its log, in a thread of its own.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use er_servo::Config;
use er_servo::link::{PACKET_BYTES, ParameterSource, Server, encode};
use plant::Model;

use crate::drive::Machine;
use crate::log::Encoder;

/// Ticks a second: a quarter of the drive's, so that 250 ms of silence are a second here and a busy machine is no fault.
const TICKS_S: f64 = 500.0;
/// Of a drive that is ten times as fast as its clock, for experiments of a minute; its patience is a second.
const FAST_TICKS_S: f64 = 20_000.0;
const FAST_SILENT_TICKS: u32 = 20_000;

/// What a test may pull at while the drive runs.
#[derive(Debug, Default)]
pub struct Strings {
    ended: AtomicBool,
    /// Opens the interlock.
    pub interlock_open: AtomicBool,
    /// Fills the event log.
    pub log_is_full: AtomicBool,
    /// Answers that are lost from now on.
    pub lose_answers: AtomicU32,
    /// Hangs up on the reader of the log.
    pub hang_up: AtomicBool,
    /// Readers of the log so far.
    pub readers: AtomicU32,
}

/// The far end.
pub struct Far {
    pub link: SocketAddr,
    pub log: SocketAddr,
    pub strings: Arc<Strings>,
    thread: Option<JoinHandle<()>>,
}

impl Far {
    pub fn start(encoder: Option<Encoder>) -> Self {
        Self::with(TICKS_S, move || Machine::ready(encoder))
    }

    /// Another machine, ten times as fast as the clock.
    pub fn fast(model: Model) -> Self {
        Self::with(FAST_TICKS_S, move || Machine::of(&model, None, FAST_SILENT_TICKS))
    }

    fn with(ticks_s: f64, machine: impl FnOnce() -> Machine + Send + 'static) -> Self {
        let (link, log) = (Ear::new(), Ear::new());
        let strings = Arc::new(Strings::default());
        let addresses = [&link, &log].map(|ear| ear.listener.local_addr().unwrap());
        let pulled = Arc::clone(&strings);
        let thread = thread::spawn(move || serve(&pulled, link, log, ticks_s, machine()));
        Self { link: addresses[0], log: addresses[1], strings, thread: Some(thread) }
    }

    /// The begin of a command line of `servo-lab`.
    pub fn line(&self, action: &str) -> String {
        format!("link --tcp {} {action}", self.link)
    }
}

impl Drop for Far {
    fn drop(&mut self) {
        self.strings.ended.store(true, Ordering::Relaxed);
        let outcome = self.thread.take().unwrap().join();
        assert!(outcome.is_ok() || thread::panicking(), "the drive panicked");
    }
}

/// A port on which one peer at a time is listened to: the latest.
struct Ear {
    listener: TcpListener,
    peer: Option<TcpStream>,
}

impl Ear {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        Self { listener, peer: None }
    }

    /// Whether a new peer has come.
    fn accept(&mut self) -> bool {
        let Ok((peer, _)) = self.listener.accept() else { return false };
        peer.set_nonblocking(true).unwrap();
        self.peer = Some(peer);
        true
    }

    fn read(&mut self, buffer: &mut [u8]) -> usize {
        match self.peer.as_mut().map(|peer| peer.read(buffer)) {
            Some(Ok(count)) if count > 0 => count,
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => 0,
            _ => {
                self.peer = None;
                0
            }
        }
    }

    /// Sends, or drops, as a serial line would.
    fn write(&mut self, bytes: &[u8]) {
        let sent = self.peer.as_mut().map(|peer| peer.write_all(bytes));
        if let Some(Err(error)) = sent
            && error.kind() != ErrorKind::WouldBlock
        {
            self.peer = None;
        }
    }
}

fn serve(strings: &Strings, mut link: Ear, mut log: Ear, ticks_s: f64, mut machine: Machine) {
    // 20 ms.
    let at_once = (ticks_s / 50.0) as u32;
    let mut server = Server::new(Config::default(), ParameterSource::BuiltIn);
    let (start, mut ticks) = (Instant::now(), 0);
    let mut buffer = [0; 4096];
    while !strings.ended.load(Ordering::Relaxed) {
        link.accept();
        strings.readers.fetch_add(u32::from(log.accept()), Ordering::Relaxed);
        let count = link.read(&mut buffer);
        for byte in &buffer[..count] {
            let Some(reply) = server.push(*byte, &mut machine) else { continue };
            let lose = |left: u32| left.checked_sub(1);
            link.write(&std::mem::take(&mut machine.telemetry));
            if strings.lose_answers.fetch_update(Ordering::Relaxed, Ordering::Relaxed, lose).is_err() {
                link.write(encode(&reply, &mut [0; PACKET_BYTES]).unwrap());
            }
        }
        machine.bench.interlock_closed.set(!strings.interlock_open.load(Ordering::Relaxed));
        machine.log_is_full |= strings.log_is_full.swap(false, Ordering::Relaxed);
        let due = (start.elapsed().as_secs_f64() * ticks_s) as u32;
        // A thread that was kept waiting does not catch up: that would be silence of the link.
        machine.ticks((due - ticks).min(at_once));
        ticks = due;
        link.write(&std::mem::take(&mut machine.telemetry));
        log.write(&std::mem::take(&mut machine.log));
        if strings.hang_up.swap(false, Ordering::Relaxed) {
            log.peer = None;
        }
        if count == 0 {
            thread::sleep(Duration::from_millis(1));
        }
    }
}
