//! Each effect of the vocabulary from nothing to clear.

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
    use super::super::Guide;
    use super::*;
    use diagnosis::effects::{Excitation, VOCABULARY};

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
