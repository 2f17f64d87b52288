//! The nominal model of a machine.

use std::path::PathBuf;

use crate::Mapping;

/// Whether positions are angles or lengths; decides every unit of the machine file and of its recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisKind {
    /// rad, N m, kg m2.
    Rotary,
    /// m, N, kg.
    Linear,
}

impl AxisKind {
    /// Both kinds.
    pub const ALL: [Self; 2] = [Self::Rotary, Self::Linear];

    /// The word in machine files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rotary => "rotary",
            Self::Linear => "linear",
        }
    }
}

/// Section `[axis]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Rotary or linear.
    pub kind: AxisKind,
    /// Nominal sample period, s; a recording's own `t_s` decides.
    pub sample_period_s: f64,
    /// Smallest step of the measured position, rad or m; 0 for continuous.
    pub resolution: f64,
}

/// Section `[plant.er]`: the damper, torque a E^2 + b E of the field that acts.
#[derive(Debug, Clone, PartialEq)]
pub struct ErNominal {
    /// N m per (kV/mm)^2, equation (2).
    pub a: f64,
    /// N m per kV/mm, equation (2).
    pub b: f64,
    /// Dead time of the field, s.
    pub dead_time_s: f64,
    /// First-order lag of the field, s.
    pub lag_s: f64,
    /// Section `[plant.er.fluid]`; none where it is left out.
    pub fluid: Option<ErFluid>,
}

/// Section `[plant.er.fluid]`: what a real fluid has beyond a E^2 + b E, for simulations. Defaults change nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct ErFluid {
    /// Consistency without a field, N m (s/rad)^n.
    pub consistency: f64,
    /// What a field adds to the consistency, N m (s/rad)^n per kV/mm.
    pub consistency_per_kv_mm: f64,
    /// n: exponent of the speed in the flow curve, 0.1 to 1.
    pub flow_exponent: f64,
    /// `lag_s` is that of a rise to 1 kV/mm; of others it is divided by this power of their field, 0 to 2.
    pub rise_exponent: f64,
    /// The same of a fall and the field it begins at, 0 to 2.
    pub fall_exponent: f64,
    /// Temperature of the fluid less the one its other values belong to, K.
    pub above_reference_k: f64,
    /// Relative fall of a E^2 + b E for a kelvin, 1/K; negative where it rises.
    pub yield_per_k: f64,
    /// Relative fall of the consistency for a kelvin, 1/K.
    pub viscosity_per_k: f64,
    /// Electrodes and their amplifier; none for an amplifier without a limit of its current.
    pub electrode: Option<ErElectrode>,
}

/// Electrodes as a capacitor behind an amplifier of limited current; all three keys stand together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErElectrode {
    /// Key `electrode_capacitance_f`: F.
    pub capacitance_f: f64,
    /// Key `amplifier_current_a`: largest current either way, A.
    pub current_a: f64,
    /// Key `gap_m`: distance of the electrodes, m.
    pub gap_m: f64,
}

/// Section `[plant]`; units follow the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantNominal {
    /// kg m2 or kg.
    pub inertia: f64,
    /// Dry friction level, N m or N.
    pub coulomb: f64,
    /// N m s/rad or N s/m.
    pub viscous: f64,
    /// Acting over commanded torque, 1.
    pub torque_gain: f64,
    /// Added to the acting torque, N m or N.
    pub torque_offset: f64,
    /// Largest acting torque either way, N m or N; none for no limit.
    pub torque_limit: Option<f64>,
    /// From the sampling of a row's position until its commands are at the drive's outputs, s; the delays of torque and field
    /// count from there.
    pub sample_to_output_s: f64,
    /// From command to acting torque, s.
    pub torque_delay_s: f64,
    /// None for a machine without an ER damper.
    pub er: Option<ErNominal>,
}

impl PlantNominal {
    /// From the sampling of a row's position until its torque acts, s.
    #[must_use]
    pub fn torque_delay_from_sample_s(&self) -> f64 {
        self.sample_to_output_s + self.torque_delay_s
    }
}

/// One `[[effects]]` entry of an improved model: an effect of the vocabulary and its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectEntry {
    /// Identifier of `diagnosis.md`, such as `field_lag`.
    pub id: String,
    /// The recording (file name) the entry holds in; none for all.
    pub recording: Option<String>,
    /// Parameter identifiers, each with its value in the unit its name ends in.
    pub parameters: Vec<(String, f64)>,
}

/// A machine file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// The file it was read from, for messages.
    pub file: PathBuf,
    /// Key `name`.
    pub name: String,
    /// Section `[axis]`.
    pub axis: Axis,
    /// Section `[plant]`.
    pub plant: PlantNominal,
    /// Section `[controller]`, values over the defaults of the control library; none where the section is left out.
    pub controller: Option<er_servo::Config>,
    /// Section `[columns]`: what the columns of this machine's logs are; empty for logs that have the format's own.
    pub columns: Mapping,
    /// Entries `[[effects]]`, in file order.
    pub effects: Vec<EffectEntry>,
}
