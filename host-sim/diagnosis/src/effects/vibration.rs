//! A steady external sine, its phase free in each recording.

use crate::physics::Tone;

use super::{Columns, Effect, PLAIN, Size, free, shown_by, sized};

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "vibration",
    sentence: "The machine is shaken at one frequency: a pump, a fan, a neighbour on the same frame.",
    parameters: &[free(0.1, 1000.0, 0.1), sized(Size::Torque, -1e2, 1e2, 0.05)],
    starts: |_, e| {
        let values = |tone: &Tone| {
            let phasors = tone.phasors.iter().flat_map(|&(sine, cosine)| [sine, cosine]);
            std::iter::once(tone.frequency_hz).chain(phasors).collect()
        };
        // Where the motion repeats itself, so does all that depends on the state.
        let own = |tone: &&Tone| !e.repetitions.iter().any(|motion| motion.has_harmonic(tone.frequency_hz));
        e.tones.iter().filter(own).map(values).collect()
    },
    put: |p, v| {
        p.tone =
            Some(Tone { frequency_hz: v[0], phasors: v[1..].chunks_exact(2).map(|pair| (pair[0], pair[1])).collect() })
    },
    report: |v| {
        let power: f64 = v[1..].iter().map(|x| x * x).sum();
        vec![v[0], (power / (v.len() - 1) as f64 * 2.0).sqrt()]
    },
    // Its phase differs from recording to recording and is no part of a model.
    fitted: |_, _| None,
    columns: Columns::Each,
    recording_of: |_, index| index.checked_sub(1).map(|index| index / 2),
    looked_at: |e| e.looked_at[1],
    leading: &[1],
    example: shown_by(1, |f| vec![17.3, 0.25 * f, 0.0]),
    ..PLAIN
};
