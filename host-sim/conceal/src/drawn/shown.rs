//! How much of its effects the motion shows that is recorded: sizes are sought on a motion without them, and of other references, where a
//! push meets a rotor that moves and in the one that is recorded a rotor that friction holds.

use super::Base;
use super::information::{Deviations, Motion};
use super::setting::Setting;
use super::sizes::{Chosen, LEAST, weighed};
use crate::physics::Physics;

/// An effect that shows in less than one over this of the multiple that was drawn, or in more than so many times it, is drawn again.
const AS_DRAWN: f64 = 2.0;

/// A machine at work.
pub(super) struct AtWork<'a> {
    pub(super) setting: &'a Setting,
    /// Without effects, with noise.
    pub(super) physics: &'a Physics,
    pub(super) noise: Deviations,
    /// Of the machine with all effects.
    pub(super) base: &'a Base,
    /// Root mean square of the noise in windows of the recording that is held out.
    pub(super) noise_left: [f64; 2],
}

impl AtWork<'_> {
    /// The effects with the multiples that the motion shows; none where one of them is far from what was drawn.
    pub(super) fn shown(&self, mut chosen: Chosen) -> Option<Chosen> {
        let multiples: Vec<f64> = (0..chosen.effects.len()).map(|at| self.multiple(&chosen, at)).collect();
        for (one, shown) in chosen.effects.iter_mut().zip(multiples) {
            let share = shown / one.multiple;
            if !(AS_DRAWN.recip()..=AS_DRAWN).contains(&share) {
                return None;
            }
            one.multiple = shown;
        }
        Some(chosen)
    }

    /// Of one effect beside the others.
    fn multiple(&self, chosen: &Chosen, at: usize) -> f64 {
        let one = &chosen.effects[at];
        let mut others = chosen.clone();
        others.effects.remove(at);
        let (with, without) = (chosen.conceal(self.physics), others.conceal(self.physics));
        let nominal: Vec<Physics> = (0..self.base.rows.len()).map(|index| self.base.physics(&without, index)).collect();
        let rows = nominal.iter().zip(&self.base.rows);
        let motions: Vec<Motion<'_>> =
            rows.map(|(nominal, rows)| Motion::new(self.setting, nominal, rows, self.noise)).collect();
        let column = |index: usize, motion: &Motion<'_>| motion.column(&self.base.physics(&with, index));
        let (_, excess) = weighed(&motions, &column, &self.noise_left, one.source.is_event());
        // Nothing smaller than the least size that is of use is detectable.
        (excess.min((one.size / LEAST).powi(2)) * one.share).sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::SeedableRng;
    use rand::rngs::StdRng;

    use super::super::motion::Sample;
    use super::super::sizes::{One, Source};
    use super::*;
    use crate::catalogue::ENTRIES;
    use crate::rotor::Command;

    /// A push, so many times the dry friction, of a rotor at rest.
    fn pushed(times: f64) -> Option<Chosen> {
        let mut setting = Setting::draw(false, &mut StdRng::seed_from_u64(2));
        setting.physics.friction.coulomb_nm = 1.0;
        let still = |seq: usize| Sample {
            seq,
            t_s: seq as f64 * setting.period_s,
            reference: 0.0,
            reading: 0.0,
            command: Command::default(),
            mode: er_servo::Mode::Off,
            drive: 0.0,
            position: 0.0,
            speed: 0.0,
        };
        let rows = vec![(0..200).map(still).collect::<Vec<Sample>>(); 3];
        let source = Source::Vocabulary(ENTRIES.iter().find(|entry| entry.id == "disturbance_pulse").unwrap());
        let values = vec![20.0 * setting.period_s, 50.0 * setting.period_s, times];
        let noise = Deviations { white: 0.1, coloured: None, sensor: 0.0 };
        let base = Base { seed: 1, rows };
        let at_work = AtWork { setting: &setting, physics: &setting.physics, noise, base: &base, noise_left: [1.0; 2] };
        let one = One { source, values, multiple: 1.0, size: 1.0, share: 1.0 };
        let shown = at_work.multiple(&Chosen { effects: vec![one.clone()] }, 0);
        at_work.shown(Chosen { effects: vec![One { multiple: 0.7 * shown, ..one }] })
    }

    #[test]
    fn a_push_that_friction_holds_is_drawn_again_and_one_that_it_does_not_is_told_as_it_shows() {
        assert!(pushed(0.9).is_none());
        let beyond = pushed(3.0).unwrap();
        // Two of three N m over 50 rows beside a noise of 0.1 N m are an information of 20,000: 34 times what can just be told.
        assert!((beyond.effects[0].multiple / 34.3 - 1.0).abs() < 0.2, "{}", beyond.effects[0].multiple);
    }
}
