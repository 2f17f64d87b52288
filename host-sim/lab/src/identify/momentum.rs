//! Inertia and delay of the motor to begin with: least squares on the momentum that torques give within 20 ms.

use super::steady::Steady;
use crate::Error;
use crate::read::Recording;

/// Length of a window, s: several delays, and short against the motion.
const WINDOW_S: f64 = 0.02;
/// The speed at a row is that between so many rows before and after it: 1.6 mrad/s of quantisation at 2 kHz.
const APART: usize = 4;
/// Longest delay that is tried, s.
const LONGEST_S: f64 = 0.03;

/// Inertia, kg m2, and delay, s, that explain the changes of momentum best, the delay to a fraction of a sample.
///
/// # Errors
///
/// A recording in which the axis hardly moved.
pub(super) fn estimate(recording: &Recording, steady: &Steady, period_s: f64) -> Result<(f64, f64), Error> {
    let still = || Error::Usage(format!("{}: the axis hardly moved; allow more travel or torque", recording.name));
    let speeds = speeds(recording);
    let window = (WINDOW_S / period_s).round() as usize;
    let longest = (LONGEST_S / period_s).round() as usize;
    let fits: Vec<Fit> = (0..=longest).map(|delay| fit(recording, &speeds, steady, window, delay, period_s)).collect();
    let (at, best) =
        fits.iter().enumerate().min_by(|a, b| a.1.unexplained.total_cmp(&b.1.unexplained)).ok_or_else(still)?;
    // Half of it unexplained: then noise has made it.
    if !(best.inertia > 0.0 && best.unexplained < 0.5) {
        return Err(still());
    }
    let left = |index: usize| fits.get(index).map_or(best.unexplained, |fit| fit.unexplained);
    let (before, after) = (left(at.wrapping_sub(1)), left(at + 1));
    let bend = before - 2.0 * best.unexplained + after;
    let fraction = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Ok((best.inertia, ((at as f64 + fraction) * period_s).max(0.0)))
}

struct Fit {
    inertia: f64,
    /// Share of the momentum's variance that is left.
    unexplained: f64,
}

fn speeds(recording: &Recording) -> Vec<f64> {
    let rows = recording.rows();
    (0..rows)
        .map(|row| {
            let (from, to) = (row.saturating_sub(APART), (row + APART).min(rows - 1));
            (recording.position[to] - recording.position[from]) / (recording.t_s[to] - recording.t_s[from])
        })
        .collect()
}

fn fit(recording: &Recording, speeds: &[f64], steady: &Steady, window: usize, delay: usize, period_s: f64) -> Fit {
    let force = |row: usize| {
        let speed = speeds[row];
        let friction = steady.coulomb_nm.value * speed.signum() + steady.viscous_nm_s_rad.value * speed;
        recording.effort_cmd[row - delay] + steady.offset_nm.value - friction
    };
    let (mut squares, mut product, mut impulses) = (0.0, 0.0, 0.0);
    let mut row = delay + APART;
    while row + window + APART < recording.rows() {
        let change = speeds[row + window] - speeds[row];
        // At rest friction is not known.
        if (row..row + window).all(|row| speeds[row].abs() > 0.02) {
            let impulse: f64 = (row..row + window).map(force).sum::<f64>() * period_s;
            squares += change * change;
            product += change * impulse;
            impulses += impulse * impulse;
        }
        row += window / 4;
    }
    if squares <= 0.0 || impulses <= 0.0 {
        return Fit { inertia: 0.0, unexplained: 1.0 };
    }
    Fit { inertia: product / squares, unexplained: 1.0 - product * product / (squares * impulses) }
}
