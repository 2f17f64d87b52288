//! Counts unwrapped across pole pairs, with jumps refused.

use crate::units::{Counts, ResolverCode};
use crate::{Faults, Params};

/// What is known of the rotor's motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Tracking {
    /// No reading yet: the next one sets the position.
    #[default]
    Lost,
    /// A position; the way of the last tick is unknown.
    Located { code: ResolverCode, position: Counts },
    /// A position and the way of the last tick, counts.
    Moving { code: ResolverCode, position: Counts, moved_counts: i32 },
}

impl Tracking {
    /// The position, counts; 0 while it is lost.
    pub(crate) fn position(self) -> Counts {
        match self {
            Self::Lost => Counts(0),
            Self::Located { position, .. } | Self::Moving { position, .. } => position,
        }
    }

    /// Calls the position by another name; the motion goes on. Whether there is a position at all.
    pub(crate) fn rename(&mut self, name: Counts) -> bool {
        match self {
            Self::Lost => return false,
            Self::Located { position, .. } | Self::Moving { position, .. } => *position = name,
        }
        true
    }

    /// The way of the last tick, counts; 0 while it is unknown.
    pub(crate) fn moved_counts(self) -> i32 {
        match self {
            Self::Moving { moved_counts, .. } => moved_counts,
            Self::Lost | Self::Located { .. } => 0,
        }
    }

    /// Takes a valid reading. A reading further away, or with a greater change of speed, than the machine can reach is a
    /// jump: it is not taken, and the position stays where it was.
    ///
    /// The first reading is the position within its pole pair: which pair it is cannot be known before homing.
    pub(crate) fn read(self, params: &Params, code: ResolverCode) -> (Self, Faults) {
        let code = ResolverCode(code.0 & 0x0fff);
        let (last, position, before) = match self {
            Self::Lost => {
                return (Self::Located { code, position: Counts(i32::from(code.0)) }, Faults::empty());
            }
            Self::Located { code: last, position } => (last, position, None),
            Self::Moving { code: last, position, moved_counts } => (last, position, Some(moved_counts)),
        };
        let moved_counts = code.since(last);
        let too_fast = moved_counts.abs() > params.jump_counts;
        let too_sudden = before.is_some_and(|before| (moved_counts - before).abs() > params.jump_counts_change);
        if too_fast || too_sudden {
            return (self, Faults::RESOLVER_JUMP);
        }
        match position.0.checked_add(moved_counts) {
            Some(counts) => (Self::Moving { code, position: Counts(counts), moved_counts }, Faults::empty()),
            // 4,369 revolutions from zero the counter is full; to wrap would throw the axis round.
            None => (self, Faults::RESOLVER_JUMP),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn at(position: i32) -> ResolverCode {
        ResolverCode((position & 0x0fff) as u16)
    }

    proptest! {
        #[test]
        fn a_motion_the_machine_can_make_is_followed_exactly(
            start in 0..4096_i32,
            changes in proptest::collection::vec(-127..=127_i32, 1..400),
        ) {
            let params = Params::new(&Config::default()).unwrap();
            let (mut position, mut speed) = (start, 0);
            let mut tracking = Tracking::Lost.read(&params, at(start)).0;
            for change in changes {
                speed = (speed + change).clamp(-1700, 1700);
                position += speed;
                let (next, faults) = tracking.read(&params, at(position));
                prop_assert!(faults.is_empty());
                prop_assert_eq!(next.position(), Counts(position));
                tracking = next;
            }
        }

        #[test]
        fn any_code_sequence_is_taken_or_refused(codes: Vec<u16>) {
            let params = Params::new(&Config::default()).unwrap();
            let mut tracking = Tracking::Lost;
            for code in codes {
                let before = tracking.position();
                let (next, faults) = tracking.read(&params, ResolverCode(code));
                prop_assert!(faults.is_empty() || next.position() == before);
                tracking = next;
            }
        }
    }

    #[test]
    fn a_jump_is_refused_and_leaves_the_position() {
        let params = Params::new(&Config::default()).unwrap();
        let located = Tracking::Lost.read(&params, at(100)).0;
        let moving = located.read(&params, at(101)).0;
        assert_eq!(moving.read(&params, at(500)), (moving, Faults::RESOLVER_JUMP));
        // From an unknown speed only the speed limit holds.
        assert!(located.read(&params, at(500)).1.is_empty());
        assert_eq!(located.read(&params, at(100 + 1800)).1, Faults::RESOLVER_JUMP);
    }

    #[test]
    fn the_end_of_the_counter_is_a_fault_not_a_wrap() {
        let params = Params::new(&Config::default()).unwrap();
        let end = Tracking::Located { code: at(i32::MAX), position: Counts(i32::MAX) };
        assert_eq!(end.read(&params, at(0)).1, Faults::RESOLVER_JUMP);
    }
}
