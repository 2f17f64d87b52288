//! One external push: a constant torque from start for a duration, in one recording.

use plant::effects::Pulse;

use crate::physics::Push;

use super::{Columns, Effect, PLAIN, Size, fixed, free, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "disturbance_pulse",
    sentence: "Something pushed the machine once: a hand, a collision, a snagging cable.",
    parameters: &[fixed(), free(0.0, 1e6, 0.01), free(2e-3, 1e3, 0.01), sized(Size::Torque, -1e2, 1e2, 0.05)],
    starts: |_, e| {
        // A rotor at rest answers a push only beyond what holds it.
        let sizes = [0.1, 1.0, 3.0].map(|size| size * e.torque_rms);
        let values = |&(recording, pulse): &(usize, Pulse)| {
            sizes.map(|size| vec![recording as f64, pulse.start_s, pulse.duration_s, size * pulse.amplitude])
        };
        e.pulses.iter().flat_map(values).collect()
    },
    put: |p, v| {
        let pulse = Pulse { start_s: v[1], duration_s: v[2].max(0.0), amplitude: v[3] };
        p.pushes.push(Push { recording: v[0] as usize, pulse });
    },
    report: |v| v[1..].to_vec(),
    fitted: |v, recording| Some([&[recording? as f64], v].concat()),
    repeats: true,
    span: |v| Some((v[0] as usize, v[1], v[1] + v[2])),
    recording_of: |v, _| Some(v[0] as usize),
    looked_at: |e| e.looked_at[2],
    leading: &[2],
    columns: Columns::Scaled(3),
    once: true,
    ..PLAIN
};
