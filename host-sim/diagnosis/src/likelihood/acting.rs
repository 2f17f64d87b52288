//! What acts on the rotor in every substep of a recording.
//!
//! The motion has no part in it, so hypotheses that differ in friction or load share it: each half is computed from its cause
//! alone, a machine that has nothing else, and the halves looked at lately are kept.

use std::sync::{Arc, Mutex, PoisonError};

use plant::effects::Vibration;
use plant::{Command, Er, FluidResponse, Model, Segment, Timeline};

use super::commands::{blurred, unfiltered};
use super::grid::Grid;
use crate::physics::Physics;
use crate::recorded::Recorded;

/// What acts in each substep, as means over it.
#[derive(Debug, Clone)]
pub struct Acting {
    pub(crate) drive: Arc<OfDrive>,
    pub(crate) fluid: Arc<OfFluid>,
}

/// What drive and surroundings do.
#[derive(Debug)]
pub(crate) struct OfDrive {
    /// Torque of drive and outside, N m (N).
    pub(crate) torque: Vec<f64>,
    /// Of that, the drive's before its ripple, N m (N).
    pub(crate) drive: Vec<f64>,
}

/// What the fluid does.
#[derive(Debug)]
pub(crate) struct OfFluid {
    /// Set-valued drag, or the torque at which the fluid's spring yields, N m (N); empty without a fluid.
    pub(crate) level: Vec<f64>,
    /// Viscous coefficient, N m s/rad (N s/m); empty where the fluid has none.
    pub(crate) viscosity: Vec<f64>,
    /// Consistency of the flow curve, N m (s/rad)^n; empty where the fluid has none.
    pub(crate) consistency: Vec<f64>,
}

/// All that the drive's half depends on.
#[derive(Debug, Clone, PartialEq)]
struct CauseOfDrive {
    model: Model,
    torque_filter_s: f64,
    command_blur_s: f64,
    /// The substep at t shows what acted at t minus this, s.
    shift_s: f64,
}

/// All that the fluid's half depends on.
#[derive(Debug, Clone, PartialEq)]
struct CauseOfFluid {
    model: Model,
    /// The substep at t shows what acted at t minus this, s.
    shift_s: f64,
}

/// What acted in one recording under the machines that were looked at lately.
#[derive(Debug, Default)]
pub struct Lately {
    drive: Memo<CauseOfDrive, OfDrive>,
    fluid: Memo<CauseOfFluid, OfFluid>,
}

/// The last few results with what they were computed from, the latest last.
#[derive(Debug)]
struct Memo<C, R> {
    kept: Mutex<Vec<(C, Arc<R>)>>,
}

/// Results that are kept: one each for the hypotheses that are fitted at the same time, some megabytes a recording.
const KEPT: usize = 6;

impl<C, R> Default for Memo<C, R> {
    fn default() -> Self {
        Self { kept: Mutex::new(Vec::new()) }
    }
}

impl<C: PartialEq, R> Memo<C, R> {
    fn get(&self, cause: C, compute: impl FnOnce(&C) -> Option<R>) -> Option<Arc<R>> {
        {
            let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(at) = kept.iter().position(|(other, _)| *other == cause) {
                let found = kept.remove(at);
                let result = Arc::clone(&found.1);
                kept.push(found);
                return Some(result);
            }
        }
        // Computed without the lock: two threads may compute the same, and get the same.
        let result = Arc::new(compute(&cause)?);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() >= KEPT {
            kept.remove(0);
        }
        kept.push((cause, Arc::clone(&result)));
        Some(result)
    }
}

impl Acting {
    /// For one recording of a machine, or none for a model that the plant refuses. A command is held from its row to the next, and
    /// all of them act so many seconds early.
    pub fn new(
        physics: &Physics,
        index: usize,
        recorded: &Recorded,
        grid: &Grid,
        early_s: f64,
        lately: &Lately,
    ) -> Option<Self> {
        let model = physics.model_of(index);
        model.validate().ok()?;
        let latency_s = model.sensor.latency_s;
        let (of_drive, of_fluid) = halves(model);
        let drive = CauseOfDrive {
            model: of_drive,
            torque_filter_s: physics.torque_filter_s,
            command_blur_s: physics.command_blur_s,
            shift_s: latency_s + physics.skew_s - early_s,
        };
        let fluid = CauseOfFluid { model: of_fluid, shift_s: latency_s };
        Some(Self {
            drive: lately.drive.get(drive, |cause| OfDrive::new(cause, recorded, grid))?,
            fluid: lately.fluid.get(fluid, |cause| OfFluid::new(cause, recorded, grid))?,
        })
    }
}

/// Machines that have nothing but the drive with the surroundings, and nothing but the fluid.
fn halves(model: Model) -> (Model, Model) {
    // Without `..`: a field that an effect adds has to be thought of here.
    let Model {
        inertia: _,
        coulomb: _,
        viscous: _,
        torque_gain,
        torque_offset,
        torque_limit,
        torque_deadband,
        torque_delay_s,
        torque_lag_s,
        er,
        stribeck: _,
        asymmetry: _,
        presliding_stiffness: _,
        load_friction: _,
        viscous_warming: _,
        quadratic_drag: _,
        cogging: _,
        torque_ripple: _,
        gravity: _,
        spring_stiffness: _,
        shaft: _,
        pulses,
        vibration,
        sensor: _,
    } = model;
    let bare = Model::new(1.0);
    let drive = Model {
        torque_gain,
        torque_offset,
        torque_limit,
        torque_deadband,
        torque_delay_s,
        torque_lag_s,
        pulses,
        vibration,
        ..bare.clone()
    };
    // Its warmth and its spring are matters of the motion.
    let er = er.map(|Er { a, b, response, field_gain, scale, drift_per_s, warming: _, preyield_stiffness: _ }| Er {
        a,
        b,
        response,
        field_gain,
        scale,
        drift_per_s,
        warming: None,
        preyield_stiffness: None,
    });
    (drive, Model { er, ..bare })
}

/// The segments of a machine whose first command has always been held.
fn timeline(model: &Model, t_s: &[f64], commands: &[Command]) -> Option<Timeline> {
    let before = Command { speed_estimate: 0.0, ..commands.first().copied().unwrap_or_default() };
    Timeline::new(model, t_s, commands, &before).ok()
}

impl OfDrive {
    fn new(cause: &CauseOfDrive, recorded: &Recorded, grid: &Grid) -> Option<Self> {
        let commands = unfiltered(recorded, cause.torque_filter_s).or_else(|| blurred(recorded, cause.command_blur_s));
        let timeline = timeline(&cause.model, &recorded.t_s, commands.as_deref().unwrap_or(&recorded.commands))?;
        let outside = Outside { vibration: cause.model.vibration };
        let substeps = grid.substeps();
        let mut all = Self { torque: Vec::with_capacity(substeps), drive: Vec::with_capacity(substeps) };
        means(
            timeline.segments(),
            cause.shift_s,
            recorded,
            grid,
            |segment, from_s, to_s| [segment.torque.mean(from_s, to_s), outside.mean(segment, from_s, to_s)],
            |_, [drive, outside]| {
                all.drive.push(drive);
                all.torque.push(drive + outside);
            },
        );
        Some(all)
    }
}

impl OfFluid {
    fn new(cause: &CauseOfFluid, recorded: &Recorded, grid: &Grid) -> Option<Self> {
        let mut all = Self { level: Vec::new(), viscosity: Vec::new(), consistency: Vec::new() };
        let Some(er) = &cause.model.er else { return Some(all) };
        // The drive's torque would only split the segments.
        let commands: Vec<Command> = recorded.commands.iter().map(|one| Command { torque: 0.0, ..*one }).collect();
        let timeline = timeline(&cause.model, &recorded.t_s, &commands)?;
        let (a, b) = er.acting();
        let drift = |t_s: f64| (1.0 + er.drift_per_s * t_s).max(0.0);
        let (segments, shift_s) = (timeline.segments(), cause.shift_s);
        if let FluidResponse::Field(field) = er.response {
            let both = |segment: &Segment, from_s: f64, to_s: f64| {
                let acting = segment.fluid.at(0.5 * (from_s + to_s));
                [(a * acting + b) * acting, field.flow.map_or(0.0, |curve| curve.at(er.field_gain * acting))]
            };
            means(segments, shift_s, recorded, grid, both, |t_s, [level, consistency]| {
                all.level.push(drift(t_s) * level);
                if field.flow.is_some() {
                    all.consistency.push(drift(t_s) * consistency);
                }
            });
        } else {
            let both = |segment: &Segment, from_s: f64, to_s: f64| {
                let middle_s = 0.5 * (from_s + to_s);
                [segment.brake_torque.at(middle_s), segment.fluid.at(middle_s)]
            };
            means(segments, shift_s, recorded, grid, both, |t_s, [level, viscosity]| {
                all.level.push(drift(t_s) * level);
                all.viscosity.push(drift(t_s) * viscosity);
            });
        }
        Some(all)
    }
}

/// Torque of the surroundings.
struct Outside {
    vibration: Option<Vibration>,
}

impl Outside {
    fn mean(&self, segment: &Segment, from_s: f64, to_s: f64) -> f64 {
        let middle_s = segment.start_s + 0.5 * (from_s + to_s);
        segment.external_torque + self.vibration.map_or(0.0, |vibration| vibration.torque(middle_s))
    }
}

/// Walks through the segments substep by substep. `value` gives means of a part of a segment, from when to when after its start,
/// s; `take` gets the middle of each substep, s, and the means over it.
fn means<const K: usize>(
    segments: &[Segment],
    shift_s: f64,
    recorded: &Recorded,
    grid: &Grid,
    value: impl Fn(&Segment, f64, f64) -> [f64; K],
    mut take: impl FnMut(f64, [f64; K]),
) {
    let last = segments.len() - 1;
    let mut index = 0;
    for (row, &dt_s) in grid.dt_s.iter().enumerate() {
        for step in 0..grid.first[row + 1] - grid.first[row] {
            let start_s = recorded.t_s[row] + f64::from(step) * dt_s - shift_s;
            let end_s = start_s + dt_s;
            while index < last && segments[index].end_s <= start_s {
                index += 1;
            }
            let (mut at, mut from_s, mut sums) = (index, start_s, [0.0; K]);
            let mut length_s = 0.0;
            while from_s < end_s && at <= last {
                let segment = &segments[at];
                // Before the first and behind the last segment their ends hold.
                let to_s = if at == last { end_s } else { segment.end_s.min(end_s) };
                if to_s > from_s {
                    let piece_from_s = (from_s - segment.start_s).max(0.0);
                    let piece_to_s = (to_s - segment.start_s).max(dt_s * 1e-6);
                    let piece_s = piece_to_s - piece_from_s;
                    for (sum, value) in sums.iter_mut().zip(value(segment, piece_from_s, piece_to_s)) {
                        *sum += piece_s * value;
                    }
                    length_s += piece_s;
                }
                from_s = from_s.max(to_s);
                at += 1;
            }
            take(start_s + 0.5 * dt_s + shift_s, sums.map(|sum| sum / length_s));
        }
    }
}
