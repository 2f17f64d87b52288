//! Where the missing torque has structure: orders over position, tones and pushes over time, read off the adjoint.

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::effects::Excitation;
use crate::hypothesis::{Kept, KeptRecording};
use crate::likelihood::Grid;
use crate::likelihood::filter::{HUBER, Innovations, loss};
use crate::physics::Tone;
use crate::problem::Problem;

use super::orders::{HIGHEST_ORDER, orders, peaks};
use super::pushes::{PUSHES_S, pushes};

/// What the motion excites, with the orders, tones and pushes that stand out of what a pass leaves.
pub(crate) fn seek(problem: &Problem, path: &Kept) -> Excitation {
    let missing: Vec<Missing<'_>> =
        path.recordings.iter().enumerate().map(|(index, kept)| of_recording(problem, path, index, kept)).collect();
    let mut excitation = problem.excitation.clone();
    excitation.orders = orders(weighted(&missing, |_, _| 1.0), &problem.excitation);
    // A ripple's missing torque goes along with the drive's.
    excitation.ripple_orders = orders(weighted(&missing, |one, row| one.drive[row]), &problem.excitation);
    excitation.tones = tones(&missing, excitation.recordings, problem.band_hz());
    excitation.pulses = pushes(problem, &missing);
    excitation.glitch = glitch(path);
    let rows = missing.iter().map(|one| one.torque.len()).max().unwrap_or(0) as f64;
    excitation.field_least = field_least(problem);
    excitation.looked_at = [HIGHEST_ORDER as f64, rows, rows * PUSHES_S.len() as f64];
    excitation
}

/// Smallest field above 0 that is commanded where a hypothesis is fitted, kV/mm; 0 where there is none.
fn field_least(problem: &Problem) -> f64 {
    let commands = problem.recordings[..problem.fitted].iter().flat_map(|recorded| &recorded.commands);
    let least = commands.map(|command| command.field_kv_mm).filter(|&field| field > 0.0).reduce(f64::min);
    least.unwrap_or(0.0)
}

pub(super) fn of_recording<'a>(
    problem: &'a Problem,
    path: &Kept,
    index: usize,
    kept: &'a KeptRecording,
) -> Missing<'a> {
    let grid = &problem.grids[index];
    let fine = path.missing_torque(problem, index);
    // One value a row: the sum over its substeps.
    let rows = |fine: &[f64]| -> Vec<f64> {
        let sum = |row: usize| fine[grid.first[row] as usize..grid.first[row + 1] as usize].iter().sum();
        (0..grid.dt_s.len()).map(sum).collect()
    };
    Missing {
        torque: rows(&fine),
        drive: mean_over_rows(&kept.acting.drive.drive, grid),
        misfit: misfit(problem, &kept.innovations),
        position: &kept.innovations.position,
        t_s: &problem.recordings[index].t_s,
    }
}

/// By how much each row's innovation is less likely than expected, with its sign; nothing where the motion is given and all of the torque
/// is seen.
fn misfit(problem: &Problem, innovations: &Innovations) -> Vec<(f64, f64)> {
    if !problem.motions.is_empty() {
        return Vec::new();
    }
    let of = |(&whitened, &counted): (&f64, &bool)| if counted { (loss(whitened) - 1.0, whitened) } else { (0.0, 0.0) };
    innovations.whitened.iter().zip(&innovations.counted).map(of).collect()
}

/// Wrong samples that make a habit and no accident.
const FEWEST_GLITCHES: usize = 3;

/// Share and median size of samples that stand out of their neighbours on both sides.
fn glitch(path: &Kept) -> Option<(f64, f64)> {
    let (mut sizes, mut rows) = (Vec::new(), 0);
    for kept in &path.recordings {
        let found = &kept.innovations;
        rows += found.whitened.len();
        for row in 1..found.whitened.len().saturating_sub(1) {
            let [before, here, behind] = [row - 1, row, row + 1].map(|row| found.whitened[row].abs());
            if found.counted[row] && here > HUBER && before < 0.5 * here && behind < 0.5 * here {
                sizes.push(found.innovation[row].abs());
            }
        }
    }
    let middle = sizes.len() / 2;
    let share = sizes.len() as f64 / rows.max(1) as f64;
    (sizes.len() >= FEWEST_GLITCHES).then(|| (share, *sizes.select_nth_unstable_by(middle, f64::total_cmp).1))
}

/// What a pass says is missing in one recording, one value a row.
pub(super) struct Missing<'a> {
    /// Torque, of no certain scale.
    pub(super) torque: Vec<f64>,
    /// The drive's, N m (N).
    drive: Vec<f64>,
    /// How much less likely than expected a row is, and its whitened innovation; none where the motion is given.
    pub(super) misfit: Vec<(f64, f64)>,
    /// rad (m).
    position: &'a [f64],
    /// s.
    pub(super) t_s: &'a [f64],
}

impl Missing<'_> {
    /// Mean sample period, s.
    pub(super) fn period_s(&self) -> f64 {
        (self.t_s[self.torque.len()] - self.t_s[0]) / self.torque.len().max(1) as f64
    }
}

/// The missing torque of all rows with a weight of its row, and the position of each.
fn weighted(missing: &[Missing<'_>], weight: fn(&Missing<'_>, usize) -> f64) -> impl Iterator<Item = (f64, f64)> {
    missing.iter().flat_map(move |one| {
        let rows = one.torque.iter().zip(one.position).enumerate();
        rows.map(move |(row, (torque, position))| (torque * weight(one, row), *position))
    })
}

/// One value a row from one a substep.
fn mean_over_rows(values: &[f64], grid: &Grid) -> Vec<f64> {
    let row = |pair: &[u32]| {
        let of = &values[pair[0] as usize..pair[1] as usize];
        of.iter().sum::<f64>() / of.len().max(1) as f64
    };
    grid.first.windows(2).map(row).collect()
}

/// Tones of the missing torque over time, best first, without amplitudes, within the band that is judged.
fn tones(missing: &[Missing<'_>], recordings: usize, band_hz: Option<f64>) -> Vec<Tone> {
    let Some(longest) = missing.iter().max_by_key(|one| one.torque.len()) else { return Vec::new() };
    let (rows, duration_s) = (longest.torque.len(), longest.t_s[longest.torque.len()] - longest.t_s[0]);
    let length = (2 * rows).next_power_of_two();
    let dt_s = duration_s / rows.max(1) as f64;
    let fft = FftPlanner::new().plan_fft_forward(length);
    let mut power = vec![0.0; length / 2];
    for one in missing {
        let mut even = vec![Complex::new(0.0, 0.0); length];
        for (torque, t_s) in one.torque.iter().zip(one.t_s) {
            let at = ((t_s - one.t_s[0]) / dt_s).round() as usize;
            if let Some(cell) = even.get_mut(at) {
                cell.re += torque;
            }
        }
        fft.process(&mut even);
        power.iter_mut().zip(&even).for_each(|(power, value)| *power += value.norm_sqr());
    }
    // Below three periods in the longest recording a tone is no tone.
    let lowest = (3.0 * length as f64 * dt_s / duration_s).ceil() as usize;
    let highest = band_hz.map_or(power.len(), |hz| (hz * length as f64 * dt_s).floor() as usize);
    power.truncate(highest);
    let from = lowest.min(power.len());
    let tone = |index: usize| Tone {
        frequency_hz: (from + index) as f64 / (length as f64 * dt_s),
        phasors: vec![(0.0, 0.0); recordings],
    };
    peaks(&power[from..], 1).into_iter().map(tone).collect()
}
