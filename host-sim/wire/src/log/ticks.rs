//! The ticks of one recording, in order.

/// Frames further ahead than this are damaged, and not the first after a gap: at 2 kHz, more than four hours.
const LONGEST_GAP: u32 = 1 << 25;

/// Which ticks came and which are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ticks {
    next: u32,
    /// Ticks that came.
    pub taken: u64,
    /// Ticks that are missing before the last one that came.
    pub lost: u64,
    /// Places where ticks are missing.
    pub gaps: u64,
}

impl Ticks {
    /// Before the tick `first`, with which the recording begins.
    pub fn from(first: u32) -> Self {
        Self { next: first, taken: 0, lost: 0, gaps: 0 }
    }

    /// Takes the tick of the number `seq`; not one that has been there, nor one that is too far ahead to be true.
    pub fn take(&mut self, seq: u32) -> bool {
        let missing = seq.wrapping_sub(self.next);
        if missing > LONGEST_GAP {
            return false;
        }
        self.next = seq.wrapping_add(1);
        self.taken += 1;
        self.lost += u64::from(missing);
        self.gaps += u64::from(missing > 0);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_ticks_are_counted_across_the_end_of_the_count() {
        let mut ticks = Ticks::from(u32::MAX - 1);
        let taken = [u32::MAX - 1, u32::MAX, 2, 3, 1, 3, 1 << 31, 4].map(|seq| ticks.take(seq));
        assert_eq!(taken, [true, true, true, true, false, false, false, true]);
        assert_eq!((ticks.taken, ticks.lost, ticks.gaps), (5, 2, 1));
    }
}
