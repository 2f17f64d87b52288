//! What a real electrorheological fluid has beyond a E^2 + b E: options of the plant, off by default. `docs/fluid.md` has the
//! equations with their sources.

use crate::model::{check, finite, not_negative, positive};
use crate::{Er, Error, FluidResponse};

/// Flow beside the yield: drag (k + k_E E) |w|^n on top of a E^2 + b E (Herschel and Bulkley, Kolloid-Zeitschrift 39 (1926) 291;
/// for dampers Lee and Wereley, J. Intell. Mater. Syst. Struct. 10 (1999) 761).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowCurve {
    /// k: consistency without a field, N m (s/rad)^n, not negative.
    pub consistency: f64,
    /// k_E: what a field adds to it, N m (s/rad)^n per kV/mm, not negative.
    pub consistency_per_kv_mm: f64,
    /// n: [`LEAST_EXPONENT`] to 1; 1 is Bingham's fluid, less thins under shear.
    pub exponent: f64,
}

/// Least exponent of a flow curve: published fluids have 0.2 and more, and below a tenth a flow is no other than a yield.
pub const LEAST_EXPONENT: f64 = 0.1;
/// Below about this speed, rad/s, the flow curve is straight: w (w^2 + this^2)^((n-1)/2) in place of w^n, for no fluid is
/// infinitely viscous at rest (Papanastasiou, J. Rheol. 31 (1987) 385, for the reason; the form is Carreau's). The speed is the
/// one below which the law's viscosity is not reckoned with either (control specification section 4).
const STRAIGHT_RAD_S: f64 = 0.002;

impl FlowCurve {
    /// Consistency at a field, kV/mm.
    #[inline]
    pub fn at(&self, field_kv_mm: f64) -> f64 {
        self.consistency + self.consistency_per_kv_mm * field_kv_mm
    }

    /// Drag over the speed at a speed, rad/s, for that consistency, N m s/rad.
    #[inline]
    pub fn coefficient(&self, consistency: f64, w: f64) -> f64 {
        if self.exponent == 1.0 {
            return consistency;
        }
        consistency * (w * w + STRAIGHT_RAD_S * STRAIGHT_RAD_S).powf(0.5 * (self.exponent - 1.0))
    }

    /// Drag at a speed, rad/s, for that consistency, signed like the speed, N m.
    #[inline]
    pub(crate) fn torque(&self, consistency: f64, w: f64) -> f64 {
        self.coefficient(consistency, w) * w
    }

    /// Steepest slope of the drag over the speed, at rest, N m s/rad.
    pub(crate) fn steepest(&self, consistency: f64) -> f64 {
        consistency * STRAIGHT_RAD_S.powf(self.exponent - 1.0)
    }

    /// Longest step over which the flow is smooth, s: a part of its time constant, and of the speed or of the bend at rest.
    pub(crate) fn longest_step(&self, consistency: f64, w: f64, acceleration: f64, inertia: f64) -> f64 {
        let speed = w.abs().max(STRAIGHT_RAD_S);
        (0.25 * inertia / (consistency * speed.powf(self.exponent - 1.0))).min(0.25 * speed / acceleration)
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        not_negative("er.flow.consistency", self.consistency)?;
        not_negative("er.flow.consistency_per_kv_mm", self.consistency_per_kv_mm)?;
        check("er.flow.exponent", self.exponent, (LEAST_EXPONENT..=1.0).contains(&self.exponent), "from 0.1 to 1")
    }
}

/// Time constants over the field: rise_s and fall_s are those at [`REFERENCE_KV_MM`], elsewhere they are divided by a power of the
/// field. Forces between polarised particles grow with E^2 against the viscosity of the oil, so that chains form in a time of
/// 1/E^2 (Halsey, Science 258 (1992) 761; Parthasarathy and Klingenberg, Mater. Sci. Eng. R 17 (1996) 57); they fall apart in
/// the flow, in a time that hangs little on the field.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Kinetics {
    /// Power of the field that a rise goes to, 0 to 2; 0 for a rise that does not depend on it.
    pub rise_exponent: f64,
    /// Power of the field that a fall began at, 0 to 2.
    pub fall_exponent: f64,
}

/// Field that the time constants of [`Kinetics`] belong to, kV/mm.
pub const REFERENCE_KV_MM: f64 = 1.0;
/// A weaker field counts as this in [`Kinetics`], kV/mm: without one nothing would ever happen.
pub const WEAKEST_KV_MM: f64 = 0.1;

impl Kinetics {
    /// Time constant of a rise to that field, or, with the exponent of the fall, of a fall from it, s.
    #[inline]
    pub(crate) fn time_constant_s(at_reference_s: f64, exponent: f64, field_kv_mm: f64) -> f64 {
        if exponent == 0.0 {
            return at_reference_s;
        }
        at_reference_s * (REFERENCE_KV_MM / field_kv_mm.max(WEAKEST_KV_MM)).powf(exponent)
    }

    pub(crate) fn validate(&self) -> Result<(), Error> {
        let named = [("er.rise_exponent", self.rise_exponent), ("er.fall_exponent", self.fall_exponent)];
        named.into_iter().try_for_each(|(key, value)| check(key, value, (0.0..=2.0).contains(&value), "from 0 to 2"))
    }
}

/// How the fluid changes with its temperature: yield and consistency fall as exp(-beta (T - T_ref)), each with its own beta
/// (Reynolds, Phil. Trans. 177 (1886) 157, for oil; Conrad, Sprecher, Choi and Chen, J. Rheol. 35 (1991) 1393, for the strength
/// of electrorheological fluids, which rises with the temperature in some). The heat of the drag itself is
/// [`crate::effects::Warming`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Temperature {
    /// Temperature less the one that the nominal values belong to, K.
    pub above_reference_k: f64,
    /// Relative fall of a E^2 + b E for a kelvin, 1/K; negative where it rises.
    pub yield_per_k: f64,
    /// Relative fall of the consistency for a kelvin, 1/K.
    pub viscosity_per_k: f64,
}

impl Temperature {
    fn share(&self, per_k: f64) -> f64 {
        (-per_k * self.above_reference_k).exp()
    }
}

impl Er {
    /// The same damper at another temperature.
    ///
    /// # Errors
    /// [`Error::Parameter`] for what is no number, or makes none.
    pub fn at_temperature(mut self, temperature: &Temperature) -> Result<Self, Error> {
        let Temperature { above_reference_k, yield_per_k, viscosity_per_k } = *temperature;
        finite("er.temperature.above_reference_k", above_reference_k)?;
        finite("er.temperature.yield_per_k", yield_per_k)?;
        finite("er.temperature.viscosity_per_k", viscosity_per_k)?;
        self.scale *= temperature.share(yield_per_k);
        if let FluidResponse::Field(field) = &mut self.response
            && let Some(flow) = &mut field.flow
        {
            let share = temperature.share(viscosity_per_k);
            flow.consistency *= share;
            flow.consistency_per_kv_mm *= share;
            flow.validate()?;
        }
        not_negative("er.scale", self.scale)?;
        Ok(self)
    }
}

/// The electrodes as a capacitor that an amplifier of limited current charges: the field changes by at most I / (C d) (Whittle,
/// Firoozian, Bullough and Peel, Int. J. Mod. Phys. B 6 (1992) 2683, for the capacitor; its leakage only takes from I).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Electrode {
    /// Capacitance, F, above 0.
    pub capacitance_f: f64,
    /// Largest current either way, A, above 0.
    pub current_a: f64,
    /// Distance of the electrodes, m, above 0.
    pub gap_m: f64,
}

impl Electrode {
    /// Largest rate of change of the field, kV/mm/s.
    ///
    /// # Errors
    /// [`Error::Parameter`] names the value that is not above 0.
    pub fn slew_kv_mm_s(&self) -> Result<f64, Error> {
        positive("er.electrode.capacitance_f", self.capacitance_f)?;
        positive("er.electrode.current_a", self.current_a)?;
        positive("er.electrode.gap_m", self.gap_m)?;
        // 1 kV/mm is 1e6 V/m.
        Ok(self.current_a / (self.capacitance_f * self.gap_m) * 1e-6)
    }
}
