//! Where, in time and in state, the nominal machine is less likely than the best hypothesis.

use crate::confidence_set::TWO_SIDED_95;
use crate::pipeline::Conclusion;
use crate::problem::Problem;

/// A span of time that holds much of the difference.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Index of the recording.
    pub recording: usize,
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
    /// Share of the whole difference, 1.
    pub share: f64,
    /// Lower end of the share's 95 % band.
    pub share_low: f64,
    /// Upper end of the share's 95 % band.
    pub share_high: f64,
    /// Mean size of the speed there, rad/s (m/s).
    pub speed: f64,
}

/// A range of a channel that holds half of the difference in as few rows as can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// The channel, without unit.
    pub channel: &'static str,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Share of the whole difference, 1.
    pub share: f64,
    /// Lower end of the share's 95 % band.
    pub share_low: f64,
    /// Upper end of the share's 95 % band.
    pub share_high: f64,
}

/// Most spans that are told.
const MOST: usize = 5;
/// Equally filled bins of a channel.
const BINS: usize = 12;
/// A region holds this share of the difference.
const HALF: f64 = 0.5;

/// Log-likelihood by which each row of each recording tells best from nominal; where nothing is added, what each row costs the
/// nominal machine beyond a normal residual.
fn rows(conclusion: &Conclusion) -> Vec<Vec<f64>> {
    let before = &conclusion.nominal.assessed.refitted.evaluation.innovations;
    let after = &conclusion.best.assessed.refitted.evaluation.innovations;
    let same = conclusion.effects.is_empty();
    let of = |(before, after): (&crate::likelihood::Innovations, &crate::likelihood::Innovations)| {
        let row = |row: usize| match (before.counted[row], same) {
            (false, _) => 0.0,
            (true, true) => 0.5 * (before.whitened[row] * before.whitened[row] - 1.0),
            (true, false) => after.log_likelihood[row] - before.log_likelihood[row],
        };
        (0..before.whitened.len()).map(row).collect()
    };
    before.iter().zip(after).map(of).collect()
}

/// The blocks that hold most, neighbours joined, in order of their share.
pub fn spans(problem: &Problem, conclusion: &Conclusion) -> Vec<Span> {
    let rows = rows(conclusion);
    let total: f64 = rows.iter().flatten().filter(|value| **value > 0.0).sum();
    let mut spans: Vec<Span> = Vec::new();
    for (recording, values) in rows.iter().enumerate() {
        let recorded = &problem.recordings[recording];
        let speeds = &conclusion.nominal.assessed.refitted.evaluation.innovations[recording].speed;
        for block in &problem.blocks[recording] {
            let share = values[block.clone()].iter().sum::<f64>() / total.max(f64::MIN_POSITIVE);
            let speed = speeds[block.clone()].iter().map(|speed| speed.abs()).sum::<f64>() / block.len().max(1) as f64;
            let (start_s, end_s) = (recorded.t_s[block.start], recorded.t_s[block.end - 1]);
            // More than an equal share of all blocks, or it is no place.
            if share * problem.blocks.iter().map(Vec::len).sum::<usize>() as f64 <= 1.0 {
                continue;
            }
            match spans
                .last_mut()
                .filter(|last| last.recording == recording && start_s - last.end_s < 2.0 * recorded.period_s())
            {
                Some(last) => {
                    last.speed = last.speed.max(speed);
                    (last.end_s, last.share) = (end_s, last.share + share);
                }
                None => spans.push(Span { recording, start_s, end_s, share, share_low: 0.0, share_high: 1.0, speed }),
            }
        }
    }
    spans.sort_by(|a, b| b.share.total_cmp(&a.share));
    spans.truncate(MOST);
    for span in &mut spans {
        let inside = |recording: usize, row: usize| {
            let t_s = problem.recordings[recording].t_s[row];
            recording == span.recording && span.start_s <= t_s && t_s <= span.end_s
        };
        (span.share_low, span.share_high) = band(problem, &rows, &inside);
    }
    spans
}

/// 95 % band of the share that the rows inside have of all that tells for the best, by leaving out each block in turn (jackknife).
fn band(problem: &Problem, rows: &[Vec<f64>], inside: &dyn Fn(usize, usize) -> bool) -> (f64, f64) {
    let mut blocks: Vec<(f64, f64)> = Vec::new();
    for (recording, values) in rows.iter().enumerate() {
        for block in &problem.blocks[recording] {
            let all: f64 = values[block.clone()].iter().map(|gain| positive(*gain)).sum();
            blocks.push((block.clone().filter(|&row| inside(recording, row)).map(|row| values[row]).sum(), all));
        }
    }
    let (inside, all) = blocks.iter().fold((0.0, 0.0), |(inside, all), block| (inside + block.0, all + block.1));
    let share = inside / all;
    let n = blocks.len() as f64;
    let left: Vec<f64> = blocks.iter().map(|block| (inside - block.0) / (all - block.1)).collect();
    let mean = left.iter().sum::<f64>() / n;
    let sd = ((n - 1.0) / n * left.iter().map(|value| (value - mean).powi(2)).sum::<f64>()).sqrt();
    let end = |value: f64| if value.is_finite() { value.clamp(0.0, 1.0) } else { share.clamp(0.0, 1.0) };
    (end(share - TWO_SIDED_95 * sd), end(share + TWO_SIDED_95 * sd))
}

/// What a row tells for the best, 0 where it tells against it; no number stays none, which is no place either.
fn positive(gain: f64) -> f64 {
    if gain < 0.0 { 0.0 } else { gain }
}

/// One region a channel, by how much denser the difference is there than elsewhere.
pub fn regions(problem: &Problem, conclusion: &Conclusion) -> Vec<Region> {
    let rows = rows(conclusion);
    let innovations = &conclusion.nominal.assessed.refitted.evaluation.innovations;
    let speed = |recording: usize, row: usize| innovations[recording].speed[row].abs();
    let position = |recording: usize, row: usize| innovations[recording].position[row];
    let field = |recording: usize, row: usize| problem.recordings[recording].commands[row].field_kv_mm;
    let mut regions = vec![region(problem, "speed", &rows, &speed), region(problem, "position", &rows, &position)];
    if problem.excitation.field_peak > 0.0 {
        regions.push(region(problem, "field", &rows, &field));
    }
    let mut regions: Vec<(Region, usize)> = regions.into_iter().flatten().collect();
    regions.sort_by_key(|(_, bins)| *bins);
    regions.into_iter().map(|(region, _)| region).collect()
}

fn region(
    problem: &Problem,
    channel: &'static str,
    rows: &[Vec<f64>],
    value: &dyn Fn(usize, usize) -> f64,
) -> Option<(Region, usize)> {
    let mut all: Vec<(f64, f64)> = rows
        .iter()
        .enumerate()
        .flat_map(|(recording, of)| of.iter().enumerate().map(move |(row, gain)| (recording, row, *gain)))
        .map(|(recording, row, gain)| (value(recording, row), gain))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let edge = |bin: usize| bin * all.len() / BINS;
    let bins: Vec<f64> =
        (0..BINS).map(|bin| all[edge(bin)..edge(bin + 1)].iter().map(|(_, gain)| gain).sum()).collect();
    let total: f64 = all.iter().map(|(_, gain)| positive(*gain)).sum();
    if total.is_nan() || total <= 0.0 {
        return None;
    }
    (1..=BINS).find_map(|width| {
        let best = (0..=BINS - width)
            .map(|from| (from, bins[from..from + width].iter().sum::<f64>()))
            .max_by(|a, b| a.1.total_cmp(&b.1))?;
        let (from, sum) = best;
        if sum < HALF * total {
            return None;
        }
        let (low, high) = (all[edge(from)].0, all[(edge(from + width) - 1).max(edge(from))].0);
        let inside = |recording: usize, row: usize| (low..=high).contains(&value(recording, row));
        let (share_low, share_high) = band(problem, rows, &inside);
        Some((Region { channel, low, high, share: sum / total, share_low, share_high }, width))
    })
}
