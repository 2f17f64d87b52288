//! What noise alone leaves in the windows.

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use rayon::prelude::*;

use super::noise::at_rest;
use super::{Noise, Path, twin};
use crate::Error;
use crate::effects::Physics;
use crate::progress::Progress;
use crate::read::Recording;
use crate::refit::{HORIZON_S, Windows};
use crate::residual::{Window, horizon_s};
use crate::screen::Motion;

/// Twins of each recording at least,
const TWINS: usize = 4;
/// and at most: of a long one there is a twin for every few seconds, s.
const MOST_TWINS: usize = 16;
const EVERY_S: f64 = 5.0;
/// Draws of windows.
const DRAWS: usize = 200;
/// Seed of the draws, and of the first twin; each further one takes the next.
const SEED: u64 = 1;
/// Each twin is of another piece of this length at most, in windows, spread over the recording: a machine without a closed form
/// takes long in its windows, and as many of them as eight seconds hold tell the floor to some percent.
const PIECE: f64 = 40.0;
/// and of this length at least.
const SHORTEST: f64 = 10.0;

/// The noise floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    pieces: Vec<Piece>,
    /// In words, where the sensor's share does not agree with what is recorded at rest.
    pub warnings: Vec<String>,
    /// Steps of the simulations, see [`crate::budget`].
    pub(in crate::decide) work: u64,
}

/// A piece of a recording, and what its twin left.
#[derive(Debug, Clone, PartialEq)]
struct Piece {
    recording: usize,
    /// First row, and the one past the last.
    from: usize,
    to: usize,
    /// Sum of squares of each of the twin's windows, rad2 (m2), and its rows.
    left: Vec<(f64, usize)>,
    /// Steps of its simulations.
    work: u64,
}

/// What a machine leaves of some recordings against what noise alone would.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Above {
    /// Root mean square that noise alone would leave, rad (m).
    pub floor: f64,
    /// Times the floor that is surely left: 95 % of the draws of both leave more,
    pub least: f64,
    /// and that is surely not exceeded.
    pub most: f64,
}

/// Twins of pieces of each recording, and what the machine leaves of them, which is all noise.
///
/// # Errors
/// A machine that the plant refuses, recordings without a window.
pub fn noise_floor(
    machine: &Physics,
    recordings: &[Recording],
    motions: &[Motion],
    noises: &[Noise],
) -> Result<Floor, Error> {
    let mut work = Vec::new();
    for (index, recording) in recordings.iter().enumerate() {
        let pieces = pieces(recording);
        // Where a recording is too short for enough pieces, each is twinned more often.
        let each = pieces.iter().cycle().take(pieces.len().max(TWINS)).enumerate();
        work.extend(each.map(|(k, &(from, to))| (index, from, to, SEED + (index * MOST_TWINS + k) as u64)));
    }
    let progress = Progress::new("noise floor, twins", work.len() as u64);
    let each = work.into_par_iter().map(|(recording, from, to, seed)| {
        let (part, path) =
            (recordings[recording].driven(std::slice::from_ref(&(from..to))), Path::of(&motions[recording], from, to));
        let (noise, resolution) = (&noises[recording], noises[recording].resolution);
        let twin = twin(machine, recording, &part, path, noise, seed)?;
        let windows = Windows::new(machine, std::slice::from_ref(&twin), recording, resolution, HORIZON_S)?;
        progress.advance(1);
        let left = windows.residuals.iter().flat_map(|residual| &residual.windows).map(squares).collect();
        Ok(Piece { recording, from, to, left, work: windows.work })
    });
    let pieces = each.collect::<Result<Vec<_>, Error>>()?;
    let warnings = recordings.iter().zip(noises).filter_map(|(recording, noise)| disagreement(recording, noise));
    let work = pieces.iter().map(|piece| piece.work).sum();
    Ok(Floor { pieces, warnings: warnings.collect(), work })
}

impl Above {
    /// Whether a root mean square that is left, rad (m), is more than so many times the floor, and no accident of a few
    /// windows.
    pub fn exceeded(&self, rms: f64, times: f64) -> bool {
        rms > times * self.floor && self.least > 1.0
    }

    /// Whether the floor is more than so many times what is left, and that is no accident of a few windows.
    pub fn swallows(&self, rms: f64, times: f64) -> bool {
        self.floor > times * rms && self.most < 1.0
    }
}

impl Floor {
    /// What is left of some recordings against what noise alone would leave; `windows` is what the machine leaves of them, and
    /// the first of them is number `first`. Most of it is left by a few windows in which the rotor sticks or turns, so twins
    /// and recordings are compared in the same pieces, the recordings' rest is scaled alike, and both are drawn again. None
    /// without a twin of them.
    pub fn under(&self, windows: &Windows, first: usize) -> Option<Above> {
        let (mut noise, mut left) = (Vec::new(), Vec::new());
        for (index, residual) in windows.residuals.iter().enumerate() {
            for piece in self.pieces.iter().filter(|piece| piece.recording == first + index) {
                let inside = residual.windows.iter().filter(|window| (piece.from..piece.to).contains(&window.start));
                left.extend(inside.map(squares));
                noise.extend_from_slice(&piece.left);
            }
        }
        if noise.is_empty() || left.is_empty() {
            return None;
        }
        let ratio = |noise: f64, left: f64| (left / noise.max(f64::MIN_POSITIVE)).sqrt();
        let mut random = StdRng::seed_from_u64(SEED);
        let mut again = |all: &[(f64, usize)]| mean((0..all.len()).map(|_| all[random.random_range(0..all.len())]));
        let mut drawn: Vec<f64> = (0..DRAWS).map(|_| ratio(again(&noise), again(&left))).collect();
        drawn.sort_by(f64::total_cmp);
        let (noise, left) = (mean(noise.into_iter()), mean(left.into_iter()));
        let floor = if left > 0.0 { windows.rms() / ratio(noise, left) } else { noise.sqrt() };
        let at = |quantile: f64| drawn[(quantile * (DRAWS - 1) as f64).round() as usize];
        Some(Above { floor, least: at(0.05), most: at(0.95) })
    }
}

/// Sum of squares of a window, rad2 (m2), and its rows.
fn squares(window: &Window) -> (f64, usize) {
    (window.residual.iter().map(|r| r * r).sum(), window.residual.len())
}

/// Mean square over the rows of windows, rad2 (m2).
fn mean(windows: impl Iterator<Item = (f64, usize)>) -> f64 {
    let (sum, rows) = windows.fold((0.0, 0), |(sum, rows), window| (sum + window.0, rows + window.1));
    sum / rows as f64
}

/// At rest only the sensor speaks; half a step is what a position between two steps may or may not show.
fn disagreement(recording: &Recording, noise: &Noise) -> Option<String> {
    let (recorded, expected) = at_rest(recording, noise, horizon_s(recording, HORIZON_S), SEED)?;
    let slack = 0.5 * noise.resolution;
    (recorded > 2.0 * expected + slack || expected > 2.0 * recorded + slack).then(|| {
        format!(
            "{}: at rest the position scatters by {recorded:.2e}, the noise estimated in motion would give {expected:.2e}; \
             the noise floor is not sure",
            recording.name
        )
    })
}

/// Rows of the pieces that are twinned, spread evenly; all of a recording that is short enough.
fn pieces(recording: &Recording) -> Vec<(usize, usize)> {
    let t_s = &recording.t_s;
    let (first_s, rows) = (t_s[0], t_s.len());
    let span_s = t_s[rows - 1] - first_s;
    let most = ((span_s / EVERY_S) as usize).clamp(TWINS, MOST_TWINS);
    let horizon_s = horizon_s(recording, HORIZON_S);
    let count = ((span_s / (SHORTEST * horizon_s)) as usize).clamp(1, most);
    let length_s = (PIECE * horizon_s).min(span_s / count as f64);
    let row = |at_s: f64| t_s.partition_point(|t| *t < at_s);
    let all = (0..count).map(|piece| {
        let start_s = first_s + (span_s - length_s) * piece as f64 / (count - 1).max(1) as f64;
        let last = if piece + 1 == count { rows } else { row(start_s + length_s) };
        (row(start_s), last)
    });
    // A gap may leave a piece without a window.
    let whole = all.filter(|&(from, to)| to - from > 1 && t_s[to - 1] - t_s[from] > 0.8 * length_s);
    let pieces: Vec<(usize, usize)> = whole.collect();
    if pieces.is_empty() { vec![(0, rows)] } else { pieces }
}
