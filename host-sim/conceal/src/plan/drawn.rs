//! The drawn plan: how many cases of each arm, and in which order.

use super::{Arm, Decoy, families_of};
use crate::Error;

/// What a case of the drawn plan is before anything is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// Arm.
    pub arm: Arm,
    /// How many effects of the vocabulary.
    pub effects: usize,
    /// How the log misleads, if it does.
    pub decoy: Option<Decoy>,
    /// Families that an effect outside the vocabulary may be of.
    pub families: Vec<&'static str>,
}

/// Cases of each arm in a round of the drawn plan, [`ROUND`] together. Half as many outside and removed again as the 2 % of the pass
/// line take to be excluded at 95 % in two rounds; of the pairs two in five have both effects at twice the detectable size.
const QUOTAS: [(Arm, usize); 9] = [
    (Arm::Clean, 50),
    (Arm::Decoy, 30),
    (Arm::Single, 90),
    (Arm::Pair, 60),
    (Arm::Triple, 24),
    (Arm::Removed, 64),
    (Arm::Outside, 64),
    (Arm::Poor, 10),
    (Arm::Controller, 8),
];
/// Cases in a round of the drawn plan.
pub const ROUND: u64 = 400;
/// Steps through the arms that seeds take: without a common divisor with the round, so that any stretch of seeds has all arms.
const STRIDE: u64 = 149;
impl Drawn {
    /// The blueprint of a seed.
    ///
    /// # Errors
    /// As [`families_of`].
    pub fn of(seed: u64) -> Result<Self, Error> {
        let mut place = (seed % ROUND * STRIDE % ROUND) as usize;
        let (mut arm, mut within) = (Arm::Clean, 0);
        for (candidate, cases) in QUOTAS {
            if place < cases {
                (arm, within) = (candidate, place);
                break;
            }
            place -= cases;
        }
        Self::of_arm(arm, within, seed)
    }

    /// The blueprint of a case within an arm, with the families of a seed's round.
    ///
    /// # Errors
    /// As [`families_of`].
    pub fn of_arm(arm: Arm, within: usize, seed: u64) -> Result<Self, Error> {
        let decoys = [Decoy::TwelveBits, Decoy::Gaps, Decoy::Nominal];
        let decoy = (arm == Arm::Decoy).then(|| decoys[within % decoys.len()]);
        let effects = match (arm, decoy) {
            (Arm::Clean | Arm::Controller | Arm::Outside, _) => 0,
            (Arm::Pair, _) => 2,
            (Arm::Triple, _) => 3,
            (_, None | Some(Decoy::Nominal)) => 1,
            // Every other misleading log has an effect that it must not hide.
            _ => within / decoys.len() % 2,
        };
        let families = if arm == Arm::Outside { families_of(seed)? } else { Vec::new() };
        Ok(Self { arm, effects, decoy, families })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_round_of_the_drawn_plan_has_its_quotas_and_so_has_any_stretch_of_it_nearly() {
        let count = |seeds: std::ops::Range<u64>, arm: Arm| seeds.filter(|&s| Drawn::of(s).unwrap().arm == arm).count();
        assert_eq!(QUOTAS.iter().map(|(_, cases)| *cases as u64).sum::<u64>(), ROUND);
        for (arm, cases) in QUOTAS {
            assert_eq!(count(0..ROUND, arm), cases, "{arm}");
            let (few, share) = (count(30_000..30_100, arm), cases as f64 / 4.0);
            assert!((few as f64 - share).abs() <= 3.0, "{arm}: {few} of {share}");
        }
    }
}
