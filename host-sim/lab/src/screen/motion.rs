//! One recording prepared: repaired samples, smoothed motion, where the direction is known and where the rotor rests.

use super::actuation::{Chain, chain_means, held_means};
use super::balance;
use super::smoother::{Smoothed, smooth};
use super::waves::Waves;
use crate::effects::Physics;
use crate::read::{Mode, Recording};
use crate::residual::{median_period_s, unsettled};

/// Samples lost in a row that the held command may bridge; longer gaps end every window.
const BRIDGED_S: f64 = 3e-3;
/// Direction is not trusted this close to rest, s.
const MARGIN_S: f64 = 3e-3;

/// Below this share of the largest speed the direction is not trusted.
const SLOW_SHARE: f64 = 3e-3;

/// An isolated wrong sample that was repaired.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Glitch {
    /// Row.
    pub row: usize,
    /// Wrong by this, rad (m).
    pub size: f64,
}

/// A recording as the weak form needs it. A cell is the span between two samples.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Name of the recording.
    pub name: String,
    pub(crate) t_s: Vec<f64>,
    /// Position with glitches repaired.
    pub(crate) position: Vec<f64>,
    /// Smoothed position at the samples.
    pub(crate) smooth: Vec<f64>,
    /// Smoothed speed at the samples.
    pub(crate) speed: Vec<f64>,
    /// Mean position of each cell.
    pub(crate) cell_position: Vec<f64>,
    /// Mean speed of each cell: difference of the smoothed positions.
    pub(crate) cell_speed: Vec<f64>,
    /// Mean sign of the speed in each cell, 0 at rest.
    pub(crate) cell_sign: Vec<f64>,
    /// Cells in which the direction is not known: rest, and its margin.
    pub(crate) at_rest: Vec<bool>,
    /// Cells across which nothing is known.
    pub(crate) broken: Vec<bool>,
    pub(crate) effort: Vec<f64>,
    pub(crate) field: Option<Vec<f64>>,
    pub(crate) braking: Option<Vec<bool>>,
    /// The controller's estimate of the speed, recorded or rebuilt.
    pub(crate) speed_estimate: Vec<f64>,
    pub(crate) glitches: Vec<Glitch>,
    /// How far from its neighbours a sample must be to be taken as wrong, rad (m).
    pub(crate) glitch_limit: f64,
    /// Standard deviation of a position sample, rad (m).
    pub(crate) noise: f64,
    /// Median sample period, s.
    pub(crate) period_s: f64,
}

impl Motion {
    /// Prepares a recording against the nominal machine; `resolution` is the smallest step of the position.
    // Over 40 lines: two passes and a value of seventeen fields.
    pub(crate) fn new(recording: &Recording, nominal: &Physics, resolution: f64) -> Self {
        let t_s = recording.t_s.clone();
        let period_s = median_period_s(&t_s);
        let (position, glitches, glitch_limit) = repair(recording, nominal, resolution, period_s);
        let still = still_cells(&t_s, &position, resolution);
        let drive = held_means(&t_s, &recording.effort_cmd, nominal.torque_delay_s);
        let acceleration = |drag: &[f64]| -> Vec<f64> {
            let limited = |u: f64| {
                (nominal.torque_gain * u + nominal.torque_offset).clamp(-nominal.torque_limit, nominal.torque_limit)
            };
            let cells = drive.iter().zip(drag).zip(&still);
            cells.map(|((&u, &drag), &still)| if still { 0.0 } else { (limited(u) - drag) / nominal.inertia }).collect()
        };
        // The first pass finds the direction; the second knows the drag, so that its reversal is not smoothed away.
        let first = smooth(&t_s, &position, &acceleration(&vec![0.0; drive.len()]), resolution);
        let level = nominal_drag(recording, nominal, &vec![1.0; drive.len()], &first.position);
        let passes = passes(&drive, &level, &still);
        let (sign, _) = directions(&t_s, &first, &passes, &still, resolution);
        let drag = nominal_drag(recording, nominal, &sign, &first.position);
        let second = smooth(&t_s, &position, &acceleration(&drag), resolution);
        let (cell_sign, at_rest) = directions(&t_s, &second, &passes, &still, resolution);
        let unsettled = unsettled(recording);
        let steps = t_s.windows(2).zip(&unsettled);
        let broken =
            steps.map(|(pair, unsettled)| *unsettled || pair[1] - pair[0] > BRIDGED_S.max(2.6 * period_s)).collect();
        let mut motion = Self {
            name: recording.name.clone(),
            cell_position: Vec::new(),
            cell_speed: Vec::new(),
            speed_estimate: recording.velocity.clone().unwrap_or_else(|| rebuilt_speed(&t_s, &position)),
            smooth: Vec::new(),
            speed: Vec::new(),
            cell_sign,
            at_rest,
            broken,
            effort: recording.effort_cmd.clone(),
            field: recording.field_cmd_kv_mm.clone(),
            braking: recording.mode.as_ref().map(|mode| mode.iter().map(|&m| m == Mode::Brake).collect()),
            glitches,
            glitch_limit,
            noise: 0.0,
            period_s,
            t_s,
            position,
        };
        motion.take(second);
        motion
    }

    /// The same recording smoothed with the torques of another machine: with those of the improved one, reversals are
    /// where they were.
    pub(crate) fn again(&self, machine: &Physics, recording: usize, resolution: f64) -> Self {
        let still = still_cells(&self.t_s, &self.position, resolution);
        let drive = balance::drive(machine, self);
        let (damper, friction) = (balance::damper(machine, self), balance::friction(machine, self));
        let waves = Waves::of(machine, std::slice::from_ref(self), None);
        let external = balance::external(machine, self, recording, waves.along(0));
        let known: Vec<f64> = (0..self.cells())
            .map(|cell| {
                let torque = drive[cell] - damper[cell] - friction[cell] + external[cell];
                if still[cell] { 0.0 } else { torque / machine.inertia }
            })
            .collect();
        let smoothed = smooth(&self.t_s, &self.position, &known, resolution);
        let mut motion = self.clone();
        motion.cell_sign.fill(1.0);
        let level: Vec<f64> = balance::damper(machine, &motion)
            .iter()
            .zip(balance::friction(machine, &motion))
            .map(|(a, b)| a + b)
            .collect();
        let passes = passes(&drive, &level, &still);
        (motion.cell_sign, motion.at_rest) = directions(&self.t_s, &smoothed, &passes, &still, resolution);
        motion.take(smoothed);
        motion
    }

    /// Takes the smoothed motion over.
    fn take(&mut self, smoothed: Smoothed) {
        let pairs = smoothed.position.windows(2);
        self.cell_position = pairs.clone().map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        self.cell_speed = pairs.zip(self.t_s.windows(2)).map(|(q, t)| (q[1] - q[0]) / (t[1] - t[0])).collect();
        self.smooth = smoothed.position;
        self.speed = smoothed.speed;
        self.noise = smoothed.noise;
    }

    /// Number of cells.
    pub(crate) fn cells(&self) -> usize {
        self.cell_sign.len()
    }
}

/// The law's speed estimate: backward difference and a low-pass of 1 ms (control.md section 3).
fn rebuilt_speed(t_s: &[f64], position: &[f64]) -> Vec<f64> {
    let mut estimate = 0.0;
    let mut all = vec![0.0];
    for index in 1..t_s.len() {
        let span_s = t_s[index] - t_s[index - 1];
        let raw = (position[index] - position[index - 1]) / span_s;
        estimate += (1.0 - (-span_s / 1e-3).exp()) * (raw - estimate);
        all.push(estimate);
    }
    all
}

fn nominal_drag(recording: &Recording, nominal: &Physics, sign: &[f64], position: &[f64]) -> Vec<f64> {
    let t_s = &recording.t_s;
    let mut drag: Vec<f64> = sign
        .iter()
        .enumerate()
        .map(|(i, s)| s * nominal.coulomb + nominal.viscous * (position[i + 1] - position[i]) / (t_s[i + 1] - t_s[i]))
        .collect();
    if let (Some(damper), Some(field)) = (&nominal.damper, &recording.field_cmd_kv_mm) {
        let chain = Chain {
            delay_s: damper.dead_time_s,
            slew_per_s: damper.slew_kv_mm_s,
            rise_s: damper.rise_s,
            fall_s: damper.fall_s,
        };
        for (index, moments) in chain_means(t_s, field, chain).iter().enumerate() {
            drag[index] += sign[index] * (damper.a * moments.second + damper.b * moments.first);
        }
    }
    drag
}

/// Cells in which the position does not change: the raw samples around stay within one step.
fn still_cells(t_s: &[f64], position: &[f64], resolution: f64) -> Vec<bool> {
    let reach = 4e-3_f64;
    let allowed = 1.01 * resolution + 1e-9;
    let count = t_s.len();
    let (mut from, mut to) = (0, 0);
    (0..count - 1)
        .map(|cell| {
            while t_s[from] < t_s[cell] - reach {
                from += 1;
            }
            while to + 1 < count && t_s[to + 1] <= t_s[cell + 1] + reach {
                to += 1;
            }
            let window = &position[from..=to.max(cell + 1)];
            let (low, high) =
                window.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &q| (low.min(q), high.max(q)));
            high - low <= allowed
        })
        .collect()
}

/// Cells in which the drive overcomes the drag by far, so that a reversal does not stop there.
fn passes(drive: &[f64], level: &[f64], still: &[bool]) -> Vec<bool> {
    let cells = drive.iter().zip(level).zip(still);
    cells.map(|((drive, level), still)| !still && drive.abs() > 1.5 * level.abs()).collect()
}

/// Mean sign of each cell, and where it is not known.
fn directions(
    t_s: &[f64],
    motion: &Smoothed,
    passes: &[bool],
    still: &[bool],
    resolution: f64,
) -> (Vec<f64>, Vec<bool>) {
    let speed = &motion.speed;
    let peak = speed.iter().fold(0.0_f64, |peak, w| peak.max(w.abs()));
    let floor = (2.0 * resolution / 10e-3).min(0.05 * peak).max(SLOW_SHARE * peak);
    let unsure = |row: usize| speed[row].abs() < (3.0 * motion.speed_deviation[row]).min(0.1 * peak).max(floor);
    let cells = t_s.len() - 1;
    let reverses = |cell: usize| speed[cell] * speed[cell + 1] <= 0.0;
    let mut rest: Vec<bool> =
        (0..cells).map(|cell| still[cell] || unsure(cell) || unsure(cell + 1) || reverses(cell)).collect();
    let mut cell = 0;
    while cell < cells {
        let from = cell;
        while cell < cells && rest[cell] {
            cell += 1;
        }
        // A quick passage through zero under a torque that nothing holds is a reversal whose instant is known.
        let quick = cell > from && t_s[cell] - t_s[from] <= MARGIN_S;
        if quick && passes[from..cell].iter().all(|&passes| passes) {
            rest[from..cell].fill(false);
        }
        cell += 1;
    }
    let sign = (0..cells).map(|cell| if still[cell] { 0.0 } else { mean_sign(speed[cell], speed[cell + 1]) }).collect();
    (sign, widened(t_s, &rest))
}

fn mean_sign(before: f64, after: f64) -> f64 {
    if before * after < 0.0 {
        (before.abs() - after.abs()) / (before.abs() + after.abs()) * before.signum()
    } else if before == 0.0 && after == 0.0 {
        0.0
    } else {
        (before + after).signum()
    }
}

/// Marks the margin around every marked cell too.
fn widened(t_s: &[f64], marked: &[bool]) -> Vec<bool> {
    let mut wide = marked.to_vec();
    let mut last_s = f64::NEG_INFINITY;
    for cell in 0..marked.len() {
        if marked[cell] {
            last_s = t_s[cell + 1];
        }
        wide[cell] |= t_s[cell] - last_s < MARGIN_S;
    }
    let mut next_s = f64::INFINITY;
    for cell in (0..marked.len()).rev() {
        if marked[cell] {
            next_s = t_s[cell];
        }
        wide[cell] |= next_s - t_s[cell + 1] < MARGIN_S;
    }
    wide
}

/// A step of the acceleration two thirds of a sample before or after a row moves it off the cubic through its neighbours by
/// 1/9 of the step times the period squared, and by less anywhere else; twice that, for a step that comes with another.
const IN_STENCIL: f64 = 2.0 / 9.0;

/// Replaces isolated wrong samples by the cubic through their neighbours; and how far from it a sample must be to be wrong,
/// rad (m).
fn repair(recording: &Recording, nominal: &Physics, resolution: f64, period_s: f64) -> (Vec<f64>, Vec<Glitch>, f64) {
    let t_s = &recording.t_s;
    let mut position = recording.position.clone();
    let count = position.len();
    if count < 9 {
        return (position, Vec::new(), f64::INFINITY);
    }
    let excess = |position: &[f64], row: usize| position[row] - through_neighbours(t_s, position, row);
    let mut spread: Vec<f64> = (2..count - 2).map(|row| excess(&position, row).abs()).collect();
    spread.sort_by(f64::total_cmp);
    let typical = spread[spread.len() / 2];
    // What the largest possible change of acceleration does within the stencil is no glitch.
    let peak = recording.effort_cmd.iter().fold(0.0_f64, |peak, u| peak.max(u.abs()));
    let jerk = IN_STENCIL * 2.0 * peak / nominal.inertia * period_s * period_s;
    let allowed = (12.0 * typical).max(4.0 * resolution) + jerk;
    let mut glitches = Vec::new();
    let mut row = 2;
    while row < count - 2 {
        let here = excess(&position, row).abs();
        let peak =
            (row - 1..=row + 1).all(|other| !(2..count - 2).contains(&other) || excess(&position, other).abs() <= here);
        if here > allowed && peak && t_s[row + 2] - t_s[row - 2] < 12.0 * period_s {
            let repaired = through_neighbours(t_s, &position, row);
            glitches.push(Glitch { row, size: position[row] - repaired });
            position[row] = repaired;
            row += 2;
        }
        row += 1;
    }
    (position, glitches, allowed)
}

/// Lagrange's cubic through the two samples before and the two after, at a row.
fn through_neighbours(t_s: &[f64], position: &[f64], row: usize) -> f64 {
    let rows = [row - 2, row - 1, row + 1, row + 2];
    let mut value = 0.0;
    for i in rows {
        let mut weight = 1.0;
        for j in rows {
            if i != j {
                weight *= (t_s[row] - t_s[j]) / (t_s[i] - t_s[j]);
            }
        }
        value += weight * position[i];
    }
    value
}
