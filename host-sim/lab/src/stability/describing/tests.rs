#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::stability::case::NormalisedGains;

fn er_off(gains_delay_s: f64, torque_delay_s: f64, coulomb_nm: f64) -> NonlinearLoop<'static> {
    NonlinearLoop {
        inertia_kg_m2: 0.075,
        torque_delay_s,
        coulomb_nm,
        gains: NormalisedGains::PAPER.physical(0.075, gains_delay_s),
        torque_limit_nm: 30.0,
        damper: None,
    }
}

/// The field-off loop from rest at `angle_rad`: amplitude of the angle over the last fifth of `end_s`. Friction that
/// the control torque does not exceed holds the rotor.
fn amplitude_of_a_run(system: &NonlinearLoop<'_>, angle_rad: f64, end_s: f64) -> f64 {
    let dt = 5e-6;
    let delay = (system.torque_delay_s / dt).round() as usize;
    let steps = (end_s / dt) as usize;
    let (mut x, mut v) = (angle_rad, 0.0_f64);
    let mut torques = Vec::with_capacity(steps);
    let mut largest = 0.0_f64;
    for k in 0..steps {
        let wanted = -system.gains.k_p_nm_rad * x - system.gains.k_d_nm_s_rad * v;
        torques.push(wanted.clamp(-system.torque_limit_nm, system.torque_limit_nm));
        let u = if k >= delay { torques[k - delay] } else { torques[0] };
        let free = v + dt * u / system.inertia_kg_m2;
        let friction = dt * system.coulomb_nm / system.inertia_kg_m2;
        v = if free.abs() <= friction { 0.0 } else { free - friction * free.signum() };
        x += dt * v;
        if k > steps / 5 * 4 {
            largest = largest.max(x.abs());
        }
    }
    largest
}

#[test]
fn saturation_has_its_known_values() {
    assert_eq!(saturation(1.0, 2.0), 1.0);
    assert!((saturation(2.0, 1.0) - 0.608_998).abs() < 1e-5);
    assert!((saturation(1e6, 1.0) - 4.0 / (PI * 1e6)).abs() < 1e-15);
}

#[test]
fn a_loop_that_is_stable_without_friction_has_no_cycle() {
    assert!(er_off(0.005, 0.005, 0.763).limit_cycles(Search::SERVO).is_empty());
    assert!(er_off(0.002, 0.0044, 0.763).limit_cycles(Search::SERVO).is_empty());
}

#[test]
fn an_unstable_loop_has_the_two_cycles_a_simulation_has() {
    // Gains for 2 ms on a plant of 6 ms: unstable. Friction stops small swings, the torque limit the large ones.
    let system = er_off(0.002, 0.006, 0.763);
    let cycles = system.limit_cycles(Search::SERVO);
    assert_eq!(cycles.len(), 2, "{cycles:?}");
    let (inner, outer) = (cycles[0], cycles[1]);
    assert!(!inner.stable && outer.stable, "{cycles:?}");
    assert!(amplitude_of_a_run(&system, 0.5 * inner.amplitude_rad, 1.0) < 0.6 * inner.amplitude_rad);
    for start in [2.0 * inner.amplitude_rad, 3.0 * outer.amplitude_rad] {
        let run = amplitude_of_a_run(&system, start, 3.0);
        println!("from {start:.4} rad: {run:.5} rad by a run, {:.5} by harmonic balance", outer.amplitude_rad);
        assert!((run / outer.amplitude_rad - 1.0).abs() < 0.1, "{run} by a run, {outer:?}");
    }
}
