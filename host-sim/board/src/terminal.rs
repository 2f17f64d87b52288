//! The far end of the command link: bytes to the image at the line's rate, bytes from it.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// Time of one byte at 921600 baud, 8N1, ns.
pub const BYTE_NS: u64 = 10_851;

/// A serial terminal.
#[derive(Debug, Default)]
pub struct Terminal {
    to_image: VecDeque<(u64, u8)>,
    last_due_ns: u64,
    /// Bytes the image sent.
    pub from_image: Vec<u8>,
}

impl Terminal {
    /// Puts bytes on the line, back to back from `now` on or after what is still going out.
    pub fn send(&mut self, now: VirtualNanos, bytes: &[u8]) {
        for byte in bytes {
            self.last_due_ns = self.last_due_ns.max(now.0) + BYTE_NS;
            self.to_image.push_back((self.last_due_ns, *byte));
        }
    }

    /// When the next byte is due, if any.
    pub fn next_due(&self) -> Option<VirtualNanos> {
        self.to_image.front().map(|(due_ns, _)| VirtualNanos(*due_ns))
    }
}

// Nothing is kept: a run on this board is never resumed from a snapshot.
impl Store for Terminal {}

impl Peer for Terminal {
    fn receive(&mut self, word: u16, _context: &mut Timeline<'_, '_>) {
        self.from_image.push(word as u8);
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        let (due_ns, byte) = *self.to_image.front()?;
        if due_ns > now.0 {
            return None;
        }
        self.to_image.pop_front();
        Some(byte.into())
    }
}
