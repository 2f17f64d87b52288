//! Effects that no motion of a machine tells apart, by this crate's own physics.

use crate::seal::{Concealed, Truth};

/// Without a damper the recorded torque is all that drives the axis. Shifting it, or the position, or the stamps of either by the same time
/// gives the same two columns: the balance has no other clock. A commanded field is one.
const ONE_TIME: [&str; 3] = ["torque_delay", "sensor_latency", "channel_skew"];

/// Whether no motion of the machine tells an effect that is concealed in it from another of this name.
///
/// Beside the three times, an asymmetry of the dry level is a constant torque wherever the axis moves: level + half forward and level -
/// half backward are the level, and half of the difference against the motion's positive direction. Only at rest are they two.
pub fn indistinct(truth: &Truth, concealed: &Concealed, other: &str) -> bool {
    let own = concealed.id.as_str();
    let has_fluid = truth.machine.as_ref().is_none_or(|machine| machine.fluid);
    let of_level = |effect: &Concealed| {
        let slope = effect.parameters.iter().find(|(name, _)| name.starts_with("viscous_difference"));
        effect.id == "friction_asymmetry" && slope.is_none_or(|(_, value)| *value == 0.0)
    };
    match other {
        _ if own == other => false,
        _ if ONE_TIME.contains(&own) && ONE_TIME.contains(&other) => !has_fluid,
        "torque_offset" => of_level(concealed),
        "friction_asymmetry" => own == "torque_offset",
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::physics::Physics;
    use crate::rotor::{Command, Rotor};

    /// Positions of an axis under a swinging torque, and what is late in its log.
    fn moved(physics: &Physics, latency_rows: usize) -> Vec<f64> {
        let mut rotor = Rotor::new(physics, 1e-5);
        let mut all = Vec::new();
        for row in 0..3000 {
            all.push(rotor.position_rad());
            let torque_nm = 5.0 * (0.013 * f64::from(row)).sin();
            (0..50).for_each(|_| rotor.step(&Command { torque_nm, ..Command::default() }));
        }
        let first = vec![0.0; latency_rows];
        first.into_iter().chain(all).take(3000).collect()
    }

    fn largest(one: &[f64], other: &[f64]) -> f64 {
        one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_machine_itself_says_what_is_one() {
        let mut nominal = Physics::nominal();
        nominal.drive.delay_s = 0.0;
        let changed = |change: fn(&mut Physics)| {
            let mut physics = nominal.clone();
            change(&mut physics);
            physics
        };
        let late = moved(&changed(|p| p.drive.delay_s = 0.002), 0);
        // Four rows of half a millisecond.
        assert!(largest(&late, &moved(&nominal, 4)) < 1e-12);
        assert!(largest(&late, &moved(&nominal, 0)) > 1e-4);
        // While it moves: the axis is pushed through its turns too fast to stop there.
        let asymmetry = moved(&changed(|p| p.friction.difference_nm = 0.2), 0);
        let offset = moved(&changed(|p| p.drive.offset_nm = -0.1), 0);
        let nothing = largest(&asymmetry, &moved(&nominal, 0));
        let apart = largest(&asymmetry, &offset);
        println!("an asymmetry moves the axis by {nothing} rad, an offset in its place by {apart} rad of that");
        assert!(apart < 0.02 * nothing, "{apart} {nothing}");
    }

    #[test]
    fn the_table_knows_a_damper_and_a_slope() {
        let effect = |id: &str, slope: f64| Concealed {
            id: id.to_owned(),
            in_vocabulary: true,
            size: 1.0,
            strength: 1.0,
            parameters: vec![("viscous_difference_nm_s_rad".to_owned(), slope)],
        };
        let with_damper = crate::drawn::Case::draw(0).unwrap().truth;
        let truth = |fluid: bool| {
            let mut truth = with_damper.clone();
            truth.machine.as_mut().unwrap().fluid = fluid;
            truth
        };
        assert!(indistinct(&truth(false), &effect("torque_delay", 0.0), "channel_skew"));
        assert!(!indistinct(&truth(true), &effect("torque_delay", 0.0), "channel_skew"));
        assert!(!indistinct(&truth(false), &effect("torque_delay", 0.0), "torque_lag"));
        assert!(indistinct(&truth(true), &effect("friction_asymmetry", 0.0), "torque_offset"));
        assert!(!indistinct(&truth(true), &effect("friction_asymmetry", 0.1), "torque_offset"));
        assert!(!indistinct(&truth(true), &effect("inertia", 0.0), "inertia"));
    }
}
