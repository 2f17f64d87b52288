//! The vocabulary: one file for each effect, with its equation, parameters, start grid, and the sentence that names it.
//!
//! An effect changes numbers of [`Physics`]; what those numbers do is in the crate `plant`. Adding an effect is adding a file
//! and a line here.

mod backlash;
mod channel_skew;
mod cogging;
mod compliance;
mod coulomb_friction;
mod disturbance_pulse;
mod er_drift;
mod er_flow;
mod er_preyield;
mod er_strength;
mod example;
mod field_dead_time;
mod field_gain;
mod field_kinetics;
mod field_lag;
mod field_lag_asymmetry;
mod field_slew_limit;
mod friction_asymmetry;
mod gravity_load;
mod inertia;
mod load_dependent_friction;
mod nuisances;
mod parameter;
mod presliding;
mod quadratic_drag;
mod resolver_eccentricity;
mod sensor_glitch;
mod sensor_latency;
mod size;
mod spring_load;
mod stribeck_friction;
mod temperature_viscosity;
mod temperature_yield;
mod torque_deadband;
mod torque_delay;
mod torque_filter;
mod torque_gain;
mod torque_lag;
mod torque_offset;
mod torque_ripple;
mod torque_saturation;
mod vibration;
mod viscosity_dead_time;
mod viscosity_lag;
mod viscous_friction;

use std::f64::consts::TAU;

use plant::effects::{Harmonic, Pulse};

use crate::physics::{Physics, Tone};
use crate::repetition::Repetition;

pub use example::Example;
pub(crate) use example::{shown, shown_as_another, shown_by};
pub use nuisances::NUISANCES;
pub use parameter::{Parameter, Range};
pub(crate) use parameter::{fixed, free, rough, searched, sized};
pub use size::Size;

/// What these recordings excite: sizes that start grids are scaled by, and candidates found in the residual.
#[derive(Debug, Clone, Default)]
pub struct Excitation {
    /// Root mean square of the commanded torque, N m (N).
    pub torque_rms: f64,
    /// Largest commanded torque, N m (N).
    pub torque_peak: f64,
    /// Largest speed, rad/s (m/s).
    pub speed_peak: f64,
    /// Travel, rad (m).
    pub travel: f64,
    /// Largest commanded field, kV/mm; 0 without a field column.
    pub field_peak: f64,
    /// Smallest commanded field above 0, kV/mm; 0 without one.
    pub field_least: f64,
    /// Step of the position sensor, rad (m); 0 for a continuous one.
    pub step: f64,
    /// Longest recording, s.
    pub duration_s: f64,
    /// Median sample period, s.
    pub period_s: f64,
    /// Number of recordings fitted.
    pub recordings: usize,
    /// Rotary or linear.
    pub linear: bool,
    /// Whether the torque column is read as a measurement.
    pub measured: bool,
    /// Orders over position that stand out of the residual, best first.
    pub orders: Vec<f64>,
    /// The same of the residual's share that goes along with the drive's torque.
    pub ripple_orders: Vec<f64>,
    /// Pushes that stand out of the residual, each with its recording, best first.
    pub pulses: Vec<(usize, Pulse)>,
    /// Tones that stand out of the residual, best first.
    pub tones: Vec<Tone>,
    /// Of the recordings whose motion repeats itself.
    pub repetitions: Vec<Repetition>,
    /// Orders, frequencies and places in time that were looked at.
    pub looked_at: [f64; 3],
    /// Share and size of isolated samples that stand out, if there are any.
    pub glitch: Option<(f64, f64)>,
}

impl Excitation {
    /// Distance of the orders over position that are told apart, 1/rad (1/m): whole ones of a revolution, on a linear axis what the travel tells.
    pub(crate) fn orders_apart(&self) -> f64 {
        if self.linear { TAU / self.travel } else { 1.0 }
    }

    /// The lowest order that comes back as often as an effect asks for; on a linear axis once in the travel, for less is any slope that is
    /// missing. None where it has no order.
    pub(crate) fn lowest_order(&self, of: &Effect) -> Option<f64> {
        let of_travel = TAU / self.travel;
        let lowest = |asked: LowestOrder| asked.of_revolution.max(asked.of_travel * of_travel);
        of.lowest_order.map(|asked| if self.linear { of_travel } else { lowest(asked) })
    }
}

/// How often what has an order must come back, at the least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowestOrder {
    /// In a revolution.
    pub of_revolution: f64,
    /// In the travel of a rotary axis, whose whole orders may be slower than that: 0 for what shows in a part of a period.
    pub of_travel: f64,
}

/// How the columns of an effect are made at a start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Columns {
    /// One: the whole step from the machine without it to the start.
    Whole,
    /// One for each free number: it adds in proportion to each.
    Each,
    /// One, in proportion to the value at that index.
    Scaled(usize),
}

/// Recording, start and end, s.
pub type Span = (usize, f64, f64);

/// How an effect is a wider form of another.
#[derive(Clone, Copy)]
pub struct Widening {
    /// The other.
    pub narrower: &'static Effect,
    /// Starts of this one from fitted values of the other.
    pub wider: fn(&[f64], &Excitation) -> Vec<Vec<f64>>,
    /// A start of the other from fitted values of this one.
    pub within: fn(&[f64]) -> Vec<f64>,
}

/// One entry of the vocabulary.
pub struct Effect {
    /// Identifier of the specification.
    pub id: &'static str,
    /// One sentence for an engineer: what it is and where it usually comes from.
    pub sentence: &'static str,
    /// What the fit moves; where there are more values than entries, the last entry repeats.
    pub parameters: &'static [Parameter],
    /// Whether this machine with this excitation can have it.
    pub applies: fn(&Physics, &Excitation) -> bool,
    /// Start values, from the nominal machine outwards.
    pub starts: fn(&Physics, &Excitation) -> Vec<Vec<f64>>,
    /// Puts values into the machine.
    pub put: fn(&mut Physics, &[f64]),
    /// Whether the machine that has it is one in which it explains anything of such a motion (judge.md, "Never an explanation").
    pub explains: fn(&Physics, &Excitation) -> bool,
    /// From fitted to reported values.
    pub report: fn(&[f64]) -> Vec<f64>,
    /// From reported to fitted values, for an entry of a machine file in a recording; none for what is no part of a model.
    pub fitted: fn(&[f64], Option<usize>) -> Option<Vec<f64>>,
    /// The reported values at `leading` of the machine without it.
    pub neutral: fn(&Physics) -> f64,
    /// Indices of the reported values that say how strong it is: it is there if one of them is not what it is without it.
    pub leading: &'static [usize],
    /// How its columns are made.
    pub columns: Columns,
    /// How low an order its first value may be; none where that is no order.
    pub lowest_order: Option<LowestOrder>,
    /// It may stand in a hypothesis more than once.
    pub repeats: bool,
    /// Recording, start and end, s, of what happens once: nothing elsewhere can predict it. None for what holds always.
    pub span: fn(&[f64]) -> Option<Span>,
    /// It happens once.
    pub once: bool,
    /// It adds a memory to the machine: what it does from a start is far from what a column promises.
    pub remembers: bool,
    /// An effect that it is a wider form of; each starts from the other's fitted values.
    pub widens: Option<Widening>,
    /// The recording that the value at an index belongs to alone; none for what holds for all of them.
    pub recording_of: fn(&[f64], usize) -> Option<usize>,
    /// Places that were looked at to find its starts, beside the starts themselves.
    pub looked_at: fn(&Excitation) -> f64,
    /// Effects that no motion of a machine without a fluid tells from it.
    pub alike: &'static [&'static str],
    /// Effects that with the same fitted values are the same, beside a fluid too.
    pub alike_beside_a_fluid: fn(&[f64]) -> &'static [&'static str],
    /// A measurement of another kind that tells it where no motion does, as an instruction; none where only motion tells.
    pub measured_by: Option<&'static str>,
    /// It is part of the first hypothesis of a machine that can have it: other effects stand in for it where it is missing.
    pub first: bool,
    /// It may be the answer; else it only competes.
    pub nameable: bool,
    /// Its sizes on the default servo; none for events and wrong samples, which no experiment brings back.
    pub example: Option<Example>,
}

/// What most entries have; an entry overrides what it has otherwise.
pub(crate) const PLAIN: Effect = Effect {
    id: "",
    sentence: "",
    parameters: &[],
    applies: |_, _| true,
    starts: |_, _| Vec::new(),
    put: |_, _| {},
    explains: |_, _| true,
    report: <[f64]>::to_vec,
    fitted: |v, _| Some(v.to_vec()),
    neutral: |_| 0.0,
    leading: &[0],
    columns: Columns::Whole,
    lowest_order: None,
    repeats: false,
    span: |_| None,
    once: false,
    remembers: false,
    widens: None,
    recording_of: |_, _| None,
    looked_at: |_| 1.0,
    alike: &[],
    alike_beside_a_fluid: |_| &[],
    measured_by: None,
    first: false,
    nameable: true,
    example: None,
};

impl std::fmt::Debug for Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id)
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl Effect {
    /// Bounds and scale of the value at `index`.
    pub fn parameter(&self, index: usize) -> Parameter {
        self.parameters[index.min(self.parameters.len() - 1)]
    }

    /// Whether it changes samples and no motion: no derivative of the innovations tells its values.
    pub fn changes_samples_only(&self) -> bool {
        self.parameter(0).searched
    }

    /// Bounds and scale of each value on a machine.
    pub fn ranges(&self, count: usize, physics: &Physics, excitation: &Excitation) -> Vec<Range> {
        let range = |index| {
            let parameter = self.parameter(index);
            let size = parameter.size.of(physics, excitation);
            Range { low: parameter.low * size, high: parameter.high * size, scale: parameter.scale * size }
        };
        (0..count).map(range).collect()
    }

    /// Number of fitted values that count as freedom, for values of that length.
    pub fn freedom(&self, values: &[f64]) -> usize {
        (0..values.len()).filter(|&index| self.parameter(index).free || self.parameter(index).searched).count()
    }
}

/// Values order, sine, cosine of amplitude, order, phase.
pub(crate) fn order_sine_cosine(reported: &[f64], _: Option<usize>) -> Option<Vec<f64>> {
    let &[amplitude, order, phase_rad] = reported else { return None };
    Some(vec![order, amplitude * phase_rad.cos(), amplitude * phase_rad.sin()])
}

/// A machine whose damper is driven in these recordings.
pub(crate) fn with_field(physics: &Physics, excitation: &Excitation) -> bool {
    physics.model.er.is_some() && excitation.field_peak > 0.0
}

/// Whether dry friction at rest gives way to the drive with all that pulls at the axis: under more nothing would ever move, and what else
/// is missing would show in nothing.
pub(crate) fn gives_way(physics: &Physics, excitation: &Excitation) -> bool {
    let model = &physics.model;
    let at_rest = model.coulomb + model.stribeck.map_or(0.0, |stribeck| stribeck.excess);
    let weight = model.gravity.as_ref().map_or(0.0, |gravity| gravity.amplitude);
    let cogging: f64 = model.cogging.iter().map(|harmonic| harmonic.amplitude.abs()).sum();
    let drive = model.torque_gain * excitation.torque_peak + model.torque_offset.abs();
    at_rest < drive + weight + cogging + model.spring_stiffness * excitation.travel
}

/// Recordings whose torque column is read as commands, with a drive between it and the rotor.
pub(crate) fn commanded(_: &Physics, excitation: &Excitation) -> bool {
    !excitation.measured
}

/// Recordings whose torque column is read as a measurement.
pub(crate) fn measured(_: &Physics, excitation: &Excitation) -> bool {
    excitation.measured
}

/// Recordings whose torque column may be stamped at times of its own: a measurement, or the torque of a machine whose drive has no
/// delay that would tell it from its command, beside the field's commands.
pub(crate) fn may_be_skewed(nominal: &Physics, excitation: &Excitation) -> bool {
    excitation.measured || nominal.model.er.is_some() && nominal.model.torque_delay_s == 0.0
}

/// The sine of values order, sine, cosine.
pub(crate) fn harmonic(values: &[f64]) -> Harmonic {
    Harmonic { order: values[0], amplitude: values[1].hypot(values[2]), phase_rad: values[2].atan2(values[1]) }
}

/// Largest field that the drive commands, kV/mm (control specification, section 3).
const LARGEST_FIELD_KV_MM: f64 = 3.5;

/// The torque of the damper at its largest field, N m: more than that no delay of a viscosity makes.
pub(crate) fn strongest(er: &plant::Er) -> f64 {
    let (a, b) = er.acting();
    (a * LARGEST_FIELD_KV_MM + b) * LARGEST_FIELD_KV_MM
}

/// What tells how much moves, and by how much torque.
pub(crate) const WEIGH: &str =
    "weigh what moves, or measure the torque constant: the command that holds a known weight";
/// What tells the field from the fluid.
pub(crate) const VOLTAGE: &str = "measure the voltage over the gap of the fluid";
/// What tells the drive's lateness from the sensor's.
pub(crate) const CURRENT_STEP: &str = "measure the drive's answer to a step of current by itself";
/// What tells torques over position.
pub(crate) const HOLDING: &str = "measure the torque that holds some positions at rest";
/// What tells what hangs on the rotor.
pub(crate) const LOAD_SIDE: &str = "measure the load's position as well, or hold the load and turn the motor";

/// Amplitude, order and phase of values order, sine, cosine.
pub(crate) fn amplitude_order_phase(values: &[f64]) -> Vec<f64> {
    vec![values[1].hypot(values[2]), values[0], values[2].atan2(values[1])]
}

/// The whole vocabulary, in the order of the specification; `controller` is not fitted but replayed.
pub static VOCABULARY: [&Effect; 41] = [
    &channel_skew::EFFECT,
    &torque_filter::EFFECT,
    &field_dead_time::EFFECT,
    &field_lag::EFFECT,
    &field_lag_asymmetry::EFFECT,
    &field_slew_limit::EFFECT,
    &field_gain::EFFECT,
    &er_strength::EFFECT,
    &er_drift::EFFECT,
    &er_preyield::EFFECT,
    &viscosity_dead_time::EFFECT,
    &viscosity_lag::EFFECT,
    &coulomb_friction::EFFECT,
    &viscous_friction::EFFECT,
    &stribeck_friction::EFFECT,
    &friction_asymmetry::EFFECT,
    &presliding::EFFECT,
    &torque_gain::EFFECT,
    &torque_offset::EFFECT,
    &torque_saturation::EFFECT,
    &torque_deadband::EFFECT,
    &torque_delay::EFFECT,
    &torque_lag::EFFECT,
    &cogging::EFFECT,
    &inertia::EFFECT,
    &gravity_load::EFFECT,
    &spring_load::EFFECT,
    &compliance::EFFECT,
    &backlash::EFFECT,
    &disturbance_pulse::EFFECT,
    &vibration::EFFECT,
    &quadratic_drag::EFFECT,
    &resolver_eccentricity::EFFECT,
    &sensor_latency::EFFECT,
    &sensor_glitch::EFFECT,
    &load_dependent_friction::EFFECT,
    &temperature_viscosity::EFFECT,
    &torque_ripple::EFFECT,
    &temperature_yield::EFFECT,
    &field_kinetics::EFFECT,
    &er_flow::EFFECT,
];

/// The effect of that identifier.
pub fn find(id: &str) -> Option<&'static Effect> {
    VOCABULARY.iter().find(|effect| effect.id == id).copied()
}
