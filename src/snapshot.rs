//! The law's state as bytes: a recording begins with one, so that its replay begins where the recording did.

use crate::law::resolver::Tracking;
use crate::units::{Counts, ResolverCode};
use crate::{Faults, State, Supervisor};

/// Length of an encoded [`State`].
pub const STATE_BYTES: usize = 37;

/// Why bytes are no [`State`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SnapshotError {
    /// Not [`STATE_BYTES`] bytes.
    Length,
    /// A tag this version does not know, at this offset.
    Tag(usize),
}

impl core::fmt::Display for SnapshotError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length => write!(f, "a state snapshot has {STATE_BYTES} bytes"),
            Self::Tag(offset) => write!(f, "unknown tag at byte {offset} of the state snapshot"),
        }
    }
}

impl core::error::Error for SnapshotError {}

impl State {
    /// The state as little-endian bytes.
    pub fn encode(&self) -> [u8; STATE_BYTES] {
        let (tag, code, position, moved) = match self.tracking {
            Tracking::Lost => (0, ResolverCode(0), Counts(0), 0),
            Tracking::Located { code, position } => (1, code, position, 0),
            Tracking::Moving { code, position, moved_counts } => (2, code, position, moved_counts),
        };
        let (drive, ticks, faults) = match self.supervisor {
            Supervisor::Boot { ticks } => (0, ticks, Faults::empty()),
            Supervisor::Ready => (1, 0, Faults::empty()),
            Supervisor::Running => (2, 0, Faults::empty()),
            Supervisor::Fault { faults } => (3, 0, faults),
            Supervisor::Stopping { faults } => (4, 0, faults),
        };
        let mut bytes = [0; STATE_BYTES];
        bytes[0] = tag;
        bytes[1] = drive;
        bytes[2..4].copy_from_slice(&code.0.to_le_bytes());
        bytes[4..8].copy_from_slice(&position.0.to_le_bytes());
        bytes[8..12].copy_from_slice(&moved.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.speed_rad_s.to_le_bytes());
        bytes[16..20].copy_from_slice(&self.torque_nm.to_le_bytes());
        bytes[20..24].copy_from_slice(&self.still_ticks.to_le_bytes());
        bytes[24..28].copy_from_slice(&ticks.to_le_bytes());
        bytes[28..32].copy_from_slice(&faults.bits().to_le_bytes());
        bytes[32..36].copy_from_slice(&self.stop_ticks.to_le_bytes());
        bytes[36] = u8::from(self.homed);
        bytes
    }

    /// The state those bytes stand for.
    ///
    /// # Errors
    /// A wrong length or an unknown tag; any other bytes are a state, if an odd one, and [`crate::step()`] takes it.
    pub fn decode(bytes: &[u8]) -> Result<Self, SnapshotError> {
        let bytes: &[u8; STATE_BYTES] = bytes.try_into().map_err(|_| SnapshotError::Length)?;
        let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let half = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
        let (code, position, moved_counts) = (ResolverCode(half(2)), Counts(word(4) as i32), word(8) as i32);
        let tracking = match bytes[0] {
            0 => Tracking::Lost,
            1 => Tracking::Located { code, position },
            2 => Tracking::Moving { code, position, moved_counts: moved_counts.clamp(-4096, 4096) },
            _ => return Err(SnapshotError::Tag(0)),
        };
        let supervisor = match bytes[1] {
            0 => Supervisor::Boot { ticks: word(24) },
            1 => Supervisor::Ready,
            2 => Supervisor::Running,
            3 => Supervisor::Fault { faults: Faults::from_bits_truncate(word(28)) },
            4 => Supervisor::Stopping { faults: Faults::from_bits_truncate(word(28)) },
            _ => return Err(SnapshotError::Tag(1)),
        };
        Ok(Self {
            tracking,
            speed_rad_s: f32::from_bits(word(12)),
            torque_nm: f32::from_bits(word(16)),
            still_ticks: word(20),
            supervisor,
            stop_ticks: word(32),
            homed: bytes[36] != 0,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn round_trips() {
        let states = [
            State::default(),
            State::running_at(Counts(-98_765)),
            State { supervisor: Supervisor::Fault { faults: Faults::FIELD_OVER }, ..State::default() },
            State {
                tracking: Tracking::Moving { code: ResolverCode(4000), position: Counts(12), moved_counts: -3 },
                speed_rad_s: -1.25,
                torque_nm: 7.0,
                still_ticks: 3,
                supervisor: Supervisor::Boot { ticks: 9 },
                ..State::default()
            },
            State {
                supervisor: Supervisor::Stopping { faults: Faults::LINK_LOST },
                stop_ticks: 5,
                homed: true,
                ..State::default()
            },
        ];
        for state in states {
            assert_eq!(State::decode(&state.encode()).unwrap(), state);
        }
        assert_eq!(State::decode(&[0; 3]), Err(SnapshotError::Length));
        assert_eq!(State::decode(&[9; STATE_BYTES]), Err(SnapshotError::Tag(0)));
    }
}
