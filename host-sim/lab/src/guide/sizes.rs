//! Each effect of the vocabulary from nothing to clear.

use diagnosis::effects::{Effect, Excitation, Size};
use diagnosis::physics::Physics;

/// An effect whose size can be turned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sized {
    pub id: &'static str,
    /// Which reported parameter tells the size.
    pub told_by: usize,
    /// Fitted values at a size: 0 is the default machine (or the limit towards it), 1 is clear in any recording.
    pub at: fn(f64) -> Vec<f64>,
    /// False where no size is the default machine: the model is another one.
    pub nested: bool,
}

/// A machine along a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure<'a> {
    pub(super) physics: &'a Physics,
    pub(super) excitation: &'a Excitation,
}

impl Sized {
    /// Fitted values that are to another machine and motion what 1 is to the `default` ones, within the bounds of physics.
    pub(super) fn clear_on(&self, effect: &Effect, here: Measure<'_>, default: Measure<'_>) -> Vec<f64> {
        let [nothing, clear] = [0.0, 1.0].map(self.at);
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
            let value = match self.nested && from.is_finite() && nothing[index].is_finite() {
                true => from + (clear[index] - nothing[index]) * times,
                false => clear[index] * times,
            };
            value.clamp(ranges[index].low, ranges[index].high)
        };
        (0..clear.len()).map(value).collect()
    }
}

const fn sized(id: &'static str, at: fn(f64) -> Vec<f64>) -> Sized {
    Sized { id, told_by: 0, at, nested: true }
}

const fn another(id: &'static str, at: fn(f64) -> Vec<f64>) -> Sized {
    Sized { id, told_by: 0, at, nested: false }
}

/// All but events and wrong samples, which no experiment brings back. In the order of the vocabulary.
pub(super) static SIZES: [Sized; 36] = [
    sized("field_dead_time", |f| vec![0.002 + 0.003 * f]),
    sized("field_lag", |f| vec![0.003 + 0.005 * f]),
    Sized { told_by: 1, ..sized("field_lag_asymmetry", |f| vec![0.003, 0.003 + 0.009 * f]) },
    sized("field_slew_limit", |f| vec![200.0 / f]),
    sized("field_gain", |f| vec![1.0 - 0.15 * f]),
    sized("er_strength", |f| vec![1.0 - 0.2 * f]),
    sized("er_drift", |f| vec![-0.03 * f]),
    sized("er_preyield", |f| vec![300.0 / f]),
    another("viscosity_dead_time", |_| vec![0.005]),
    another("viscosity_lag", |_| vec![0.005]),
    sized("coulomb_friction", |f| vec![0.763 + 0.19 * f]),
    sized("viscous_friction", |f| vec![0.15 * f]),
    sized("stribeck_friction", |f| vec![0.5 * f, 0.1]),
    sized("friction_asymmetry", |f| vec![0.3 * f, 0.0]),
    sized("presliding", |f| vec![400.0 / f]),
    sized("torque_gain", |f| vec![1.0 - 0.07 * f]),
    sized("torque_offset", |f| vec![0.2 * f]),
    sized("torque_saturation", |f| vec![30.0 / (1.0 + 1.5 * f)]),
    sized("torque_deadband", |f| vec![0.3 * f]),
    sized("torque_delay", |f| vec![0.005 + 0.0012 * f]),
    sized("torque_lag", |f| vec![0.0015 * f]),
    sized("cogging", |f| vec![14.0, 0.16 * f, 0.25 * f]),
    sized("inertia", |f| vec![0.075 + 0.007 * f]),
    sized("gravity_load", |f| vec![0.46 * f, 0.2 * f]),
    sized("spring_load", |f| vec![0.6 * f]),
    // A shaft of no compliance would resonate at infinity; 40 Hz with a load that grows.
    Sized { told_by: 2, ..sized("compliance", |f| vec![40.0, 0.03, 0.4 * f]) },
    sized("backlash", |f| vec![0.004 * f, 60.0, 0.05, 0.4 * f]),
    Sized { told_by: 1, ..sized("vibration", |f| vec![17.3, 0.25 * f, 0.0]) },
    sized("quadratic_drag", |f| vec![0.1 * f]),
    sized("resolver_eccentricity", |f| vec![4.0, 0.0018 * f, 0.001 * f]),
    sized("sensor_latency", |f| vec![0.0012 * f]),
    sized("load_dependent_friction", |f| vec![0.1 * f]),
    sized("torque_ripple", |f| vec![14.0, 0.06 * f, 0.05 * f]),
    sized("temperature_yield", |f| vec![0.02 * f, 0.1]),
    sized("field_kinetics", |f| vec![f, f]),
    sized("er_flow", |f| vec![0.05 * f, 0.5]),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::Guide;
    use super::*;
    use diagnosis::effects::{VOCABULARY, find};

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
        for sized in &SIZES {
            let clear = sized.clear_on(find(sized.id).unwrap(), default, default);
            let expected = (sized.at)(1.0);
            let alike = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs();
            assert!(clear.iter().zip(&expected).all(alike), "{}: {clear:?}, not {expected:?}", sized.id);
        }
        let strong = Excitation { torque_rms: 20.0, ..excitation.clone() };
        let mut physics = guide.nominal.clone();
        (physics.model.coulomb, physics.model.inertia) = (5.0, 0.75);
        let on = Measure { physics: &physics, excitation: &strong };
        let clear = |id: &str| {
            let sized = SIZES.iter().find(|sized| sized.id == id).unwrap();
            sized.clear_on(find(id).unwrap(), on, default)[0]
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
        assert_eq!(shown, SIZES.iter().map(|sized| sized.id).collect::<Vec<_>>());
    }
}
