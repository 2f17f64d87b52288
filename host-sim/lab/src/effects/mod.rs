//! The vocabulary: one file for each effect, with its equation, parameters, start grid, and the sentence that names it.
//!
//! An effect changes numbers of [`Physics`]; what those numbers do is in one place for the weak form (`screen`) and in
//! one for the time domain (`plant`). Adding an effect is adding a file and a line here.

mod backlash;
mod cogging;
mod compliance;
mod coulomb_friction;
mod disturbance_pulse;
mod entries;
mod er_drift;
mod er_preyield;
mod er_strength;
mod field_dead_time;
mod field_gain;
mod field_lag;
mod field_lag_asymmetry;
mod field_slew_limit;
mod friction_asymmetry;
mod gravity_load;
mod inertia;
mod physics;
mod presliding;
mod quadratic_drag;
mod resolver_eccentricity;
mod sensor_glitch;
mod sensor_latency;
mod spring_load;
mod stribeck_friction;
mod torque_deadband;
mod torque_delay;
mod torque_gain;
mod torque_lag;
mod torque_offset;
mod torque_saturation;
mod vibration;
mod viscosity_dead_time;
mod viscosity_lag;
mod viscous_friction;

pub use physics::{Damper, Harmonic, Load, Physics, Pulse, Vibration, Viscosity};

/// One number of an effect that the fit moves.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Smallest value that physics allows.
    pub low: f64,
    /// Largest value that physics allows.
    pub high: f64,
    /// A change of this size is typical; steps of the fit and of its derivatives are taken relative to it.
    pub scale: f64,
    /// False for numbers the start grid decides, such as an order per revolution.
    pub free: bool,
    /// What bounds and scale are multiples of.
    pub size: Size,
}

/// What the numbers of a parameter are measured by on a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// The unit itself.
    Unit,
    /// Root mean square of the commanded torque.
    Torque,
    /// Largest commanded torque.
    TorquePeak,
    /// Torque over the largest speed.
    Damping,
    /// Torque over the square of the largest speed.
    Drag,
    /// Torque over the travel.
    Stiffness,
    /// The largest speed.
    Speed,
    /// The nominal inertia.
    Inertia,
    /// The travel.
    Travel,
}

impl Size {
    /// In SI units of the axis.
    pub fn of(self, physics: &Physics, excitation: &Excitation) -> f64 {
        let (speed, travel) = (excitation.speed_peak.max(1e-9), excitation.travel.max(1e-9));
        match self {
            Self::Unit => 1.0,
            Self::Torque => excitation.torque_rms,
            Self::TorquePeak => excitation.torque_peak,
            Self::Damping => excitation.torque_rms / speed,
            Self::Drag => excitation.torque_rms / (speed * speed),
            Self::Stiffness => excitation.torque_rms / travel,
            Self::Speed => speed,
            Self::Inertia => physics.inertia,
            Self::Travel => travel,
        }
    }
}

/// Bounds and scale of a parameter on a machine, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Typical change.
    pub scale: f64,
}

/// A free parameter between two bounds.
pub(crate) const fn free(low: f64, high: f64, scale: f64) -> Parameter {
    Parameter { low, high, scale, free: true, size: Size::Unit }
}

/// A free parameter whose bounds and scale are multiples of a size of the machine.
pub(crate) const fn sized(size: Size, low: f64, high: f64, scale: f64) -> Parameter {
    Parameter { low, high, scale, free: true, size }
}

/// A parameter the start grid decides.
pub(crate) const fn fixed() -> Parameter {
    Parameter { low: f64::NEG_INFINITY, high: f64::INFINITY, scale: 1.0, free: false, size: Size::Unit }
}

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
    /// Longest recording, s.
    pub duration_s: f64,
    /// Median sample period, s.
    pub period_s: f64,
    /// Number of recordings fitted.
    pub recordings: usize,
    /// Rotary or linear.
    pub linear: bool,
    /// Orders over position that stand out of the residual, best first.
    pub orders: Vec<f64>,
    /// Pushes that stand out of the residual.
    pub pulses: Vec<Pulse>,
    /// Tones that stand out of the residual, best first.
    pub tones: Vec<Vibration>,
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
    /// From fitted to reported values.
    pub report: fn(&[f64]) -> Vec<f64>,
}

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

/// No size of a machine is larger, in any unit: bounds that are multiples of it stay finite.
const LARGEST_SIZE: f64 = 1e100;

impl Effect {
    /// Bounds and scale of the value at `index`.
    pub fn parameter(&self, index: usize) -> Parameter {
        self.parameters[index.min(self.parameters.len() - 1)]
    }

    /// Bounds and scale of each value on a machine.
    #[allow(clippy::manual_clamp, reason = "a size that is no number becomes the smallest, where clamp would keep it")]
    #[allow(clippy::manual_clamp, reason = "a size that is no number becomes the smallest, where clamp would keep it")]
    pub fn ranges(&self, count: usize, physics: &Physics, excitation: &Excitation) -> Vec<Range> {
        let range = |index| {
            let parameter = self.parameter(index);
            // Squares of huge commands overflow; bounds must not.
            let size = parameter.size.of(physics, excitation).max(f64::MIN_POSITIVE).min(LARGEST_SIZE);
            Range { low: parameter.low * size, high: parameter.high * size, scale: parameter.scale * size }
        };
        (0..count).map(range).collect()
    }

    /// Whether it happens once: nothing elsewhere can predict it, and no scatter over blocks tells how sure it is.
    pub fn is_event(&self) -> bool {
        self.id == "disturbance_pulse"
    }

    /// Whether it puts a load behind a gap.
    pub fn is_gap(&self) -> bool {
        self.id == "backlash"
    }

    /// The recording that the value at `index` belongs to alone; none for what holds for all of them.
    pub fn recording_of(&self, index: usize) -> Option<usize> {
        (self.id == "vibration" && index > 0).then(|| (index - 1) / 2)
    }

    /// Number of fitted values that count as freedom, for values of that length.
    pub fn freedom(&self, values: &[f64]) -> usize {
        (0..values.len()).filter(|&index| self.parameter(index).free).count()
    }

    /// Number of those without which there is no such effect: levels of friction that differ are an asymmetry, whatever the
    /// slopes do.
    pub fn essential(&self, values: &[f64]) -> usize {
        if self.id == "friction_asymmetry" { 1 } else { self.freedom(values) }
    }
}

/// Reported values are the fitted ones.
pub(crate) fn as_fitted(values: &[f64]) -> Vec<f64> {
    values.to_vec()
}

/// Any machine.
pub(crate) fn always(_: &Physics, _: &Excitation) -> bool {
    true
}

/// A machine whose damper is driven in these recordings.
pub(crate) fn with_field(physics: &Physics, excitation: &Excitation) -> bool {
    physics.damper.is_some() && excitation.field_peak > 0.0
}

/// Amplitude, order and phase of values order, sine, cosine.
pub(crate) fn amplitude_order_phase(values: &[f64]) -> Vec<f64> {
    vec![values[1].hypot(values[2]), values[0], values[2].atan2(values[1])]
}

/// The whole vocabulary, in the order of the specification; `controller` is not fitted but replayed.
pub static VOCABULARY: [&Effect; 33] = [
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
];

/// The effect of that identifier.
pub fn find(id: &str) -> Option<&'static Effect> {
    VOCABULARY.iter().find(|effect| effect.id == id).copied()
}

/// That there is no effect `id`, with the nearest there is.
pub fn unknown(id: &str) -> crate::Error {
    let near = crate::read::nearest(id, VOCABULARY.iter().map(|effect| effect.id));
    let near = near.map_or_else(String::new, |near| format!("; the nearest is `{near}`"));
    crate::Error::Usage(format!("there is no effect `{id}`{near}; `servo-lab help effects` lists them"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::vocabulary::EFFECTS;
    use crate::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal};

    const PULSE: Pulse = Pulse { recording: 0, start_s: 1.0, duration_s: 0.1, amplitude: 1.0 };

    fn machine() -> Machine {
        let er = Some(ErNominal { a: 0.07, b: 0.47, dead_time_s: 0.002, lag_s: 0.003 });
        Machine {
            file: "machine.toml".into(),
            name: "test".to_owned(),
            axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution: 0.0 },
            plant: PlantNominal {
                inertia: 0.075,
                coulomb: 0.763,
                viscous: 0.0,
                torque_gain: 1.0,
                torque_offset: 0.0,
                torque_limit: None,
                torque_delay_s: 0.005,
                er,
            },
            controller: None,
            columns: Default::default(),
            effects: Vec::new(),
        }
    }

    #[test]
    fn the_order_is_that_of_the_table_of_names_and_every_effect_reports_what_it_names() {
        // What only the likelihood knows follows behind.
        assert!(VOCABULARY.len() <= EFFECTS.len());
        let tones = vec![Vibration { frequency_hz: 5.0, phasors: vec![(0.0, 0.0)] }];
        let sizes = Excitation { orders: vec![7.0], pulses: vec![PULSE], tones, ..Excitation::default() };
        let physics = Physics::nominal(&machine());
        for (effect, kind) in VOCABULARY.iter().zip(EFFECTS) {
            assert_eq!(effect.id, kind.id);
            for start in (effect.starts)(&physics, &sizes) {
                assert_eq!((effect.report)(&start).len(), kind.parameters.len(), "{}", effect.id);
            }
        }
    }
}
