//! The command link of the emulated board behind a TCP port of this machine.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::{Duration, Instant};

use er_servo::link::{Packet, Received, Receiver, Reply};
use rigless::time::VirtualNanos;

use crate::terminal::Terminal;

/// The board waits when it is this far ahead of the clock.
const AHEAD: Duration = Duration::from_millis(2);
/// So far the board's time goes on after the last word of a client that waits for nothing, ns: less than half of the silence
/// that the image takes for a lost link ([`er_servo::link::SILENCE_S`]).
const TURN_NS: u64 = 100_000_000;
/// Time between two looks at the port while the board stands still.
const LOOK: Duration = Duration::from_micros(200);

/// What the board's time keeps step with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// The clock, as a drive does: never faster, and time that the emulator was too slow for is not made up.
    Clock,
    /// The client, where there is one: the board runs while it owes an answer, and stands still where the client has been
    /// silent for some time. So a client that a busy machine does not let run is not taken for one that has gone.
    Client,
}

/// The port, and the client that came last.
#[derive(Debug)]
pub struct Port {
    listener: TcpListener,
    pace: Pace,
    client: Option<Turns>,
    /// An instant of the clock and of the board that belong together.
    anchor: Option<(Instant, VirtualNanos)>,
}

/// A client, and whose turn it is to speak.
#[derive(Debug)]
struct Turns {
    stream: TcpStream,
    /// When it last spoke.
    heard: VirtualNanos,
    questions: Receiver,
    answers: Receiver,
    /// Sequence number of its last packet, until that is answered.
    owed: Option<u32>,
}

impl Turns {
    fn new(stream: TcpStream, now: VirtualNanos) -> std::io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, heard: now, questions: Receiver::default(), answers: Receiver::default(), owed: None })
    }

    fn asks(&mut self, bytes: &[u8], now: VirtualNanos) {
        self.heard = now;
        for byte in bytes {
            if let Some(Ok(Received::Message(packet))) = self.questions.push_any::<Packet>(*byte) {
                self.owed = Some(packet.sequence);
            }
        }
    }

    fn is_answered(&mut self, byte: u8) {
        if let Some(Ok(Received::Message(reply))) = self.answers.push_any::<Reply>(byte)
            && self.owed == Some(reply.sequence)
        {
            self.owed = None;
        }
    }

    fn may_run(&self, now: VirtualNanos) -> bool {
        self.owed.is_some() || now.0 < self.heard.0 + TURN_NS
    }
}

impl Port {
    /// Opens a port on the loopback address, and nowhere else: the link is neither encrypted nor does it ask who is there.
    /// 0 takes any that is free.
    ///
    /// # Errors
    ///
    /// A port that is taken.
    pub fn open(port: u16, pace: Pace) -> std::io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, pace, client: None, anchor: None })
    }

    /// Where it is.
    ///
    /// # Errors
    ///
    /// What the system says.
    pub fn address(&self) -> std::io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Carries bytes both ways, and waits where the board is ahead of what it keeps step with.
    pub fn attend(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        self.receive(terminal, now);
        self.send(terminal);
        if self.pace == Pace::Client && self.client.is_some() {
            while self.client.as_ref().is_some_and(|client| !client.may_run(now)) {
                std::thread::sleep(LOOK);
                self.receive(terminal, now);
            }
            self.anchor = None;
        } else {
            self.keep_step_with_clock(now);
        }
    }

    fn keep_step_with_clock(&mut self, now: VirtualNanos) {
        let (began, from) = *self.anchor.get_or_insert_with(|| (Instant::now(), now));
        let (board, clock) = (Duration::from_nanos(now.0 - from.0), began.elapsed());
        if board > clock + AHEAD {
            std::thread::sleep(board - clock);
        } else if clock > board + AHEAD {
            // To make time up would show the client a drive that is faster than its clock, and that finds it silent too soon.
            self.anchor = None;
        }
    }

    fn receive(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        if let Ok((stream, _)) = self.listener.accept() {
            self.client = Turns::new(stream, now).ok();
        }
        let Some(client) = &mut self.client else { return };
        let mut bytes = [0; 1024];
        match client.stream.read(&mut bytes) {
            Ok(count) if count > 0 => {
                client.asks(&bytes[..count], now);
                terminal.send(now, &bytes[..count]);
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            _ => self.client = None,
        }
    }

    fn send(&mut self, terminal: &mut Terminal) {
        let waiting = &terminal.from_image;
        let sent = match self.client.as_mut().map(|client| client.stream.write(waiting)) {
            Some(Ok(count)) => count,
            Some(Err(error)) if error.kind() == ErrorKind::WouldBlock => 0,
            // As on a wire without a listener.
            _ => waiting.len(),
        };
        for byte in terminal.from_image.drain(..sent) {
            if let Some(client) = &mut self.client {
                client.is_answered(byte);
            }
        }
    }
}
