//! The machine's numbers as the plant's model.

use plant::effects::{Asymmetry, Gravity, Harmonic, Pulse, Shaft, Stribeck, Vibration};
use plant::sensor::SensorModel;
use plant::{Er, FieldResponse, FluidResponse, Model};

use crate::effects::{self, Damper, Physics, Viscosity};

/// The model that simulates recording number `recording`; pushes and phases differ from one to the next.
// Over 40 lines: one line for each field of the model.
pub fn model(physics: &Physics, recording: usize) -> Model {
    let finite = |value: f64| value.is_finite().then_some(value);
    Model {
        coulomb: physics.coulomb,
        viscous: physics.viscous,
        torque_gain: physics.torque_gain,
        torque_offset: physics.torque_offset,
        torque_limit: finite(physics.torque_limit),
        torque_deadband: physics.torque_deadband,
        torque_delay_s: physics.torque_delay_s,
        torque_lag_s: physics.torque_lag_s,
        er: physics.damper.as_ref().map(damper),
        stribeck: (physics.stribeck_excess > 0.0)
            .then_some(Stribeck { excess: physics.stribeck_excess, velocity: physics.stribeck_velocity }),
        asymmetry: asymmetry(physics),
        presliding_stiffness: finite(physics.presliding),
        quadratic_drag: physics.quadratic,
        cogging: physics.cogging.iter().map(harmonic).collect(),
        gravity: physics.gravity.map(|load| {
            // The plant's weight acts as -amplitude sin(th + phase).
            let acting = harmonic(&load);
            Gravity { amplitude: acting.amplitude, phase_rad: acting.phase_rad + std::f64::consts::PI }
        }),
        spring_stiffness: physics.spring,
        shaft: physics.load.map(|load| Shaft {
            resonance_hz: load.resonance_hz,
            damping_ratio: load.damping_ratio,
            inertia_ratio: load.inertia_ratio,
            gap: load.gap,
        }),
        pulses: physics
            .pulses
            .iter()
            .filter(|pulse| pulse.recording == recording)
            .map(|pulse| Pulse { start_s: pulse.start_s, duration_s: pulse.duration_s, amplitude: pulse.amplitude })
            .collect(),
        vibration: physics.vibration.as_ref().and_then(|vibration| {
            vibration.phasors.get(recording).map(|&(sine, cosine)| Vibration {
                frequency_hz: vibration.frequency_hz,
                amplitude: sine.hypot(cosine),
                phase_rad: cosine.atan2(sine),
            })
        }),
        sensor: SensorModel {
            latency_s: physics.latency_s,
            eccentricity: physics.eccentricity.iter().map(harmonic).collect(),
        },
        ..Model::new(physics.inertia)
    }
}

/// Friction never drives: a difference is at most twice the mean.
fn asymmetry(physics: &Physics) -> Asymmetry {
    let within = |difference: f64, mean: f64| {
        let most = 2.0 * mean.max(0.0);
        difference.clamp(-most, most)
    };
    Asymmetry {
        coulomb: within(physics.asymmetry, physics.coulomb),
        viscous: within(physics.asymmetry_viscous, physics.viscous),
    }
}

fn harmonic(of: &effects::Harmonic) -> Harmonic {
    Harmonic { amplitude: of.sine.hypot(of.cosine), order: of.order, phase_rad: of.cosine.atan2(of.sine) }
}

fn damper(of: &Damper) -> Er {
    let torque_limit = Er::largest_torque(of.a, of.b);
    let response = match of.viscosity {
        Some(Viscosity::DeadTime(dead_time_s)) => FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit },
        Some(Viscosity::Lag(lag_s)) => FluidResponse::ViscosityLag { lag_s, torque_limit },
        None => FluidResponse::Field(FieldResponse {
            dead_time_s: of.dead_time_s,
            slew_kv_mm_s: of.slew_kv_mm_s.is_finite().then_some(of.slew_kv_mm_s),
            rise_s: of.rise_s,
            fall_s: of.fall_s,
        }),
    };
    Er {
        response,
        field_gain: of.gain,
        scale: of.scale,
        drift_per_s: of.drift_per_s,
        preyield_stiffness: of.preyield.is_finite().then_some(of.preyield),
        ..Er::new(of.a, of.b, 0.0, 0.0)
    }
}
