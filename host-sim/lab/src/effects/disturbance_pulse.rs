//! One external push: a constant torque from start for a duration, in one recording.

use super::{Effect, Pulse, Size, always, fixed, free, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "disturbance_pulse",
    sentence: "Something pushed the machine once: a hand, a collision, a snagging cable.",
    parameters: &[fixed(), free(0.0, 1e6, 0.01), free(2e-3, 1e3, 0.01), sized(Size::Torque, -1e2, 1e2, 0.05)],
    applies: always,
    starts: |_, e| {
        e.pulses
            .iter()
            .map(|pulse| vec![pulse.recording as f64, pulse.start_s, pulse.duration_s, pulse.amplitude])
            .collect()
    },
    put: |p, v| p.pulses.push(Pulse { recording: v[0] as usize, start_s: v[1], duration_s: v[2], amplitude: v[3] }),
    report: |v| v[1..].to_vec(),
};
