//! Models and commands the tests of the physics share.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, dead_code)]

use plant::effects::{Asymmetry, Gravity, Harmonic, Pulse, Shaft, Stribeck, Vibration, Warming};
use plant::er_fluid::{FlowCurve, Kinetics};
use plant::{Command, Er, FieldResponse, FluidResponse, Model, Plant, State};

pub const TICK_S: f64 = 0.0005;
/// Rise and fall that are faster in a strong field.
pub const KINETICS: Kinetics = Kinetics { rise_exponent: 2.0, fall_exponent: 0.5 };
/// A fluid that thins under shear.
pub const FLOW: FlowCurve = FlowCurve { consistency: 0.3, consistency_per_kv_mm: 0.1, exponent: 0.5 };

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
        ("kinetics", field(|f| f.kinetics = KINETICS)),
        ("kinetics behind a slew limit", field(|f| (f.slew_kv_mm_s, f.kinetics) = (Some(120.0), KINETICS))),
        ("flow curve", field(|f| f.flow = Some(FLOW))),
        ("Bingham's flow curve", field(|f| f.flow = Some(FlowCurve { exponent: 1.0, ..FLOW }))),
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
        ("load_dependent_friction", Model { load_friction: 0.15, ..nominal() }),
        (
            "temperature_viscosity",
            Model { viscous: 0.4, viscous_warming: Some(Warming { per_j: 0.3, cooling_per_s: 2.0 }), ..nominal() },
        ),
        ("temperature_yield", fluid(|er| er.warming = Some(Warming { per_j: 0.3, cooling_per_s: 2.0 }))),
        ("torque_ripple", Model { torque_ripple: vec![Harmonic { amplitude: 0.1, ..harmonic }], ..nominal() }),
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

/// Several effects at once, so that their events meet in one segment.
pub fn combinations() -> Vec<(&'static str, Model)> {
    let harmonic = Harmonic { amplitude: 0.2, order: 24.0, phase_rad: 0.4 };
    let shaft = Shaft { resonance_hz: 80.0, damping_ratio: 0.05, inertia_ratio: 0.3, gap: 0.001 };
    let stribeck = Some(Stribeck { excess: 0.3, velocity: 0.05 });
    let slow = |er: &mut Er| {
        er.response = FluidResponse::Field(FieldResponse {
            dead_time_s: 0.0013,
            slew_kv_mm_s: Some(80.0),
            rise_s: 0.002,
            fall_s: 0.004,
            ..FieldResponse::default()
        });
        (er.drift_per_s, er.preyield_stiffness) = (0.05, Some(150.0));
    };
    let lag = FluidResponse::ViscosityLag { lag_s: 0.004, torque_limit: 2.5 };
    vec![
        (
            "dry",
            Model {
                stribeck,
                asymmetry: Asymmetry { coulomb: 0.2, viscous: 0.0 },
                torque_lag_s: 0.001,
                cogging: vec![harmonic],
                gravity: Some(Gravity { amplitude: 0.5, phase_rad: 0.2 }),
                vibration: Some(Vibration { frequency_hz: 21.0, amplitude: 0.5, phase_rad: 0.0 }),
                ..fluid(slow)
            },
        ),
        ("bristles", Model { presliding_stiffness: Some(300.0), stribeck, cogging: vec![harmonic], ..fluid(slow) }),
        (
            "warm bristles under load",
            Model {
                presliding_stiffness: Some(300.0),
                load_friction: 0.1,
                torque_ripple: vec![harmonic],
                viscous: 0.1,
                viscous_warming: Some(Warming { per_j: 0.2, cooling_per_s: 1.0 }),
                ..fluid(|er| {
                    slow(er);
                    er.warming = Some(Warming { per_j: 0.1, cooling_per_s: 0.5 });
                })
            },
        ),
        ("load behind a lag", Model { load_friction: 0.2, torque_lag_s: 0.002, ..nominal() }),
        // Without the gap: impacts make a difference grow whatever the friction.
        (
            "warm load on a shaft",
            Model {
                shaft: Some(Shaft { gap: 0.0, ..shaft }),
                load_friction: 0.1,
                viscous: 0.1,
                viscous_warming: Some(Warming { per_j: 0.2, cooling_per_s: 1.0 }),
                ..nominal()
            },
        ),
        ("loose load", Model { shaft: Some(shaft), stribeck, cogging: vec![harmonic], ..fluid(slow) }),
        ("loose load on bristles", Model { shaft: Some(shaft), presliding_stiffness: Some(300.0), ..fluid(slow) }),
        ("viscosity behind a gap", Model { shaft: Some(shaft), torque_lag_s: 0.001, ..with_response(lag) }),
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

/// Effects at size zero (nominal to the bit) or nearly zero, which run through the general path all the same.
pub fn vanishing_effects() -> Vec<(&'static str, Model, f64)> {
    let tiny = 1e-200;
    let harmonic = |amplitude| Harmonic { amplitude, order: 120.0, phase_rad: 0.4 };
    let shaft = |inertia_ratio| Shaft { resonance_hz: 60.0, damping_ratio: 0.03, inertia_ratio, gap: 0.0 };
    let vibration = |amplitude| Some(Vibration { frequency_hz: 35.0, amplitude, phase_rad: 1.0 });
    vec![
        ("no slew limit", field(|f| f.slew_kv_mm_s = None), 0.0),
        (
            "no flow",
            field(|f| f.flow = Some(FlowCurve { consistency: 0.0, consistency_per_kv_mm: 0.0, ..FLOW })),
            1e-12,
        ),
        ("kinetics of no lag", field(|f| (f.rise_s, f.fall_s, f.kinetics) = (0.003, 0.003, Kinetics::default())), 0.0),
        ("equal lags", field(|f| f.fall_s = 0.003), 0.0),
        ("unit gain", fluid(|er| (er.field_gain, er.scale) = (1.0, 1.0)), 0.0),
        ("no drift", fluid(|er| er.drift_per_s = 0.0), 0.0),
        ("tiny drift", fluid(|er| er.drift_per_s = tiny), 1e-12),
        ("no Stribeck", Model { stribeck: Some(Stribeck { excess: 0.0, velocity: 0.1 }), ..nominal() }, 0.0),
        ("tiny Stribeck", Model { stribeck: Some(Stribeck { excess: tiny, velocity: 0.1 }), ..nominal() }, 1e-12),
        ("symmetric friction", Model { asymmetry: Asymmetry::default(), ..nominal() }, 0.0),
        ("no deadband", Model { torque_deadband: 0.0, ..nominal() }, 0.0),
        ("no torque lag", Model { torque_lag_s: 0.0, ..nominal() }, 0.0),
        ("far limit", Model { torque_limit: Some(1e6), ..nominal() }, 0.0),
        ("no cogging", Model { cogging: vec![harmonic(0.0)], ..nominal() }, 0.0),
        ("tiny cogging", Model { cogging: vec![harmonic(tiny)], ..nominal() }, 1e-12),
        ("tiny gravity", Model { gravity: Some(Gravity { amplitude: tiny, phase_rad: 0.1 }), ..nominal() }, 1e-12),
        ("tiny spring", Model { spring_stiffness: tiny, ..nominal() }, 1e-12),
        ("tiny load friction", Model { load_friction: tiny, ..nominal() }, 1e-12),
        ("no ripple", Model { torque_ripple: vec![harmonic(0.0)], ..nominal() }, 0.0),
        ("tiny ripple", Model { torque_ripple: vec![harmonic(tiny)], ..nominal() }, 1e-12),
        (
            "warming of nothing",
            Model { viscous_warming: Some(Warming { per_j: 1.0, cooling_per_s: 1.0 }), ..nominal() },
            1e-12,
        ),
        ("tiny warming", fluid(|er| er.warming = Some(Warming { per_j: tiny, cooling_per_s: 1.0 })), 1e-12),
        ("tiny quadratic drag", Model { quadratic_drag: tiny, ..nominal() }, 1e-12),
        ("no load", Model { shaft: Some(shaft(0.0)), ..nominal() }, 0.0),
        ("tiny load", Model { shaft: Some(shaft(1e-14)), ..nominal() }, 1e-12),
        ("tiny vibration", Model { vibration: vibration(tiny), ..nominal() }, 1e-12),
        (
            "no pulse",
            Model { pulses: vec![Pulse { start_s: 0.1, duration_s: 0.1, amplitude: 0.0 }], ..nominal() },
            1e-14,
        ),
    ]
}

/// Kinetic and stored energy of a state, J.
pub fn energy(model: &Model, x: &State) -> f64 {
    let mut energy = 0.5 * model.inertia * x.velocity * x.velocity;
    if let Some(shaft) = model.shaft {
        let ratio = shaft.inertia_ratio;
        let (motor, load) = (model.inertia / (1.0 + ratio), model.inertia * ratio / (1.0 + ratio));
        let stiffness = motor * load / model.inertia * (std::f64::consts::TAU * shaft.resonance_hz).powi(2);
        let bent = (x.twist.abs() - 0.5 * shaft.gap).max(0.0);
        let load_speed = x.velocity + x.twist_rate;
        energy = 0.5 * (motor * x.velocity * x.velocity + load * load_speed * load_speed + stiffness * bent * bent);
    }
    for cogging in &model.cogging {
        energy += cogging.amplitude / cogging.order * (cogging.order * x.position + cogging.phase_rad).cos();
    }
    if let Some(gravity) = model.gravity {
        energy -= gravity.amplitude * (x.position + gravity.phase_rad).cos();
    }
    energy += 0.5 * model.spring_stiffness * x.position * x.position;
    if let Some(stiffness) = model.presliding_stiffness {
        energy += 0.5 * x.bristle_torque * x.bristle_torque / stiffness;
    }
    if let Some(stiffness) = model.er.as_ref().and_then(|er| er.preyield_stiffness) {
        energy += 0.5 * x.spring_torque * x.spring_torque / stiffness;
    }
    energy
}
