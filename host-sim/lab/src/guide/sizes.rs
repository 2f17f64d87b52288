//! Each effect of the vocabulary from nothing to clear.

use diagnosis::effects::{Effect, Example, Excitation, Size, VOCABULARY};
use diagnosis::physics::Physics;

/// An effect whose size can be turned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sized {
    pub(super) effect: &'static Effect,
    pub(super) example: Example,
}

/// All that an experiment can show, in the order of the vocabulary.
pub(super) fn all() -> Vec<Sized> {
    VOCABULARY.iter().filter_map(|&effect| Some(Sized { effect, example: effect.example? })).collect()
}

/// A machine along a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure<'a> {
    pub(super) physics: &'a Physics,
    pub(super) excitation: &'a Excitation,
}

impl Sized {
    /// Fitted values that are to another machine and motion what 1 is to the `default` ones, within the bounds of physics.
    pub(super) fn clear_on(&self, here: Measure<'_>, default: Measure<'_>) -> Vec<f64> {
        let Self { effect, example: Example { at, nested, .. } } = *self;
        let [nothing, clear] = [0.0, 1.0].map(at);
        let ranges = effect.ranges(clear.len(), here.physics, here.excitation);
        let value = |index: usize| {
            let parameter = effect.parameter(index);
            // Orders are of a turn; along a line as many of them are on the way.
            let is_order = !parameter.free && !parameter.searched;
            let size = if is_order && here.excitation.linear { Size::Travel } else { parameter.size };
            let of = |on: Measure<'_>| size.of(on.physics, on.excitation);
            let times = if is_order { of(default) / of(here) } else { of(here) / of(default) };
            let neutral = (effect.neutral)(here.physics);
            let from = if clear.len() == 1 { neutral } else { nothing[index] * times };
            let value = match nested && from.is_finite() && nothing[index].is_finite() {
                true => from + (clear[index] - nothing[index]) * times,
                false => clear[index] * times,
            };
            value.clamp(ranges[index].low, ranges[index].high)
        };
        (0..clear.len()).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::Guide;
    use super::*;
    use diagnosis::effects::find;

    #[test]
    fn on_the_default_machine_and_motion_sizes_are_as_they_stand_and_grow_with_it() {
        let guide = Guide::default();
        let excitation = Excitation {
            torque_rms: 2.0,
            torque_peak: 30.0,
            travel: 1.8,
            speed_peak: 8.0,
            period_s: 5e-4,
            duration_s: 8.0,
            field_peak: 3.5,
            ..Excitation::default()
        };
        let default = Measure { physics: &guide.nominal, excitation: &excitation };
        for sized in all() {
            let clear = sized.clear_on(default, default);
            let expected = (sized.example.at)(1.0);
            let alike = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs();
            assert!(clear.iter().zip(&expected).all(alike), "{}: {clear:?}, not {expected:?}", sized.effect.id);
        }
        let strong = Excitation { torque_rms: 20.0, ..excitation.clone() };
        let mut physics = guide.nominal.clone();
        (physics.model.coulomb, physics.model.inertia) = (5.0, 0.75);
        let on = Measure { physics: &physics, excitation: &strong };
        let clear = |id: &str| {
            let effect = find(id).unwrap();
            Sized { effect, example: effect.example.unwrap() }.clear_on(on, default)[0]
        };
        assert!((clear("coulomb_friction") - (5.0 + 1.9)).abs() < 1e-9, "ten times the torque");
        assert!((clear("inertia") - (0.75 + 0.07)).abs() < 1e-9, "ten times the body");
    }

    #[test]
    fn every_effect_that_an_experiment_can_show_has_a_size() {
        let guide = Guide::default();
        let excitation =
            Excitation { field_peak: 3.5, recordings: 1, travel: 1.8, speed_peak: 8.0, ..Excitation::default() };
        let can_have = VOCABULARY.iter().filter(|effect| (effect.applies)(&guide.nominal, &excitation));
        let shown = can_have.filter(|effect| !effect.once && !effect.changes_samples_only());
        let shown: Vec<&str> = shown.map(|effect| effect.id).collect();
        assert_eq!(shown, all().iter().map(|sized| sized.effect.id).collect::<Vec<_>>());
    }
}
