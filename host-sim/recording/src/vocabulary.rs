//! The vocabulary of effects (`diagnosis.md`): identifiers, and for each parameter its name, unit and allowed range.
//!
//! This table is the one place that names them; machine files are checked against it, answers take their units from it.

use std::fmt;

use super::AxisKind;

/// The identifier an answer uses where the recorded commands are not what the control law computes. It is no part of a
/// model and has no parameters.
pub const CONTROLLER: &str = "controller";

/// Longest dead time, lag or latency a model may have, s: beyond it no servo of this kind is stable.
const LONGEST_DELAY_S: f64 = 1.0;

/// Which numbers a key or parameter may hold; never NaN or infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Allowed {
    /// Any finite number.
    Finite,
    /// 0 or more.
    AtLeastZero,
    /// More than 0.
    AboveZero,
    /// Both ends included.
    Between(f64, f64),
    /// More than 0, at most this.
    AboveZeroUpTo(f64),
}

impl Allowed {
    /// Whether `value` may stand.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::AtLeastZero => value >= 0.0,
                Self::AboveZero => value > 0.0,
                Self::Between(low, high) => low <= value && value <= high,
                Self::AboveZeroUpTo(high) => 0.0 < value && value <= high,
            }
    }
}

/// Largest size of a number of a machine file, in whatever unit it is: doubles hold whole numbers up to 9e15 ...
pub const LARGEST: f64 = 1e15;
/// ... and the smallest of one that must be above 0: an inertia, a gain, a stiffness.
pub const SMALLEST: f64 = 1e-15;

impl Allowed {
    /// Whether `value` may stand but for its size, which no machine has: sums and quotients of such numbers are none.
    pub fn is_wild(self, value: f64) -> bool {
        value.abs() > LARGEST || (self == Self::AboveZero && value < SMALLEST)
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => f.write_str("a finite number"),
            Self::AtLeastZero => f.write_str("a finite number of 0 or more"),
            Self::AboveZero => f.write_str("a finite number above 0"),
            Self::Between(low, high) if low == high => write!(f, "{low}"),
            Self::Between(low, high) => write!(f, "a number from {low} to {high}"),
            Self::AboveZeroUpTo(high) => write!(f, "a number above 0, at most {high}"),
        }
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    rotary: Named,
    linear: Named,
    /// Values physics allows.
    pub allowed: Allowed,
}

/// Identifier and unit on one kind of axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Named {
    id: &'static str,
    unit: &'static str,
}

impl Parameter {
    /// The identifier, which ends in the unit of the axis: `stiffness_nm_rad`, `stiffness_n_m`.
    pub fn id(&self, axis: AxisKind) -> &'static str {
        self.named(axis).id
    }

    /// The unit as an answer writes it; `1` for a pure number.
    pub fn unit(&self, axis: AxisKind) -> &'static str {
        self.named(axis).unit
    }

    fn named(&self, axis: AxisKind) -> Named {
        match axis {
            AxisKind::Rotary => self.rotary,
            AxisKind::Linear => self.linear,
        }
    }
}

/// How often an effect may stand in one model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occurs {
    /// Once for all recordings, or once for each recording an entry names.
    Once,
    /// Any number of times: one entry for each order or frequency.
    Repeatedly,
    /// Any number of times, each in the one recording the entry names.
    InNamedRecording,
}

/// One effect: what may be missing from a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectKind {
    /// Identifier, the same on both kinds of axis.
    pub id: &'static str,
    /// All of them are needed.
    pub parameters: &'static [Parameter],
    /// How often it may stand in a model.
    pub occurs: Occurs,
}

/// The effect called `id`.
pub fn effect(id: &str) -> Option<&'static EffectKind> {
    EFFECTS.iter().find(|effect| effect.id == id)
}

impl EffectKind {
    /// The parameter called `id` on this kind of axis.
    pub fn parameter(&self, axis: AxisKind, id: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.id(axis) == id)
    }
}

/// A parameter named alike on both kinds of axis.
const fn same(id: &'static str, unit: &'static str, allowed: Allowed) -> Parameter {
    by_axis([id, unit], [id, unit], allowed)
}

/// Identifier and unit on a rotary axis, then on a linear one.
const fn by_axis(rotary: [&'static str; 2], linear: [&'static str; 2], allowed: Allowed) -> Parameter {
    let [rotary_id, rotary_unit] = rotary;
    let [linear_id, linear_unit] = linear;
    Parameter {
        rotary: Named { id: rotary_id, unit: rotary_unit },
        linear: Named { id: linear_id, unit: linear_unit },
        allowed,
    }
}

const fn once(id: &'static str, parameters: &'static [Parameter]) -> EffectKind {
    EffectKind { id, parameters, occurs: Occurs::Once }
}

const DELAY: Allowed = Allowed::Between(0.0, LONGEST_DELAY_S);
const DEAD_TIME: Parameter = same("dead_time_s", "s", DELAY);
const LAG: Parameter = same("lag_s", "s", DELAY);
const GAIN: Parameter = same("gain", "1", Allowed::AboveZero);
const STIFFNESS: Parameter = by_axis(["stiffness_nm_rad", "N m/rad"], ["stiffness_n_m", "N/m"], Allowed::AboveZero);
const AMPLITUDE: Parameter = by_axis(["amplitude_nm", "N m"], ["amplitude_n", "N"], Allowed::AtLeastZero);
/// Periods in one revolution, or in one metre.
const ORDER: Parameter = by_axis(["order_per_rev", "1/rev"], ["order_per_m", "1/m"], Allowed::AboveZero);
const PHASE: Parameter = same("phase_rad", "rad", Allowed::Finite);
const RESONANCE: Parameter = same("resonance_hz", "Hz", Allowed::AboveZero);
const DAMPING_RATIO: Parameter = same("damping_ratio", "1", Allowed::AtLeastZero);
/// Share of the stored heat that is given off in a second.
const COOLING: Parameter = same("cooling_per_s", "1/s", Allowed::AtLeastZero);
/// Powers of the field: beyond 2 nothing known of such fluids goes.
const EXPONENTS: Allowed = Allowed::Between(0.0, 2.0);
/// Load over motor.
const INERTIA_RATIO: Parameter = same("inertia_ratio", "1", Allowed::AboveZero);

/// Every effect, in the order of the specification's table.
pub const EFFECTS: &[EffectKind] = &[
    once("field_dead_time", &[DEAD_TIME]),
    once("field_lag", &[LAG]),
    once("field_lag_asymmetry", &[same("rise_s", "s", DELAY), same("fall_s", "s", DELAY)]),
    once("field_slew_limit", &[same("slew_kv_mm_s", "kV/(mm s)", Allowed::AboveZero)]),
    once("field_gain", &[GAIN]),
    once("er_strength", &[same("scale", "1", Allowed::AboveZero)]),
    once("er_drift", &[same("rate_per_s", "1/s", Allowed::Finite)]),
    once("er_preyield", &[STIFFNESS]),
    once("viscosity_dead_time", &[DEAD_TIME]),
    once("viscosity_lag", &[LAG]),
    once("coulomb_friction", &[by_axis(["coulomb_nm", "N m"], ["coulomb_n", "N"], Allowed::AtLeastZero)]),
    once(
        "viscous_friction",
        &[by_axis(["viscous_nm_s_rad", "N m s/rad"], ["viscous_n_s_m", "N s/m"], Allowed::AtLeastZero)],
    ),
    once(
        "stribeck_friction",
        &[
            by_axis(["excess_nm", "N m"], ["excess_n", "N"], Allowed::AtLeastZero),
            by_axis(["velocity_rad_s", "rad/s"], ["velocity_m_s", "m/s"], Allowed::AboveZero),
        ],
    ),
    once(
        "friction_asymmetry",
        &[
            by_axis(["difference_nm", "N m"], ["difference_n", "N"], Allowed::Finite),
            by_axis(
                ["viscous_difference_nm_s_rad", "N m s/rad"],
                ["viscous_difference_n_s_m", "N s/m"],
                Allowed::Finite,
            ),
        ],
    ),
    once("presliding", &[STIFFNESS]),
    once("torque_gain", &[GAIN]),
    once("torque_offset", &[by_axis(["offset_nm", "N m"], ["offset_n", "N"], Allowed::Finite)]),
    once("torque_saturation", &[by_axis(["limit_nm", "N m"], ["limit_n", "N"], Allowed::AboveZero)]),
    once("torque_deadband", &[by_axis(["deadband_nm", "N m"], ["deadband_n", "N"], Allowed::AtLeastZero)]),
    once("torque_delay", &[same("delay_s", "s", DELAY)]),
    once("torque_lag", &[LAG]),
    EffectKind { id: "cogging", parameters: &[AMPLITUDE, ORDER, PHASE], occurs: Occurs::Repeatedly },
    once("inertia", &[by_axis(["inertia_kg_m2", "kg m2"], ["inertia_kg", "kg"], Allowed::AboveZero)]),
    once("gravity_load", &[AMPLITUDE, PHASE]),
    once("spring_load", &[STIFFNESS]),
    once("compliance", &[RESONANCE, DAMPING_RATIO, INERTIA_RATIO]),
    once(
        "backlash",
        &[by_axis(["gap_rad", "rad"], ["gap_m", "m"], Allowed::AtLeastZero), RESONANCE, DAMPING_RATIO, INERTIA_RATIO],
    ),
    EffectKind {
        id: "disturbance_pulse",
        parameters: &[
            same("start_s", "s", Allowed::Finite),
            same("duration_s", "s", Allowed::AboveZero),
            by_axis(["amplitude_nm", "N m"], ["amplitude_n", "N"], Allowed::Finite),
        ],
        occurs: Occurs::InNamedRecording,
    },
    EffectKind {
        id: "vibration",
        parameters: &[same("frequency_hz", "Hz", Allowed::AboveZero), AMPLITUDE],
        occurs: Occurs::Repeatedly,
    },
    once(
        "quadratic_drag",
        &[by_axis(["coefficient_nm_s2_rad2", "N m s2/rad2"], ["coefficient_n_s2_m2", "N s2/m2"], Allowed::AtLeastZero)],
    ),
    EffectKind {
        id: "resolver_eccentricity",
        parameters: &[by_axis(["amplitude_rad", "rad"], ["amplitude_m", "m"], Allowed::AtLeastZero), ORDER, PHASE],
        occurs: Occurs::Repeatedly,
    },
    once("sensor_latency", &[same("delay_s", "s", Allowed::Between(-LONGEST_DELAY_S, LONGEST_DELAY_S))]),
    once(
        "sensor_glitch",
        &[
            same("fraction", "1", Allowed::Between(0.0, 1.0)),
            by_axis(["size_rad", "rad"], ["size_m", "m"], Allowed::Finite),
        ],
    ),
    once("channel_skew", &[same("skew_s", "s", Allowed::Between(-LONGEST_DELAY_S, LONGEST_DELAY_S))]),
    once("torque_filter", &[LAG]),
    once("load_dependent_friction", &[same("coefficient", "1", Allowed::Between(0.0, 0.9))]),
    once("temperature_viscosity", &[same("viscosity_per_j", "1/J", Allowed::AtLeastZero), COOLING]),
    EffectKind {
        id: "torque_ripple",
        parameters: &[same("gain_amplitude", "1", Allowed::Between(0.0, 0.9)), ORDER, PHASE],
        occurs: Occurs::Repeatedly,
    },
    once("temperature_yield", &[same("yield_per_j", "1/J", Allowed::AtLeastZero), COOLING]),
    once("field_kinetics", &[same("rise_exponent", "1", EXPONENTS), same("fall_exponent", "1", EXPONENTS)]),
    once(
        "er_flow",
        &[
            by_axis(
                ["consistency_nm_per_kv_mm", "N m (s/rad)^n/(kV/mm)"],
                ["consistency_n_per_kv_mm", "N (s/m)^n/(kV/mm)"],
                Allowed::AtLeastZero,
            ),
            same("flow_exponent", "1", Allowed::Between(0.1, 1.0)),
        ],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_unique_and_carry_the_unit_of_the_axis() {
        for (index, effect) in EFFECTS.iter().enumerate() {
            assert!(EFFECTS[..index].iter().all(|earlier| earlier.id != effect.id), "{} twice", effect.id);
            for parameter in effect.parameters {
                let linear = parameter.id(AxisKind::Linear);
                assert!(!linear.contains("nm") && !linear.contains("rev"), "{linear} on a linear axis");
                assert!(!linear.contains("rad") || linear == "phase_rad", "{linear} on a linear axis");
            }
        }
    }

    #[test]
    fn nothing_allows_a_number_that_is_not_finite() {
        for effect in EFFECTS {
            for parameter in effect.parameters {
                for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    assert!(!parameter.allowed.holds(value), "{} {}", effect.id, parameter.allowed);
                }
            }
        }
    }
}
