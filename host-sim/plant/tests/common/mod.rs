//! Models and commands the tests of the physics share.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, dead_code)]

use plant::effects::{Asymmetry, Gravity, Harmonic, Pulse, Shaft, Stribeck, Vibration};
use plant::{Command, Er, FieldResponse, FluidResponse, Model, Plant, State};

pub const TICK_S: f64 = 0.0005;

/// The paper's machine with dead time 2 ms and lag 3 ms of the field.
pub fn nominal() -> Model {
    Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() }
}

pub fn with_response(response: FluidResponse) -> Model {
    Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() }
}

pub fn field(change: impl FnOnce(&mut FieldResponse)) -> Model {
    let mut response = FieldResponse::new(0.002, 0.003);
    change(&mut response);
    with_response(FluidResponse::Field(response))
}

pub fn fluid(change: impl FnOnce(&mut Er)) -> Model {
    let mut er = Er::new(0.0704, 0.470, 0.002, 0.003);
    change(&mut er);
    Model { er: Some(er), ..Model::paper() }
}

/// Each effect alone on the paper's machine, at a size that is easy to see.
pub fn every_effect() -> Vec<(&'static str, Model)> {
    let harmonic = Harmonic { amplitude: 0.3, order: 120.0, phase_rad: 0.4 };
    let shaft = Shaft { resonance_hz: 60.0, damping_ratio: 0.03, inertia_ratio: 0.5, gap: 0.0 };
    let torque_limit = 2.5074;
    vec![
        ("nominal", nominal()),
        ("fractional delays", Model { torque_delay_s: 0.00413, ..field(|f| f.dead_time_s = 0.00237) }),
        ("viscosity_dead_time", with_response(FluidResponse::ViscosityDeadTime { dead_time_s: 0.0052, torque_limit })),
        ("viscosity_lag", with_response(FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit })),
        ("viscous", Model { viscous: 0.2, ..nominal() }),
        ("field_lag_asymmetry", field(|f| f.fall_s = 0.008)),
        ("field_slew_limit", field(|f| f.slew_kv_mm_s = Some(120.0))),
        ("field_slew_limit and asymmetry", field(|f| (f.slew_kv_mm_s, f.fall_s) = (Some(40.0), 0.006))),
        ("field_gain", fluid(|er| er.field_gain = 1.2)),
        ("er_strength", fluid(|er| er.scale = 1.3)),
        ("er_drift", fluid(|er| er.drift_per_s = -0.2)),
        ("er_preyield", fluid(|er| er.preyield_stiffness = Some(200.0))),
        ("stribeck", Model { stribeck: Some(Stribeck { excess: 0.4, velocity: 0.05 }), ..nominal() }),
        (
            "friction_asymmetry",
            Model { asymmetry: Asymmetry { coulomb: 0.3, viscous: 0.1 }, viscous: 0.2, ..nominal() },
        ),
        ("presliding", Model { presliding_stiffness: Some(500.0), ..nominal() }),
        ("torque_deadband", Model { torque_deadband: 0.2, ..nominal() }),
        ("torque_lag", Model { torque_lag_s: 0.0015, ..nominal() }),
        ("torque_saturation", Model { torque_limit: Some(3.0), ..nominal() }),
        ("cogging", Model { cogging: vec![harmonic, Harmonic { order: 7.0, ..harmonic }], ..nominal() }),
        ("gravity", Model { gravity: Some(Gravity { amplitude: 1.0, phase_rad: 0.3 }), ..nominal() }),
        ("spring", Model { spring_stiffness: 5.0, ..nominal() }),
        ("quadratic_drag", Model { quadratic_drag: 0.05, ..nominal() }),
        ("compliance", Model { shaft: Some(shaft), ..nominal() }),
        ("backlash", Model { shaft: Some(Shaft { gap: 0.002, ..shaft }), ..nominal() }),
        (
            "disturbance_pulse",
            Model { pulses: vec![Pulse { start_s: 0.1003, duration_s: 0.05, amplitude: 4.0 }], ..nominal() },
        ),
        (
            "vibration",
            Model { vibration: Some(Vibration { frequency_hz: 35.0, amplitude: 0.8, phase_rad: 1.0 }), ..nominal() },
        ),
    ]
}

/// Torques and fields that start, stop, reverse and stick the rotor, with steps of the field.
pub fn command(tick: usize) -> Command {
    let t_s = tick as f64 * TICK_S;
    let torque = 2.6 * (13.0 * t_s).sin() + 1.4 * (31.0 * t_s + 0.3).sin();
    let step = if (t_s * 8.0).fract() < 0.5 { 1.2 } else { 0.0 };
    Command {
        speed_estimate: 0.8 * (13.0 * t_s).cos() + 0.1,
        braking: (t_s * 3.0).fract() < 0.2,
        ..Command::new(torque, step + 0.8 * (1.0 + (23.0 * t_s).sin()))
    }
}

/// States after each of `ticks` commands, with every tick cut into `parts`.
pub fn run(model: &Model, ticks: usize, parts: u32) -> Vec<State> {
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    (0..ticks)
        .map(|tick| {
            let command = command(tick);
            let (from_s, to_s) = (tick as f64 * TICK_S, (tick + 1) as f64 * TICK_S);
            for part in 1..=parts {
                let until_s =
                    if part == parts { to_s } else { from_s + (to_s - from_s) * f64::from(part) / f64::from(parts) };
                plant.advance(&command, until_s).unwrap();
            }
            *plant.state()
        })
        .collect()
}

/// Largest difference of position between two runs.
pub fn distance(left: &[State], right: &[State]) -> f64 {
    left.iter().zip(right).map(|(l, r)| (l.position - r.position).abs()).fold(0.0, f64::max)
}
