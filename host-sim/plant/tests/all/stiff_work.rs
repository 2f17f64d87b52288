//! What a simulation costs may not depend on how stiff a machine is: a fit tries any of them, and has a minute.
//!
//! Counted as [`Mechanics::counting`] counts, which does not depend on the computer.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use plant::effects::{Shaft, Stribeck};
use plant::{Command, Er, Mechanics, Model, State, Timeline};

/// Rows of the log: 15 s at 5 ms.
const ROWS: usize = 3000;
const ROW_S: f64 = 0.005;

/// Work of a row, at most, of a law with a closed form: a few steps and events.
const MOST_CLOSED: f64 = 10.0;
/// Of one without, whose steps have a shortest length, counted eightfold: 400 a row, 12e6 for the log; a second
/// at the 0.1 us of one that was measured.
const MOST_GENERAL: f64 = 4000.0;

/// Work a row of `model` under torques that reverse it, N m (N).
fn work_a_row(model: &Model, amplitude: f64) -> f64 {
    let times_s: Vec<f64> = (0..ROWS).map(|row| row as f64 * ROW_S).collect();
    let command = |t_s: &f64| Command::new(amplitude * (3.0 * t_s).sin(), 1.0 + (2.0 * t_s).cos());
    let commands: Vec<Command> = times_s.iter().map(command).collect();
    let timeline = Timeline::new(model, &times_s, &commands, &Command::default()).unwrap();
    let work = Arc::new(AtomicU64::new(0));
    let mut positions = vec![0.0; ROWS];
    let mechanics = Mechanics::new(model).unwrap().counting(&work);
    mechanics.simulate(&timeline, 0.0, State::default(), &times_s, &mut positions).unwrap();
    assert!(positions.iter().all(|position| position.is_finite()), "{model:?}");
    work.load(Ordering::Relaxed) as f64 / ROWS as f64
}

#[test]
fn stiffness_costs_no_time() {
    let paper = || Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() };
    let drag = |inertia: f64| Model { viscous: 1724.0, coulomb: 0.1, torque_delay_s: 0.005, ..Model::new(inertia) };
    let shaft =
        |resonance_hz: f64, gap: f64| Some(Shaft { resonance_hz, damping_ratio: 0.03, inertia_ratio: 0.5, gap });
    let er = |stiffness: f64| Some(Er { preyield_stiffness: Some(stiffness), ..Er::new(0.0704, 0.470, 0.002, 0.003) });
    let stribeck = |velocity: f64| Some(Stribeck { excess: 0.4, velocity });
    let mut machines: Vec<(String, Model, f64, f64)> = Vec::new();
    for inertia in [1e-12, 1e-9, 1e-6, 1e-3, 0.5] {
        machines.push((format!("1724 N s/m on {inertia} kg"), drag(inertia), 520.0, MOST_CLOSED));
        let lag = Model { torque_lag_s: 0.002, ..drag(inertia) };
        machines.push((format!("the same behind a lag, {inertia} kg"), lag, 520.0, MOST_CLOSED));
        let quadratic = Model { quadratic_drag: 1.0, ..drag(inertia) };
        machines.push((format!("the same with quadratic drag, {inertia} kg"), quadratic, 520.0, MOST_GENERAL));
    }
    for stiffness in [1e3, 1e6, 1e9, 1e12] {
        let bristle = Model { presliding_stiffness: Some(stiffness), ..paper() };
        machines.push((format!("bristle of {stiffness:e} N m/rad"), bristle, 2.6, MOST_GENERAL));
        machines.push((
            format!("fluid of {stiffness:e} N m/rad"),
            Model { er: er(stiffness), ..paper() },
            2.6,
            MOST_GENERAL,
        ));
    }
    for resonance_hz in [60.0, 1e3, 1e4, 1e5] {
        for gap in [0.0, 1e-3, 1e-6, 1e-9, 1e-12] {
            let model = Model { shaft: shaft(resonance_hz, gap), ..paper() };
            machines.push((format!("shaft of {resonance_hz:e} Hz, gap {gap:e} rad"), model, 2.6, MOST_GENERAL));
        }
    }
    for velocity in [1e-2, 1e-5, 1e-9] {
        machines.push((
            format!("Stribeck at {velocity:e} rad/s"),
            Model { stribeck: stribeck(velocity), ..paper() },
            2.6,
            MOST_GENERAL,
        ));
    }
    let mut slow = Vec::new();
    for (name, model, amplitude, most) in machines {
        let begun = std::time::Instant::now();
        let work = work_a_row(&model, amplitude);
        println!("{name}: {work:.1} a row, {:.3} s", begun.elapsed().as_secs_f64());
        if work > most {
            slow.push((name, work));
        }
    }
    assert!(slow.is_empty(), "{slow:?}");
}
