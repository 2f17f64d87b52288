#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::stability::case::{Loop, NormalisedGains, Plant};

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

/// Law and fluid step by step, written apart from the module under test: torque opposing the motion.
struct Fluid {
    delay: DamperDelay,
    /// Field, or viscosity and brake torque, as commanded so far and as they act.
    orders: Vec<[f64; 2]>,
    acting: [f64; 2],
}

impl Fluid {
    const A: f64 = 0.0704;
    const B: f64 = 0.470;

    fn torque_nm(&mut self, x: f64, v: f64) -> f64 {
        let w = v.abs();
        let q = (3.675 * w * w - 9.277 * w + 4.010).exp();
        let field = -Self::B / (2.0 * Self::A) + ((Self::B * Self::B / (4.0 * Self::A) + q * w) / Self::A).sqrt();
        let brakes = x.abs() < 0.02 && x * v > 0.0;
        let torque = |e: f64| Self::A * e * e + Self::B * e;
        let (on_field, dead_time_s, lag_s, most_nm) = match self.delay {
            DamperDelay::Field { dead_time_s, lag_s } => (true, dead_time_s, lag_s, f64::INFINITY),
            DamperDelay::Viscosity { dead_time_s, lag_s, bounded } => {
                (false, dead_time_s, lag_s, if bounded { torque(3.5) } else { f64::INFINITY })
            }
        };
        self.orders.push(match (w > 1.5, brakes, on_field) {
            (true, ..) => [0.0, 0.0],
            (_, true, true) => [3.0, 0.0],
            (_, true, false) => [0.0, torque(3.0)],
            (_, _, true) => [field, 0.0],
            (_, _, false) => [q, 0.0],
        });
        let late = self.orders.len().checked_sub(1 + (dead_time_s / STEP_S).round() as usize);
        let order = late.map_or([0.0, 0.0], |k| self.orders[k]);
        for (acting, order) in self.acting.iter_mut().zip(order) {
            *acting = if lag_s > 0.0 { *acting + STEP_S / lag_s * (order - *acting) } else { order };
        }
        if on_field { torque(self.acting[0]) } else { (self.acting[0] * w).min(most_nm) + self.acting[1] }
    }
}

const STEP_S: f64 = 5e-6;

/// The loop run from a swing it has had until then, the fluid at rest: amplitude of the angle over the last fifth of
/// `end_s`. Drag that the control torque does not exceed holds the rotor.
fn amplitude_of_a_run(system: &NonlinearLoop<'_>, mut fluid: Option<Fluid>, swing: Swing, end_s: f64) -> f64 {
    let delay = (system.torque_delay_s / STEP_S).round() as usize;
    let steps = (end_s / STEP_S) as usize;
    let torque = |x: f64, v: f64| {
        let wanted = -system.gains.k_p_nm_rad * x - system.gains.k_d_nm_s_rad * v;
        wanted.clamp(-system.torque_limit_nm, system.torque_limit_nm)
    };
    let before = |steps_ago: usize| {
        let (sin, cos) = (-swing.frequency_rad_s * STEP_S * steps_ago as f64).sin_cos();
        torque(swing.amplitude_rad * sin, swing.speed_rad_s() * cos)
    };
    let mut torques: Vec<f64> = (1..=delay).rev().map(before).collect();
    let (mut x, mut v) = (0.0, swing.speed_rad_s());
    let mut largest = 0.0_f64;
    for k in 0..steps {
        torques.push(torque(x, v));
        let drag = system.coulomb_nm + fluid.as_mut().map_or(0.0, |fluid| fluid.torque_nm(x, v));
        let free = v + STEP_S * torques[k] / system.inertia_kg_m2;
        let drag = STEP_S * drag / system.inertia_kg_m2;
        v = if free.abs() <= drag { 0.0 } else { free - drag * free.signum() };
        x += STEP_S * v;
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
    let run = |factor: f64, of: &LimitCycle| {
        let swing = Swing { amplitude_rad: factor * of.amplitude_rad, frequency_rad_s: of.frequency_rad_s };
        amplitude_of_a_run(&system, None, swing, 3.0)
    };
    assert!(run(0.85, &inner) < inner.amplitude_rad);
    for from in [run(1.15, &inner), run(0.5, &outer), run(3.0, &outer)] {
        println!("{from:.5} rad by a run, {:.5} by harmonic balance", outer.amplitude_rad);
        assert!((from / outer.amplitude_rad - 1.0).abs() < 0.03, "{from} by a run, {outer:?}");
    }
}

fn closed(gains_delay_s: f64, torque_delay_s: f64) -> Loop {
    let plant = Plant { torque_delay_s, q1_nm_s_rad: 0.0, ..crate::stability::testing::plant(0.005, 0.0, 0.0) };
    Loop::new(plant, NormalisedGains::PAPER.physical(0.075, gains_delay_s)).unwrap()
}

/// One count of the resolver: a rotor that moves less is at rest as far as the loop can know.
const COUNT_RAD: f64 = TAU / 491_520.0;

fn strict_brake() -> er_servo::Config {
    er_servo::Config { brake_deadband_rad_s: 0.0, ..er_servo::Config::default() }
}

#[test]
fn the_papers_loop_has_no_limit_cycle_under_any_model() {
    for coulomb_nm in [0.763, 0.0] {
        for found in cycles_by_model(&closed(0.005, 0.005), &strict_brake(), coulomb_nm, Search::SERVO).unwrap() {
            assert!(found.cycles.is_empty() && found.simulated_amplitude_rad < COUNT_RAD, "{found:?}");
        }
    }
}

#[test]
fn cycles_under_the_delay_models_are_those_of_a_simulation() {
    // An unstable plant again; the damper then decides how large a swing friction still stops.
    for (model, delay) in MODELS {
        let Some(delay) = delay else { continue };
        let damper = Damper::new(&strict_brake(), delay).unwrap();
        let system = NonlinearLoop { damper: Some(&damper), ..er_off(0.002, 0.006, 0.763) };
        let cycles = system.limit_cycles(Search::SERVO);
        let run = |swing| {
            let fluid = Fluid { delay, orders: Vec::new(), acting: [0.0; 2] };
            amplitude_of_a_run(&system, Some(fluid), swing, 2.0)
        };
        let run = |amplitude_rad| run(Swing { amplitude_rad, frequency_rad_s: 220.0 });
        let [inner, outer] = match cycles[..] {
            [] => {
                assert!(run(0.03) < 1e-5, "{model}: a cycle in the run, none by harmonic balance");
                continue;
            }
            [inner, outer] => [inner, outer],
            _ => panic!("{model}: {cycles:?}"),
        };
        assert!(!inner.stable && outer.stable, "{model}: {cycles:?}");
        assert!(run(0.15 * inner.amplitude_rad) < 0.15 * inner.amplitude_rad, "{model}: a small swing grew");
        let from_outside = run(0.03);
        println!("{model}: {from_outside:.5} rad by a run, {:.5} by harmonic balance", outer.amplitude_rad);
        assert!((from_outside / outer.amplitude_rad - 1.0).abs() < 0.06, "{model}: {from_outside} rad, {outer:?}");
    }
}

/// Amplitudes of the lasting cycles under every model by harmonic balance, with the drive's delay later by so much, and the
/// amplitude that the flashed law has on the plant.
fn lasting(later_s: f64) -> Vec<(ModelCycles, Vec<f64>)> {
    let found = cycles_by_model(&closed(0.002, 0.006 + later_s), &strict_brake(), 0.763, Search::SERVO).unwrap();
    let amplitudes = |found: &ModelCycles| -> Vec<f64> {
        found.cycles.iter().filter(|cycle| cycle.stable).map(|cycle| cycle.amplitude_rad).collect()
    };
    found.into_iter().map(|found| (found.clone(), amplitudes(&found))).collect()
}

#[test]
fn cycles_are_those_of_the_flashed_law_on_the_plant() {
    // Harmonic balance takes the hold of a command as half a control period T of delay. It is the mean of a delay that runs
    // evenly from 0 to T and is off it by T / 4 on average. These cycles grow by up to 70 % for a millisecond of delay, so that
    // this alone is up to 9 % of an amplitude: of Q lag 5 ms, 10.8 mrad by harmonic balance and 11.5 by the run, 0.11 ms.
    // With a period of 0.25 ms the two are 10.04 and 10.03 mrad.
    let quarter_s = 0.25 * f64::from(strict_brake().period_s);
    let (early, late) = (lasting(-quarter_s), lasting(quarter_s));
    for (at, (found, lasting)) in lasting(0.0).into_iter().enumerate() {
        let ModelCycles { model, cycles, simulated_amplitude_rad: run } = found;
        println!("{model}: {run:.5} rad on the plant, {lasting:.5?} by harmonic balance");
        // Where the dividing and the lasting cycle have almost met, a first harmonic cannot say whether they have.
        let about_to_meet = cycles.len() == 2 && cycles[0].amplitude_rad > 0.75 * cycles[1].amplitude_rad;
        let at_rest = run < COUNT_RAD && (lasting.is_empty() || about_to_meet);
        let held = early[at].1.last().zip(late[at].1.last()).is_some_and(|(low, high)| (*low..=*high).contains(&run));
        assert!(
            at_rest || held || lasting.iter().any(|a| (a / run - 1.0).abs() < 0.06),
            "{model}: {run} rad, {cycles:?}"
        );
    }
}
