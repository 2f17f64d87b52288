//! The user at the far end of the command link: commands at their instants, answers as they come.

use std::collections::VecDeque;

use er_servo::link::{Answer, Command, Reply};
use rigless::time::VirtualNanos;
use wire::client::Client;

use crate::terminal::Terminal;

/// An unanswered hello is said again after this, ns.
const PATIENCE_NS: u64 = 20_000_000;

/// A user with a list of commands.
#[derive(Debug, Default)]
pub struct Host {
    client: Client,
    waiting: VecDeque<(VirtualNanos, Command)>,
    open: bool,
    said_hello: Option<VirtualNanos>,
    read: usize,
    /// The bytes of the last command that was sent.
    pub last_sent: Vec<u8>,
    /// Every answer, with the instant it was complete.
    pub replies: Vec<(VirtualNanos, Reply)>,
}

impl Host {
    /// Sends a command at an instant; a session is opened before the first one.
    pub fn at(&mut self, at: VirtualNanos, command: Command) {
        let place = self.waiting.partition_point(|(when, _)| *when <= at);
        self.waiting.insert(place, (at, command));
    }

    /// Keeps what is recorded over the link, in [`Self::recorded`].
    pub fn keep_recorded(&mut self) {
        self.client.keep_recorded();
    }

    /// What of recordings has come over the link.
    ///
    /// # Errors
    ///
    /// A recording of another release.
    pub fn recorded(&mut self) -> Result<Vec<wire::log::Entry>, wire::log::Error> {
        self.client.recorded()
    }

    /// Says hello, as another client would; what is sent from then on is of the session that is answered.
    pub fn say_hello(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        terminal.send(now, &self.client.send(Command::Hello).1);
    }

    /// Sends what is due and reads what has come.
    pub fn attend(&mut self, terminal: &mut Terminal, now: VirtualNanos) {
        let heard: Vec<u8> = terminal.from_image.get(self.read..).map(<[u8]>::to_vec).unwrap_or_default();
        self.read = terminal.from_image.len();
        for byte in heard {
            if let Some(reply) = self.client.receive(byte) {
                self.open |= matches!(reply.answer, Answer::Hello { .. });
                self.replies.push((now, reply));
            }
        }
        while self.waiting.front().is_some_and(|(when, _)| *when <= now) {
            if !self.open {
                if self.said_hello.is_none_or(|at| now.0 > at.0 + PATIENCE_NS) {
                    terminal.send(now, &self.client.send(Command::Hello).1);
                    self.said_hello = Some(now);
                }
                return;
            }
            if let Some((_, command)) = self.waiting.pop_front() {
                self.last_sent = self.client.send(command).1;
                terminal.send(now, &self.last_sent);
            }
        }
    }

    /// The last status that was answered.
    pub fn status(&self) -> Option<er_servo::link::Status> {
        self.replies.iter().rev().find_map(|(_, reply)| match reply.answer {
            Answer::Status(status) => Some(status),
            _ => None,
        })
    }
}
