//! The command link of the emulated board behind a TCP port of this machine, no faster than the clock.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use rigless::time::VirtualNanos;

use crate::terminal::Terminal;

/// The board waits when it is this far ahead of the clock; how often it looks at the port is a quarter of that.
const AHEAD: Duration = Duration::from_millis(2);

/// The port, and the client that came last.
#[derive(Debug)]
pub struct Port {
    listener: TcpListener,
    client: Option<TcpStream>,
    /// Bytes of the image that were sent, or that nobody was there for.
    sent: usize,
    /// When the board's time began.
    began: Option<Instant>,
}

impl Port {
    /// Opens a port on the loopback address, and nowhere else: the link is neither encrypted nor does it ask who is there.
    /// 0 takes any that is free.
    ///
    /// # Errors
    ///
    /// A port that is taken.
    pub fn open(port: u16) -> std::io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, client: None, sent: 0, began: None })
    }

    /// Where it is.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn address(&self) -> std::io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Carries bytes both ways, and waits where the board is ahead of the clock.
    pub fn attend(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        if let Ok((client, _)) = self.listener.accept() {
            self.client = client.set_nonblocking(true).and(client.set_nodelay(true)).ok().map(|()| client);
        }
        self.receive(terminal, now);
        self.send(terminal);
        let began = *self.began.get_or_insert_with(Instant::now);
        let ahead = Duration::from_nanos(now.0).saturating_sub(began.elapsed());
        if ahead > AHEAD {
            std::thread::sleep(ahead);
        }
    }

    fn receive(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        let mut bytes = [0; 1024];
        match self.client.as_mut().map(|client| client.read(&mut bytes)) {
            Some(Ok(count)) if count > 0 => terminal.send(now, &bytes[..count]),
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => {}
            _ => self.client = None,
        }
    }

    fn send(&mut self, terminal: &Terminal) {
        let waiting = terminal.from_image.get(self.sent..).unwrap_or_default();
        self.sent += match self.client.as_mut().map(|client| client.write(waiting)) {
            Some(Ok(count)) => count,
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => 0,
            // As on a wire without a listener.
            _ => waiting.len(),
        };
    }
}
