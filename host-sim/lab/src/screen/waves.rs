//! Sines and cosines along the recordings, kept from one trial to the next: most trials only change their amplitudes.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::motion::Motion;
use super::problem::Equation;
use crate::effects::{Harmonic, Physics};

/// Sine and cosine in each cell of a recording.
pub(crate) type Wave = Vec<(f64, f64)>;

/// What a wave repeats over.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Over {
    /// Periods per revolution (rad per m of travel).
    Position(f64),
    /// Hz.
    Time(f64),
}

impl Over {
    /// In the middle of each cell.
    fn wave(self, motion: &Motion) -> Wave {
        match self {
            Self::Position(order) => motion.cell_position.iter().map(|&q| (order * q).sin_cos()).collect(),
            Self::Time(frequency_hz) => {
                motion.t_s.windows(2).map(|pair| (TAU * frequency_hz * 0.5 * (pair[0] + pair[1])).sin_cos()).collect()
            }
        }
    }
}

/// The waves of the torques that act on a machine from outside: orders of cogging, gravity, vibration.
#[derive(Debug, Clone, Default)]
pub(crate) struct Waves {
    over: Vec<Over>,
    /// Of each recording, in that order.
    recordings: Vec<Vec<Arc<Wave>>>,
}

impl Waves {
    /// Those of a machine over some recordings; what is known already is taken over.
    pub(crate) fn of(physics: &Physics, motions: &[Motion], known: Option<&Self>) -> Self {
        let harmonics = physics.cogging.iter().chain(&physics.gravity).map(|harmonic| Over::Position(harmonic.order));
        let vibration = physics.vibration.iter().map(|vibration| Over::Time(vibration.frequency_hz));
        let over: Vec<Over> = harmonics.chain(vibration).collect();
        let wave = |recording: usize, over: Over, motion: &Motion| {
            let found = known.and_then(|known| known.find(recording, over));
            found.unwrap_or_else(|| Arc::new(over.wave(motion)))
        };
        let each = motions.iter().enumerate();
        let recordings = each.map(|(index, motion)| over.iter().map(|&over| wave(index, over, motion)).collect());
        Self { recordings: recordings.collect(), over }
    }

    fn find(&self, recording: usize, over: Over) -> Option<Arc<Wave>> {
        let place = self.over.iter().position(|known| *known == over)?;
        Some(Arc::clone(self.recordings.get(recording)?.get(place)?))
    }

    /// Of one recording: orders of cogging, gravity, vibration, as far as the machine has them.
    pub(crate) fn along(&self, recording: usize) -> &[Arc<Wave>] {
        self.recordings.get(recording).map_or(&[], Vec::as_slice)
    }
}

/// Mean accelerations of a sine and a cosine of the measured position in each equation.
#[derive(Debug, Clone)]
pub(crate) struct ErrorWave {
    order: f64,
    accelerations: Arc<Vec<(f64, f64)>>,
}

impl ErrorWave {
    /// For the order of a harmonic; what is known already is taken over.
    pub(crate) fn of(error: &Harmonic, motions: &[Motion], equations: &[Equation], known: Option<&Self>) -> Self {
        if let Some(known) = known.filter(|known| known.order == error.order) {
            return known.clone();
        }
        let over = |function: fn(f64) -> f64| -> Vec<Vec<f64>> {
            motions.iter().map(|m| m.position.iter().map(|&q| function(error.order * q)).collect()).collect()
        };
        let (sines, cosines) = (over(f64::sin), over(f64::cos));
        let of = |equation: &Equation, waves: &[Vec<f64>]| equation.row.acceleration(&waves[equation.recording]);
        let accelerations = equations.iter().map(|equation| (of(equation, &sines), of(equation, &cosines))).collect();
        Self { order: error.order, accelerations: Arc::new(accelerations) }
    }

    /// Acceleration of the error in one equation.
    pub(crate) fn acceleration(&self, error: &Harmonic, equation: usize) -> f64 {
        let (sine, cosine) = self.accelerations[equation];
        error.sine * sine + error.cosine * cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::testing::{machine, recording};
    use crate::effects::Vibration;

    #[test]
    fn a_wave_is_made_anew_only_where_its_order_or_frequency_is_another() {
        let nominal = Physics::nominal(&machine());
        let motions = [Motion::new(&recording(&nominal, 0.05, 1.0, 1), &nominal, 1.3e-5)];
        let with = |sine: f64, frequency_hz: f64| {
            let cogging = vec![Harmonic { order: 7.0, sine, cosine: 0.0 }];
            let vibration = Some(Vibration { frequency_hz, phasors: vec![(sine, 0.0)] });
            Physics { cogging, vibration, ..nominal.clone() }
        };
        let first = Waves::of(&with(0.1, 30.0), &motions, None);
        let second = Waves::of(&with(0.2, 31.0), &motions, Some(&first));
        let same = |place: usize| Arc::ptr_eq(&first.along(0)[place], &second.along(0)[place]);
        assert!(same(0) && !same(1));
        let q = motions[0].cell_position[5];
        assert_eq!(first.along(0)[0][5], (7.0 * q).sin_cos());
    }
}
