//! Any smooth torque over position: a Fourier series over the travel.

use super::super::{Columns, Effect, PLAIN, Size, fixed, sized};

/// Pairs of sine and cosine: enough for a torque that bends three times over the travel.
const PAIRS: usize = 3;
/// Longest wave in travels: with the travel itself as period both of its ends would have the same torque.
const LONGEST: f64 = 1.5;

/// The hypothesis.
pub static EFFECT: Effect = Effect {
    id: "position_series",
    sentence: "some smooth torque over position",
    parameters: &[fixed(), sized(Size::Torque, -1e2, 1e2, 0.05)],
    applies: |_, e| e.travel > 0.0,
    starts: |_, e| {
        let mut values = vec![0.0; 1 + 2 * PAIRS];
        values[0] = std::f64::consts::TAU / (LONGEST * e.travel);
        vec![values]
    },
    put: |p, v| {
        for (pair, of) in v[1..].chunks_exact(2).enumerate() {
            let order = v[0] * (pair + 1) as f64;
            let (amplitude, phase_rad) = (of[0].hypot(of[1]), of[1].atan2(of[0]));
            p.model.cogging.push(plant::effects::Harmonic { order, amplitude, phase_rad });
        }
    },
    columns: Columns::Each,
    nameable: false,
    ..PLAIN
};
