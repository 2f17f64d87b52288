//! The host's side of the command link, over any stream of bytes: what is to be sent, and what has come in.

use er_servo::link::{Answer, Command, Malformed, PACKET_BYTES, Packet, Received, Receiver, Reply, encode};

use crate::log::{self, Entry};
use crate::telemetry;

/// A session with a drive. It only makes and reads bytes; who carries them is not its business.
#[derive(Debug, Default)]
pub struct Client {
    session: u32,
    sequence: u32,
    receiver: Receiver,
    /// Answers that were damaged on the way.
    pub damaged: u32,
    /// What of recordings came in; none is kept before somebody wants it.
    recorded: Option<Vec<Entry>>,
    unreadable: Option<log::Error>,
}

impl Client {
    /// A client that has not said hello.
    pub fn new() -> Self {
        Self::default()
    }

    /// A client whose first sequence number is the next one, so that no answer to another client is taken for its own.
    pub fn after(sequence: u32) -> Self {
        Self { sequence, ..Self::default() }
    }

    /// The bytes of a command, and the sequence number its answer will carry.
    pub fn send(&mut self, command: Command) -> (u32, Vec<u8>) {
        self.sequence = self.sequence.wrapping_add(1);
        let packet = Packet { session: self.session, sequence: self.sequence, command };
        let mut bytes = [0; PACKET_BYTES];
        // Every command fits a packet, as the link's own tests show; an empty one is never answered.
        let sent = encode(&packet, &mut bytes).map(<[u8]>::to_vec).unwrap_or_default();
        // A leading zero ends whatever noise the line has picked up before.
        (self.sequence, std::iter::once(0).chain(sent).collect())
    }

    /// Takes a byte; gives the answer that ended with it, if one did. An answer to a hello opens the session.
    pub fn receive(&mut self, byte: u8) -> Option<Reply> {
        match self.receiver.push_any::<Reply>(byte)? {
            Ok(Received::Message(reply)) => {
                if let Answer::Hello { session, .. } = reply.answer {
                    self.session = session;
                }
                Some(reply)
            }
            Ok(Received::Telemetry(packet)) => {
                match (&mut self.recorded, telemetry::entries(packet)) {
                    (Some(recorded), Ok(entries)) => recorded.extend(entries),
                    (Some(_), Err(error)) => self.unreadable = Some(error),
                    (None, _) => {}
                }
                None
            }
            Err(Malformed::Damaged | Malformed::Overlong) => {
                self.damaged += 1;
                self.recorded.iter_mut().for_each(|recorded| recorded.push(Entry::Damaged));
                None
            }
        }
    }

    /// What of recordings has come in since the last time.
    ///
    /// # Errors
    ///
    /// A recording of another release.
    pub fn recorded(&mut self) -> Result<Vec<Entry>, log::Error> {
        match self.unreadable.take() {
            Some(error) => Err(error),
            None => Ok(self.recorded.as_mut().map(std::mem::take).unwrap_or_default()),
        }
    }

    /// Keeps what of recordings comes in from now on.
    pub fn keep_recorded(&mut self) {
        (self.recorded, self.unreadable) = (Some(Vec::new()), None);
    }
}
