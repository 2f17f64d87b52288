//! The figures of a recorded step.

use crate::read::Recording;

/// What a step looked like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// rad.
    pub height_rad: f64,
    /// Beyond the reference, share of the step.
    pub overshoot: f64,
    /// From the step to the last time outside the band, s; none if it ends outside.
    pub settling_s: Option<f64>,
    /// Reference minus position at the end, rad.
    pub residual_rad: f64,
}

/// Settling band as a share of the step, as `simulate` has it.
const BAND: f64 = 0.02;

impl Figures {
    /// Of the first step of a recording, as long as the drive runs; `held_rad` is what friction holds, and no part of the settling.
    pub fn of(recording: &Recording, held_rad: f64) -> Option<Self> {
        let (reference, fault) = (recording.reference.as_ref()?, recording.fault.as_ref()?);
        let begin = (1..recording.rows()).find(|&row| fault[row] == 0 && reference[row] != reference[row - 1])?;
        let end = (begin..recording.rows()).find(|&row| fault[row] != 0).unwrap_or(recording.rows());
        let (from, to) = (recording.position[begin], reference[begin]);
        let height_rad = to - from;
        let response = recording.position.get(begin..end)?;
        let band_rad = (BAND * height_rad.abs()).max(held_rad);
        let outside = response.iter().rposition(|position| (to - position).abs() > band_rad);
        let settling_s = match outside {
            Some(last) if last + 1 == response.len() => None,
            Some(last) => Some(recording.t_s[begin + last + 1] - recording.t_s[begin]),
            None => Some(0.0),
        };
        let beyond = response.iter().map(|position| (position - to) / height_rad).fold(0.0, f64::max);
        Some(Self { height_rad, overshoot: beyond, settling_s, residual_rad: to - response.last()? })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::read::AxisKind;

    #[test]
    fn a_step_that_overshoots_and_settles_has_its_figures() {
        let rows = 400;
        // Ready, a step at row 50, which overshoots by 5 % and settles at row 150; stopped at row 350.
        let reference = (0..rows).map(|row| if (50..350).contains(&row) { 1.0 } else { 0.0 }).collect();
        let position = (0..rows).map(|row| match row {
            0..=50 => 0.0,
            51..=99 => 0.5,
            100..=149 => 1.05,
            150..=349 => 0.99,
            _ => 0.0,
        });
        let recording = Recording {
            t_s: (0..rows).map(|row| f64::from(row) * 1e-3).collect(),
            position: position.collect(),
            reference: Some(reference),
            fault: Some((0..rows).map(|row| if (10..350).contains(&row) { 0 } else { 1 << 16 }).collect()),
            ..Recording::empty(AxisKind::Rotary)
        };
        let figures = Figures::of(&recording, 0.0).unwrap();
        assert!((figures.overshoot - 0.05).abs() < 1e-12 && (figures.residual_rad - 0.01).abs() < 1e-12);
        assert!((figures.settling_s.unwrap() - 0.1).abs() < 1e-12, "{figures:?}");
        // Friction may hold it within 6 %.
        assert!((Figures::of(&recording, 0.06).unwrap().settling_s.unwrap() - 0.05).abs() < 1e-12);
    }
}
