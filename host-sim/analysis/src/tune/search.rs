//! The gains: a grid, and a compass search from its best places.

use rayon::prelude::*;

use super::cycles::limit_cycles;
use super::guarantee::Guarantee;
use super::series::SeriesLoop;
use super::trial::{Steps, Trial, config_for, trial};
use super::{PEAK_NM_S_RAD, Range, Task};
use crate::stability::{Gains, NormalisedGains};
use progress::Progress;
use recording::Error;

/// Grid of K_p* and K_d*, in constant ratio.
const GRID: usize = 22;
const KP: [f64; 2] = [0.004, 0.4];
const KD: [f64; 2] = [0.04, 1.2];
/// Levels of the trade-off curve.
pub const LEVELS: [f64; 12] = [0.1, 0.25, 0.5, 0.75, 0.85, 0.95, 1.0, 1.05, 1.1, 1.2, 1.5, 2.0];
/// Largest viscosities that are tried, N m s/rad: the peak of (5), then down past the 10 of section V.
const VISCOSITIES_NM_S_RAD: [f64; 7] = [PEAK_NM_S_RAD, 30.0, 20.0, 10.0, 5.0, 2.0, 1.0];
/// First and last step of the compass search, as a logarithm of a gain.
const FIRST_STEP: f64 = 0.1;
const LAST_STEP: f64 = 0.005;

/// Gains and what they are worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Scaled with the machine's J and L.
    pub normalised: NormalisedGains,
    /// In N m.
    pub gains: Gains,
    /// None if a loop of the range is unstable.
    pub guarantee: Option<Guarantee>,
    /// None if the nonlinear loop does not do what is asked, or the linear one is unstable somewhere.
    pub trial: Option<Trial>,
}

impl Candidate {
    /// What it guarantees and costs; none if it is no good.
    #[must_use]
    pub fn worth(&self) -> Option<(f64, f64)> {
        Some((self.guarantee?.level, self.trial?.cost_s()))
    }

    /// Its cost if it keeps a level; infinite if not.
    fn cost_at(&self, level: f64) -> f64 {
        self.worth().filter(|worth| worth.0 >= level).map_or(f64::INFINITY, |worth| worth.1)
    }
}

/// What came out.
#[derive(Debug, Clone, PartialEq)]
pub struct Tuning {
    /// The loops the margins are kept for.
    pub range: Range,
    /// No gains of the grid keep the demands up to the peak of (5); the range stops below.
    pub short_of_peak: bool,
    /// Best for each of [`LEVELS`]; none where nothing keeps it.
    pub trade_off: Vec<(f64, Option<Candidate>)>,
    /// Best that keeps the demands.
    pub best: Candidate,
    /// The paper's gains for this machine.
    pub paper: Candidate,
    /// Gains judged.
    pub judged: usize,
    /// The uncertainty up to which the paper's gains stay stable, as a share.
    pub paper_bears: f64,
    /// Loops drawn to check the best by root counting, and how many of them were unstable.
    pub draws: (usize, usize),
    /// Limit cycles of the nonlinear loop under the best, by harmonic balance.
    pub limit_cycles: usize,
}

/// Seed of the draws.
pub const SEED: u64 = 1;
/// Number of draws.
const DRAWS: usize = 1000;

/// Judges gains by both models.
///
/// # Errors
/// A machine that one of the models does not take.
pub fn judge(task: &Task, range: &Range, normalised: NormalisedGains) -> Result<Candidate, Error> {
    let gains = normalised.physical(range.inertia_kg_m2, range.nominal_delay_s());
    let guarantee = range.guarantee(gains, &task.demands);
    let trial = if guarantee.is_some() { try_gains(task, gains)? } else { None };
    Ok(Candidate { normalised, gains, guarantee, trial })
}

fn try_gains(task: &Task, gains: Gains) -> Result<Option<Trial>, Error> {
    let config = config_for(&task.config, gains, &task.model, task.uncertainty);
    trial(&task.model, &config, task.uncertainty, &task.steps)
}

/// The paper's gains, tried with the nominal delays and whatever the overshoot, for they were not made for more.
fn paper(task: &Task, range: &Range) -> Result<Candidate, Error> {
    let candidate = judge(task, range, NormalisedGains::PAPER)?;
    let config = config_for(&task.config, candidate.gains, &task.model, task.uncertainty);
    let steps = Steps { overshoot: f64::INFINITY, ..task.steps };
    Ok(Candidate { trial: trial(&task.model, &config, 0.0, &steps)?, ..candidate })
}

/// The largest uncertainty, in hundredths, at which gains keep every loop of a range stable.
fn bears(task: &Task, range: &Range, gains: Gains) -> f64 {
    let stable = |percent: u32| {
        let range = Range { uncertainty: 0.01 * f64::from(percent), ..range.clone() };
        range.guarantee(gains, &task.demands).is_some()
    };
    let lost = (0..=90).find(|percent| !stable(*percent)).unwrap_or(91);
    0.01 * f64::from(lost) - 0.01
}

/// Searches the gains.
///
/// # Errors
/// A machine the models do not take, or demands that no gains of the grid keep; the message says how near they come.
pub fn tune(task: &Task) -> Result<Tuning, Error> {
    let undamped = task.range(0.0).fluid_s.is_none();
    let ladder = match task.q1_nm_s_rad {
        Some(q1_nm_s_rad) => vec![q1_nm_s_rad],
        None if undamped => vec![0.0],
        None => VISCOSITIES_NM_S_RAD.to_vec(),
    };
    let mut nearest = None;
    for (rung, q1_nm_s_rad) in ladder.into_iter().enumerate() {
        let range = task.range(q1_nm_s_rad);
        let most = NormalisedGains { kp: KP[1], kd: KD[1] }.physical(range.inertia_kg_m2, range.nominal_delay_s());
        if let Some(phase_rad) = range.loops(most).iter().find_map(SeriesLoop::too_stiff_rad) {
            nearest = Some(Error::Usage(format!(
                "the loop is too stiff to tune (a phase of {phase_rad:.1e} rad over its band); check the units of the inertia, the \
                 viscosity and the delays"
            )));
            continue;
        }
        let grid = grid(task, &range)?;
        if best_of(&grid, 1.0).is_some() || task.q1_nm_s_rad.is_some() {
            return finish(task, range, rung > 0, grid);
        }
        nearest = Some(none_keeps(task, &range, &grid));
    }
    Err(nearest.unwrap_or_else(|| Error::Usage("nothing was searched".to_owned())))
}

/// Every place of the grid.
fn grid(task: &Task, range: &Range) -> Result<Vec<Candidate>, Error> {
    let progress = Progress::new("grid of gains", (GRID * GRID) as u64);
    let at = |[low, high]: [f64; 2], k: usize| low * (high / low).powf(k as f64 / (GRID - 1) as f64);
    (0..GRID * GRID)
        .into_par_iter()
        .map(|k| {
            let candidate = judge(task, range, NormalisedGains { kp: at(KP, k / GRID), kd: at(KD, k % GRID) });
            progress.advance(1);
            candidate
        })
        .collect()
}

fn best_of(candidates: &[Candidate], level: f64) -> Option<Candidate> {
    let kept = candidates.iter().filter(|candidate| candidate.cost_at(level).is_finite());
    kept.min_by(|a, b| a.cost_at(level).total_cmp(&b.cost_at(level))).copied()
}

fn finish(task: &Task, range: Range, short_of_peak: bool, mut judged: Vec<Candidate>) -> Result<Tuning, Error> {
    let progress = Progress::new("compass search", LEVELS.len() as u64);
    for level in LEVELS {
        if let Some(start) = best_of(&judged, level) {
            judged.extend(compass(task, &range, start, level)?);
        }
        progress.advance(1);
    }
    let best = best_of(&judged, 1.0).ok_or_else(|| none_keeps(task, &range, &judged))?;
    let unstable = range.draws(best.gains, DRAWS, SEED).filter(|drawn| drawn.unstable_roots() != Some(0)).count();
    let paper = paper(task, &range)?;
    Ok(Tuning {
        paper_bears: bears(task, &range, paper.gains),
        paper,
        trade_off: LEVELS.map(|level| (level, best_of(&judged, level))).to_vec(),
        best,
        judged: judged.len(),
        draws: (DRAWS, unstable),
        limit_cycles: limit_cycles(task, best.gains)?,
        range,
        short_of_peak,
    })
}

/// Steps to the best of eight neighbours while one is better, and halves the step when none is.
fn compass(task: &Task, range: &Range, start: Candidate, level: f64) -> Result<Vec<Candidate>, Error> {
    const AROUND: [(f64, f64); 8] =
        [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let (mut centre, mut step, mut seen) = (start, FIRST_STEP, Vec::new());
    while step >= LAST_STEP {
        let NormalisedGains { kp, kd } = centre.normalised;
        let neighbours: Vec<Candidate> = AROUND
            .into_par_iter()
            .map(|(p, d)| {
                let gains = NormalisedGains { kp: kp * (p * step).exp(), kd: kd * (d * step).exp() };
                judge(task, range, gains)
            })
            .collect::<Result<_, Error>>()?;
        match best_of(&neighbours, level) {
            Some(better) if better.cost_at(level) < centre.cost_at(level) => centre = better,
            _ => step *= 0.5,
        }
        seen.extend(neighbours);
    }
    Ok(seen)
}

/// Why nothing was found.
fn none_keeps(task: &Task, range: &Range, judged: &[Candidate]) -> Error {
    let levels = judged.iter().filter_map(|candidate| Some(candidate.guarantee?.level));
    let stable = levels.clone().fold(f64::NEG_INFINITY, f64::max);
    let level = judged.iter().filter_map(Candidate::worth).map(|worth| worth.0).fold(f64::NEG_INFINITY, f64::max);
    let q1 = range.q1_nm_s_rad;
    let percent = 100.0 * task.uncertainty;
    Error::Usage(if level > 0.0 {
        format!(
            "no gains keep these margins up to Q1 {q1} N m s/rad with delays +-{percent} % off; at most {level:.2} of them. \
             Ask for less of --phase-margin-deg, --gain-margin, --delay-margin, --uncertainty-percent or --q1"
        )
    } else if stable > 0.0 {
        format!(
            "gains keep up to {stable:.2} of the margins up to Q1 {q1} N m s/rad, but none of them settles within the \
             tolerance and the overshoot; allow more of --tolerance-mrad or --overshoot-percent"
        )
    } else {
        format!(
            "no gains keep the loop stable up to Q1 {q1} N m s/rad with delays +-{percent} % off; ask for less of --q1"
        )
    })
}
