//! The recordings, prepared once: grids of substeps, blocks, what the motion excites.

use std::ops::Range;
use std::sync::Arc;

use crate::effects::{Effect, Excitation};
use crate::likelihood::filter::Prepared;
use crate::likelihood::inverse::Motion;
use crate::likelihood::{Acting, Grid, Lately, Rounding};
use crate::physics::Physics;
use crate::recorded::Recorded;
use crate::repetition::Repetition;
use crate::work::{Tally, Work};

/// Recordings to fit and to hold out, with the nominal machine.
#[derive(Debug, Clone)]
pub struct Problem {
    /// The machine without anything missing.
    pub nominal: Physics,
    /// Those to fit, then those held out.
    pub recordings: Arc<[Recorded]>,
    /// Number of those to fit.
    pub fitted: usize,
    /// Substeps of each recording.
    pub grids: Arc<[Grid]>,
    /// What acted in each recording under the machines looked at lately.
    pub(crate) lately: Arc<[Lately]>,
    /// The motion of each recording, given, where the torque column may be a measurement; else empty, and the torque is a command.
    pub motions: Arc<[Motion]>,
    /// How much earlier than a command held to the next row the torque column acts in each recording, s: a sample of a measurement or
    /// of a faster loop stands for half a row to either side.
    pub(crate) early_s: Arc<[f64]>,
    /// Whether a loop gave commands between the rows, by its tick.
    pub(crate) loses_commands: bool,
    /// Row ranges of the blocks of each recording.
    pub blocks: Arc<[Vec<Range<usize>>]>,
    /// What the motion excites.
    pub excitation: Excitation,
    /// The sensor's step, rad (m); 0 for a continuous one.
    pub step: f64,
    /// The sensor's smallest noise beside its rounding, rad (m).
    pub least_sensor_sd: f64,
    /// What all passes may cost, and what they have.
    pub(crate) work: Work,
    /// What is counted for whoever waits.
    tally: Tally,
    /// Rows of each recording on which its noise is estimated: two numbers need no more.
    pub excerpts: Arc<[Vec<Range<usize>>]>,
}

/// Of each substep of a search this many are made where values are estimated.
const FINER: usize = 4;

/// Rows of a recording that the noise is estimated on: two numbers to some percent ...
const EXCERPT_ROWS: usize = 4000;
/// ... in this many stretches, spread evenly, so that motion of every kind is in them ...
const STRETCHES: usize = 8;
/// ... each at least so long, s: five times what is not judged behind its start, and long enough for what is missing to add up.
const LEAST_STRETCH_S: f64 = 0.25;

/// Length of a block, s: several times the memory of drive, fluid and noise, and many to a recording.
const BLOCK_S: f64 = 0.25;

impl Problem {
    /// Prepares recordings; `resolution` is the sensor's step, rad (m).
    pub fn new(nominal: Physics, recordings: Vec<Recorded>, fitted: usize, resolution: f64, linear: bool) -> Self {
        let measured = may_be_measured(&nominal);
        // Without a drive and a fluid between column and rotor nothing acts late.
        let recordings: Vec<Recorded> =
            if measured { recordings } else { recordings.into_iter().map(Recorded::settled).collect() };
        let grids: Vec<Grid> = recordings.iter().map(Grid::new).collect();
        let lately = recordings.iter().map(|_| Lately::default()).collect();
        let blocks = recordings.iter().map(blocks).collect();
        let excerpts = recordings.iter().map(stretches).collect();
        let motions = if measured { motions(&recordings, resolution) } else { Vec::new() };
        let excitation = Excitation { step: resolution, measured, ..excitation(&recordings, fitted, linear) };
        let early_s = early(&nominal, &recordings, &grids, &motions, resolution);
        // Without steps, what double precision keeps of the travel.
        let least_sensor_sd =
            Rounding::white_sd(resolution).max(1e-9 * excitation.travel).max(f64::MIN_POSITIVE.sqrt());
        Self {
            nominal,
            recordings: recordings.into(),
            fitted,
            grids: grids.into(),
            lately,
            early_s: early_s.into(),
            loses_commands: false,
            blocks,
            excitation,
            least_sensor_sd,
            excerpts,
            motions: motions.into(),
            step: resolution,
            // Only a diagnosis has a bound: what ranks a few hypotheses has an end of its own.
            work: Work::of(u64::MAX),
            tally: Tally::default(),
        }
    }
}

/// Rows this many ticks of a loop apart have lost commands between them: two, less what a clock jitters.
pub const SLOWER: f64 = 1.9;

impl Problem {
    /// The same with finer substeps, for values that are to be right to their intervals.
    pub fn finer(&self) -> Self {
        self.in_substeps(FINER, u64::MAX)
    }

    /// The same with the torque column read as what drives the motion, held from row to row or, where it is samples, from the middle between
    /// two rows to the next; none where it is read so already.
    pub fn as_commands(&self) -> Option<Self> {
        let excitation = Excitation { measured: false, ..self.excitation.clone() };
        (!self.motions.is_empty()).then(|| Self {
            motions: Arc::new([]),
            excitation,
            work: Work::of(u64::MAX),
            ..self.clone()
        })
    }

    /// Whether the rows of the torque column hold to the next row, and are no samples that stand for half a row to either side.
    pub(crate) fn is_held(&self) -> bool {
        self.early_s.iter().all(|early_s| *early_s == 0.0)
    }

    /// The same with the rows of the torque column as samples where they were read as values held to the next row, and the other way
    /// round; none where the column is commands.
    pub fn read_otherwise(&self) -> Option<Self> {
        let held = self.is_held();
        let early_s = self.grids.iter().map(|grid| if held { 0.5 * grid.period_s } else { 0.0 }).collect();
        let lately = self.recordings.iter().map(|_| Lately::default()).collect();
        (!self.motions.is_empty()).then(|| Self { early_s, lately, work: Work::of(u64::MAX), ..self.clone() })
    }

    /// The same with substeps as fine as so many passes over them may be for that much work.
    pub(crate) fn finer_within(&self, allowed: u64, passes: u64) -> Self {
        let fits = |finer: &usize| {
            let substeps: usize = self.recordings.iter().map(|one| Grid::finer(one, *finer).substeps()).sum();
            passes * substeps as u64 <= allowed
        };
        self.in_substeps((2..=FINER).rev().find(fits).unwrap_or(1), allowed)
    }

    fn in_substeps(&self, finer: usize, allowed: u64) -> Self {
        Self {
            grids: self.recordings.iter().map(|one| Grid::finer(one, finer)).collect(),
            lately: self.recordings.iter().map(|_| Lately::default()).collect(),
            work: Work::of(allowed),
            ..self.clone()
        }
    }

    /// The same for commands that a loop gave every `tick_s` seconds. Of rows further apart each has one of several, which stands for
    /// those around it, and not for those up to the next row: it acts half the difference earlier. Where the torque column may be a
    /// measurement that is decided already, and only that commands are lost is kept.
    pub fn sampled(mut self, tick_s: f64) -> Self {
        let is_slower = |grid: &Grid| tick_s > 0.0 && grid.period_s >= SLOWER * tick_s;
        self.loses_commands = self.grids.iter().any(is_slower);
        if self.motions.is_empty() && tick_s > 0.0 {
            let early = |grid: &Grid| if is_slower(grid) { 0.5 * (grid.period_s - tick_s) } else { 0.0 };
            self.early_s = self.grids.iter().map(early).collect();
        }
        self
    }

    /// The same with another bound on the work, in substeps of three states.
    pub fn allowing(&self, work: u64) -> Self {
        Self { work: Work::of(work), ..self.clone() }
    }

    /// Does a part of the work on an account of its own, so that parts that are done at the same time end after the same work
    /// however they are spread over cores.
    pub(crate) fn within<T>(&self, allowed: u64, part: impl FnOnce(&Self) -> T) -> T {
        let own = self.allowing(allowed);
        let found = part(&own);
        self.work.add(&own.work);
        found
    }

    /// The same for a part that others do not wait for: whether it ended before its share did, and what is found either way.
    pub(crate) fn sharing<T>(&self, share: u64, part: impl FnOnce(&Self) -> T) -> (T, bool) {
        let own = self.allowing(share);
        let found = part(&own);
        self.work.spend(own.work());
        (found, !own.was_cut())
    }

    /// Counts work done, in substeps of three states.
    pub(crate) fn spend(&self, substeps: usize) {
        self.work.spend(substeps as u64);
        self.tally.count(substeps as u64);
    }

    /// Whether nothing more may be begun, which is noted: to be asked where something would be, and not from several parts that are
    /// done at the same time.
    pub(crate) fn is_spent(&self) -> bool {
        let spent = self.work.left() == 0;
        if spent {
            self.note_cut();
        }
        spent
    }

    /// Notes that something was left out because of the work it would have been.
    pub(crate) fn note_cut(&self) {
        self.work.cut();
    }

    /// Work that is left, in substeps of three states.
    pub(crate) fn left(&self) -> u64 {
        self.work.left()
    }

    /// Whether something was left out because the work allowed was done.
    pub fn was_cut(&self) -> bool {
        self.work.was_cut()
    }

    /// Work done so far, in substeps of three states.
    pub fn work(&self) -> u64 {
        self.work.spent()
    }

    /// Substeps of one pass over all recordings.
    pub fn substeps(&self) -> u64 {
        self.grids.iter().map(|grid| grid.substeps() as u64).sum()
    }

    /// Work as it is done on this problem and all that come of it.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Whether this machine with this excitation can have an effect.
    pub fn may_have(&self, effect: &Effect) -> bool {
        (effect.applies)(&self.nominal, &self.excitation)
    }

    /// Recordings on which a fit is judged: those held out, else those to fit.
    pub fn judged(&self) -> Range<usize> {
        if self.fitted < self.recordings.len() { self.fitted..self.recordings.len() } else { 0..self.fitted }
    }

    /// Where the motion is given, the frequency up to which forces are judged, Hz.
    pub fn band_hz(&self) -> Option<f64> {
        self.motions.iter().map(Motion::band_hz).min_by(f64::total_cmp)
    }

    /// Residuals of the recordings to fit: their rows, or their test functions where the motion is given.
    pub fn residuals(&self) -> usize {
        if self.motions.is_empty() {
            self.recordings[..self.fitted].iter().map(Recorded::rows).sum()
        } else {
            self.motions[..self.fitted].iter().map(Motion::residuals).sum()
        }
    }
}

impl Problem {
    /// Log-likelihood that a free value must bring to rank as high without it (Schwarz 1978).
    pub(crate) fn price(&self) -> f64 {
        0.5 * (self.residuals().max(2) as f64).ln()
    }
}

/// A machine whose model has no drive between the torque column and the rotor: that column may be a measurement.
fn may_be_measured(nominal: &Physics) -> bool {
    nominal.model.torque_delay_s == 0.0 && nominal.model.er.is_none()
}

/// Fewest residual torques of a recording: with fewer its noise is not known to 15 %.
const FEWEST_RESIDUALS: usize = 20;

/// The motion of each recording; empty where one is too short for it.
fn motions(recordings: &[Recorded], resolution: f64) -> Vec<Motion> {
    let all: Vec<Motion> = recordings.iter().map(|recorded| Motion::new(recorded, resolution)).collect();
    if all.iter().all(|motion| motion.residuals() >= FEWEST_RESIDUALS) { all } else { Vec::new() }
}

/// Whether a torque column that may be a measurement is one, or commands held from row to row: what the nominal machine makes
/// likelier, with the noise of each recording. Half a row between them would be taken for a skew of the channels.
fn early(nominal: &Physics, recordings: &[Recorded], grids: &[Grid], motions: &[Motion], resolution: f64) -> Vec<f64> {
    let half_rows: Vec<f64> = if motions.is_empty() {
        vec![0.0; grids.len()]
    } else {
        grids.iter().map(|grid| 0.5 * grid.period_s).collect()
    };
    let log_likelihood = |early_s: &[f64]| -> f64 {
        let of = |(index, motion): (usize, &Motion)| {
            let (recorded, grid) = (&recordings[index], &grids[index]);
            let prepared = Prepared::new(nominal, index, resolution);
            let acting = Acting::new(nominal, index, recorded, grid, early_s[index], &Lately::default())?;
            let residual = prepared.residual(motion, recorded, grid, &acting);
            let noise = prepared.likeliest_noise(motion, &residual);
            let innovations = prepared.whiten(motion, recorded, &residual, &noise);
            Some(innovations.log_likelihood.iter().sum::<f64>())
        };
        motions.iter().enumerate().filter_map(of).sum()
    };
    let held = vec![0.0; grids.len()];
    if log_likelihood(&held) > log_likelihood(&half_rows) { held } else { half_rows }
}

fn stretches(recorded: &Recorded) -> Vec<Range<usize>> {
    let rows = recorded.rows();
    let least = (LEAST_STRETCH_S / recorded.period_s().max(f64::MIN_POSITIVE)).ceil() as usize;
    let (share, length) = (rows / STRETCHES, least.max(EXCERPT_ROWS / STRETCHES));
    if share <= 2 * length {
        return std::iter::once(0..rows).collect();
    }
    (0..STRETCHES)
        .map(|stretch| stretch * share + (share - length) / 2..stretch * share + (share + length) / 2)
        .collect()
}

fn blocks(recorded: &Recorded) -> Vec<Range<usize>> {
    let rows = recorded.rows();
    let per_block = ((BLOCK_S / recorded.period_s().max(f64::MIN_POSITIVE)).round() as usize).clamp(8, rows.max(8));
    let count = (rows / per_block).max(1);
    (0..count).map(|block| block * per_block..if block + 1 == count { rows } else { (block + 1) * per_block }).collect()
}

fn excitation(recordings: &[Recorded], fitted: usize, linear: bool) -> Excitation {
    let mut excitation = Excitation { recordings: recordings.len(), linear, ..Excitation::default() };
    let (mut squares, mut rows) = (0.0, 0);
    for recorded in &recordings[..fitted] {
        for command in &recorded.commands {
            squares += command.torque * command.torque;
            excitation.torque_peak = excitation.torque_peak.max(command.torque.abs());
            excitation.field_peak = excitation.field_peak.max(command.field_kv_mm);
        }
        rows += recorded.rows();
        let (low, high) = recorded
            .position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        excitation.travel = excitation.travel.max(high - low);
        excitation.speed_peak = excitation.speed_peak.max(speed_peak(recorded));
        excitation.duration_s = excitation.duration_s.max(recorded.duration_s());
        excitation.period_s = excitation.period_s.max(recorded.period_s());
    }
    excitation.torque_rms = (squares / f64::from(rows.max(1) as u32)).sqrt();
    excitation.repetitions = recordings.iter().filter_map(Repetition::of).collect();
    excitation
}

/// Largest speed over 20 ms or eight rows, whichever is longer, rad/s (m/s): steps of the sensor are no speed.
fn speed_peak(recorded: &Recorded) -> f64 {
    let apart =
        ((0.02 / recorded.period_s().max(f64::MIN_POSITIVE)).ceil() as usize).clamp(8, recorded.rows().max(9) - 1);
    let speeds = (apart..recorded.rows()).map(|row| {
        ((recorded.position[row] - recorded.position[row - apart]) / (recorded.t_s[row] - recorded.t_s[row - apart]))
            .abs()
    });
    speeds.fold(0.0, f64::max)
}
