//! What acts on the rotor in every substep of a recording.

use plant::{Command, Er, FluidResponse, Model, Segment, Timeline};

use crate::physics::Physics;
use crate::recorded::Recorded;

/// A substep at fast sampling, s: with it the belief's own error over 50 ms is a third of the servo's sensor step (measured
/// against the plant, `tests/likelihood.rs`) ...
const FINE_S: f64 = 2.5e-4;
/// ... in so many substeps a row.
const FEWEST: usize = 2;
/// At slow sampling this many a row do ...
const ENOUGH: usize = 4;
/// ... but no substep is longer than this, s: a tenth of the shortest time constant of a servo axis that a log of 50 ms can show ...
const LONGEST_S: f64 = 1e-3;
/// ... and no row, such as one behind a gap, has more than this many.
const MOST: usize = 64;

/// Where the substeps of a recording lie; the same for every hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// First substep of each row's interval to the next row, and one past the last.
    pub(crate) first: Vec<u32>,
    /// Length of the substeps of each row's interval, s.
    pub(crate) dt_s: Vec<f64>,
}

impl Grid {
    /// The grid of a recording.
    pub fn new(recorded: &Recorded) -> Self {
        let (mut first, mut dt_s, mut at) = (Vec::new(), Vec::new(), 0_u32);
        for pair in recorded.t_s.windows(2) {
            let interval_s = pair[1] - pair[0];
            // A thousandth less, so that rounding of times makes no substep more.
            let of = |length_s: f64| (0.999 * interval_s / length_s).ceil() as usize;
            let count = of(FINE_S).clamp(FEWEST, ENOUGH).max(of(LONGEST_S)).min(MOST);
            first.push(at);
            dt_s.push(interval_s / count as f64);
            at += count as u32;
        }
        first.push(at);
        Self { first, dt_s }
    }

    /// Number of substeps.
    pub fn substeps(&self) -> usize {
        self.first.last().map_or(0, |last| *last as usize)
    }
}

/// What acts in each substep, as means over it. The motion has no part in it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Acting {
    /// Torque of drive and outside, N m (N).
    pub(crate) torque: Vec<f64>,
    /// Of that, the drive's before its ripple, N m (N).
    pub(crate) drive: Vec<f64>,
    /// Set-valued drag of the fluid, or the torque at which its spring yields, N m (N); empty without a fluid.
    pub(crate) level: Vec<f64>,
    /// Viscous coefficient of the fluid, N m s/rad (N s/m); empty where the fluid has none.
    pub(crate) viscosity: Vec<f64>,
}

impl Acting {
    /// For one recording of a machine, or none for a model that the plant refuses. A command is held from its row to the next; a
    /// measurement is a sample, and stands for half a row to either side.
    pub fn new(physics: &Physics, index: usize, recorded: &Recorded, grid: &Grid, measured: bool) -> Option<Self> {
        let model = physics.model_of(index);
        let commands =
            unfiltered(recorded, physics.torque_filter_s).or_else(|| blurred(recorded, physics.command_blur_s));
        let commands: &[Command] = commands.as_deref().unwrap_or(&recorded.commands);
        let before = Command { speed_estimate: 0.0, ..commands.first().copied().unwrap_or_default() };
        let timeline = Timeline::new(&model, &recorded.t_s, commands, &before).ok()?;
        let latency_s = model.sensor.latency_s;
        let mut acting = Self::default();
        let early_s = if measured { 0.5 * recorded.period_s() } else { 0.0 };
        let torque = Reader { segments: timeline.segments(), shift_s: latency_s + physics.skew_s - early_s };
        let outside = Outside { model: &model };
        torque.read(recorded, grid, |_, pieces| {
            let drive = mean_over(pieces, |segment, from_s, to_s| segment.torque.mean(from_s, to_s));
            acting.drive.push(drive);
            acting.torque.push(drive + outside.mean(pieces));
        });
        if let Some(er) = &model.er {
            let fluid = Reader { segments: timeline.segments(), shift_s: latency_s };
            let (a, b) = er.acting();
            // Without `..`: a field that an effect adds has to be thought of here. Warming is a matter of the motion.
            let Er { a: _, b: _, response, field_gain: _, scale: _, drift_per_s, warming: _, preyield_stiffness: _ } =
                er;
            let viscous = !matches!(response, FluidResponse::Field(_));
            fluid.read(recorded, grid, |t_s, pieces| {
                let drift = (1.0 + drift_per_s * t_s).max(0.0);
                if viscous {
                    acting.level.push(drift * mean(pieces, |segment, at_s| segment.brake_torque.at(at_s)));
                    acting.viscosity.push(drift * mean(pieces, |segment, at_s| segment.fluid.at(at_s)));
                } else {
                    let field = |segment: &Segment, at_s: f64| segment.fluid.at(at_s);
                    acting.level.push(
                        drift * mean(pieces, |segment, at_s| (a * field(segment, at_s) + b) * field(segment, at_s)),
                    );
                }
            });
        }
        Some(acting)
    }
}

/// A part of a substep within one segment: the segment, and from when to when after its start, s.
type Piece<'a> = (&'a Segment, f64, f64);

/// Mean over the pieces, by the value in the middle of each.
fn mean(pieces: &[Piece<'_>], value: impl Fn(&Segment, f64) -> f64) -> f64 {
    mean_over(pieces, |segment, from_s, to_s| value(segment, 0.5 * (from_s + to_s)))
}

/// Mean over the pieces, by the mean of each.
fn mean_over(pieces: &[Piece<'_>], value: impl Fn(&Segment, f64, f64) -> f64) -> f64 {
    let (mut sum, mut length_s) = (0.0, 0.0);
    for (segment, from_s, to_s) in pieces {
        sum += (to_s - from_s) * value(segment, *from_s, *to_s);
        length_s += to_s - from_s;
    }
    sum / length_s
}

/// Torque of the surroundings.
struct Outside<'a> {
    model: &'a Model,
}

impl Outside<'_> {
    fn mean(&self, pieces: &[Piece<'_>]) -> f64 {
        mean_over(pieces, |segment, from_s, to_s| {
            let middle_s = segment.start_s + 0.5 * (from_s + to_s);
            let shaken = self.model.vibration.map_or(0.0, |vibration| vibration.torque(middle_s));
            segment.external_torque + shaken
        })
    }
}

/// Walks through the segments substep by substep.
struct Reader<'a> {
    segments: &'a [Segment],
    /// The substep at t shows what acted at t minus this, s.
    shift_s: f64,
}

impl Reader<'_> {
    fn read(&self, recorded: &Recorded, grid: &Grid, mut take: impl FnMut(f64, &[Piece<'_>])) {
        let mut index = 0;
        let mut pieces: Vec<Piece<'_>> = Vec::with_capacity(8);
        for (row, &dt_s) in grid.dt_s.iter().enumerate() {
            let count = grid.first[row + 1] - grid.first[row];
            for step in 0..count {
                let start_s = recorded.t_s[row] + f64::from(step) * dt_s - self.shift_s;
                let end_s = start_s + dt_s;
                while index + 1 < self.segments.len() && self.segments[index].end_s <= start_s {
                    index += 1;
                }
                pieces.clear();
                let (mut at, mut from_s) = (index, start_s);
                while from_s < end_s {
                    let segment = &self.segments[at];
                    // Before the first and behind the last segment their ends hold.
                    let to_s = if at + 1 == self.segments.len() { end_s } else { segment.end_s.min(end_s) };
                    if to_s > from_s {
                        pieces.push((
                            segment,
                            (from_s - segment.start_s).max(0.0),
                            (to_s - segment.start_s).max(dt_s * 1e-6),
                        ));
                    }
                    from_s = from_s.max(to_s);
                    at += 1;
                    if at >= self.segments.len() {
                        break;
                    }
                }
                take(start_s + 0.5 * dt_s + self.shift_s, &pieces);
            }
        }
    }
}

/// The commands whose torque a first-order filter of `tau_s` turned into the recorded ones: T + tau dT/dt, by differences
/// over the neighbouring rows.
fn unfiltered(recorded: &Recorded, tau_s: f64) -> Option<Vec<Command>> {
    if tau_s <= 0.0 {
        return None;
    }
    let (t_s, commands) = (&recorded.t_s, &recorded.commands);
    let last = commands.len().checked_sub(1)?;
    let rate = |row: usize| {
        let (from, to) = (row.saturating_sub(1), (row + 1).min(last));
        if to > from { (commands[to].torque - commands[from].torque) / (t_s[to] - t_s[from]) } else { 0.0 }
    };
    Some((0..=last).map(|row| Command { torque: commands[row].torque + tau_s * rate(row), ..commands[row] }).collect())
}

/// The commands whose torque is the mean of what was commanded in the last `over_s`, looked at in the middle of each row's interval.
fn blurred(recorded: &Recorded, over_s: f64) -> Option<Vec<Command>> {
    if over_s <= 0.0 {
        return None;
    }
    let (t_s, commands) = (&recorded.t_s, &recorded.commands);
    let mut sums = vec![0.0];
    for (row, pair) in t_s.windows(2).enumerate() {
        sums.push(sums[row] + commands[row].torque * (pair[1] - pair[0]));
    }
    let first = commands.first()?.torque;
    let mut from = 0;
    let means = (0..commands.len()).map(|row| {
        let middle_s = t_s.get(row + 1).map_or(t_s[row], |next_s| 0.5 * (t_s[row] + next_s));
        let began_s = middle_s - over_s;
        while from + 1 < t_s.len() && t_s[from + 1] <= began_s {
            from += 1;
        }
        let until = sums[row] + commands[row].torque * (middle_s - t_s[row]);
        // Before the first row its command held.
        let before = if began_s < t_s[0] {
            first * (began_s - t_s[0])
        } else {
            sums[from] + commands[from].torque * (began_s - t_s[from])
        };
        Command { torque: (until - before) / over_s, ..commands[row] }
    });
    Some(means.collect())
}
