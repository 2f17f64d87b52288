//! What noise alone leaves in the windows.

use rayon::prelude::*;

use super::noise::at_rest;
use super::{Noise, Path, twin};
use crate::Error;
use crate::effects::Physics;
use crate::progress::Progress;
use crate::read::Recording;
use crate::refit::{HORIZON_S, Windows};
use crate::screen::Motion;

/// Twins of each recording at least.
const TWINS: usize = 4;
/// Seed of the first twin; each further one takes the next.
const SEED: u64 = 1;
/// Each twin is of another piece of this length at most, spread over the recording, s: a machine without a closed form
/// takes long in its windows, and as many of them as eight seconds hold tell the floor to some percent.
const PIECE_S: f64 = 2.0;
/// and of this length at least.
const SHORTEST_S: f64 = 0.5;

/// The noise floor.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// Root mean square over the windows of all twins, rad (m).
    pub rms: f64,
    /// In words, where the sensor's share does not agree with what is recorded at rest.
    pub warnings: Vec<String>,
}

/// Mean over twins of the root mean square that the machine leaves of them, which is all noise.
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
        work.extend(each.map(|(k, &(from, to))| (index, from, to, SEED + (index * TWINS + k) as u64)));
    }
    let progress = Progress::new("noise floor, twins", work.len() as u64);
    let each = work.into_par_iter().map(|(index, from, to, seed)| {
        let (recording, path) = (part(&recordings[index], from, to), Path::of(&motions[index], from, to));
        let twin = twin(machine, index, &recording, path, &noises[index], seed)?;
        let windows = Windows::new(machine, std::slice::from_ref(&twin), index, noises[index].resolution, HORIZON_S)?;
        progress.advance(1);
        let rows: usize = windows.residuals.iter().flat_map(|r| &r.windows).map(|window| window.residual.len()).sum();
        Ok((windows.rms().powi(2), rows as f64))
    });
    let all: Vec<(f64, f64)> = each.collect::<Result<_, Error>>()?;
    let (sum, count) = all.iter().fold((0.0, 0.0), |(sum, count), (square, rows)| (sum + square * rows, count + rows));
    let warnings = recordings.iter().zip(noises).filter_map(|(recording, noise)| disagreement(recording, noise));
    Ok(Floor { rms: if count > 0.0 { (sum / count).sqrt() } else { 0.0 }, warnings: warnings.collect() })
}

/// At rest only the sensor speaks; half a step is what a position between two steps may or may not show.
fn disagreement(recording: &Recording, noise: &Noise) -> Option<String> {
    let (recorded, expected) = at_rest(recording, noise, HORIZON_S, SEED)?;
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
    let count = ((span_s / SHORTEST_S) as usize).clamp(1, TWINS);
    let length_s = PIECE_S.min(span_s / count as f64);
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

/// Rows `from..to` of the columns that a twin is made of.
fn part(recording: &Recording, from: usize, to: usize) -> Recording {
    fn cut<T: Clone>(values: &Option<Vec<T>>, from: usize, to: usize) -> Option<Vec<T>> {
        values.as_ref().map(|values| values[from..to].to_vec())
    }
    Recording {
        name: recording.name.clone(),
        axis: recording.axis,
        t_s: recording.t_s[from..to].to_vec(),
        position: recording.position[from..to].to_vec(),
        effort_cmd: recording.effort_cmd[from..to].to_vec(),
        reference: None,
        field_cmd_kv_mm: cut(&recording.field_cmd_kv_mm, from, to),
        mode: cut(&recording.mode, from, to),
        velocity: cut(&recording.velocity, from, to),
        effort_meas: None,
        field_meas_kv_mm: None,
        temperature_c: None,
        seq: None,
        fault: None,
        counts: None,
        gaps: recording.gaps.iter().filter(|gap| (from..to - 1).contains(*gap)).map(|gap| gap - from).collect(),
        extra: Vec::new(),
    }
}
