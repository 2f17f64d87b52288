//! The loop of section V of the paper: what it is made of, checked, and its characteristic function.

use nalgebra::Complex;

/// How the variable part of the coefficient of viscosity follows its command.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(tag = "model", rename_all = "kebab-case")]
pub enum Fluid {
    /// At once: Q(s) = Q0 + Q1.
    None,
    /// Dead time, equation (10): Q(s) = Q0 + Q1 e^(-L_Q s).
    DeadTime {
        /// L_Q, s, 0 or more.
        l_q_s: f64,
    },
    /// First-order lag, equation (12): Q(s) = Q0 + Q1 / (T_Q s + 1).
    Lag {
        /// T_Q, s, 0 or more.
        t_q_s: f64,
    },
}

impl Fluid {
    /// The dead time or the time constant, s; 0 where there is neither.
    #[must_use]
    pub fn delay_s(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::DeadTime { l_q_s } => l_q_s,
            Self::Lag { t_q_s } => t_q_s,
        }
    }

    /// The same model with another dead time or time constant, s.
    #[must_use]
    pub fn with_delay_s(self, delay_s: f64) -> Self {
        match self {
            Self::None => Self::None,
            Self::DeadTime { .. } => Self::DeadTime { l_q_s: delay_s },
            Self::Lag { .. } => Self::Lag { t_q_s: delay_s },
        }
    }

    /// Transfer function of the delay itself at `s` (rad/s), 1 at s = 0.
    #[must_use]
    pub fn transfer(self, s: Complex<f64>) -> Complex<f64> {
        match self {
            Self::None => Complex::from(1.0),
            Self::DeadTime { l_q_s } => (-s * l_q_s).exp(),
            Self::Lag { t_q_s } => (s * t_q_s + 1.0).inv(),
        }
    }
}

/// Gains scaled as in Fig. 9: K_P = K_p* J / L^2, K_D = K_d* J / L. Both are pure numbers.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct NormalisedGains {
    /// K_p*.
    pub kp: f64,
    /// K_d*.
    pub kd: f64,
}

impl NormalisedGains {
    /// The point of the paper, section 4 of the specification.
    pub const PAPER: Self = Self { kp: 0.0800, kd: 0.464 };

    /// The gains in N m, for the inertia (kg m2) and the delay (s) they are scaled with.
    #[must_use]
    pub fn physical(self, inertia_kg_m2: f64, delay_s: f64) -> Gains {
        Gains {
            k_p_nm_rad: self.kp * inertia_kg_m2 / (delay_s * delay_s),
            k_d_nm_s_rad: self.kd * inertia_kg_m2 / delay_s,
        }
    }
}

/// Gains of the PD law u = K_P e - K_D w.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Gains {
    /// K_P, N m/rad (N/m on a linear axis).
    pub k_p_nm_rad: f64,
    /// K_D, N m s/rad (N s/m on a linear axis).
    pub k_d_nm_s_rad: f64,
}

impl Gains {
    /// The gains as numbers, for the inertia (kg m2) and the delay (s) to scale with.
    #[must_use]
    pub fn normalised(self, inertia_kg_m2: f64, delay_s: f64) -> NormalisedGains {
        NormalisedGains {
            kp: self.k_p_nm_rad * delay_s * delay_s / inertia_kg_m2,
            kd: self.k_d_nm_s_rad * delay_s / inertia_kg_m2,
        }
    }
}

/// Motor and damper, equation (8): e^(-Ls) / (J s^2 + Q(s) s).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Plant {
    /// J, kg m2 (kg on a linear axis), above 0.
    pub inertia_kg_m2: f64,
    /// L, from torque command to acting torque, s, above 0.
    pub torque_delay_s: f64,
    /// Q0, the viscosity without delay, N m s/rad, 0 or more.
    pub q0_nm_s_rad: f64,
    /// Q1, the viscosity behind the fluid's delay, N m s/rad, 0 or more.
    pub q1_nm_s_rad: f64,
    /// How Q1 is delayed.
    pub fluid: Fluid,
}

/// Why a loop cannot be analysed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LoopError {
    /// A quantity outside the range the analysis is defined for.
    #[error("{quantity} is {value}; it must be {allowed}")]
    Range {
        /// Which one.
        quantity: &'static str,
        /// As given, in the unit of the message.
        value: f64,
        /// In words.
        allowed: &'static str,
    },
    /// Time scales or gains so far apart that the work would not end.
    #[error("the loop is too stiff to analyse ({0}); check the units of the delays and of the inertia")]
    TooStiff(String),
    /// The rightmost roots could not be told apart or resolved.
    #[error(
        "the rightmost roots are not resolved by {points} Chebyshev points: a multiple root, or delays far longer than \
         the loop's own time scale"
    )]
    Unresolved {
        /// Most points tried.
        points: usize,
    },
    /// The eigenvalue iteration did not converge.
    #[error("the eigenvalue iteration did not converge for a matrix of {size} rows")]
    NoConvergence {
        /// Rows of the matrix.
        size: usize,
    },
}

/// The closed loop: plant and gains, checked.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Loop {
    plant: Plant,
    gains: Gains,
}

/// Phase that e^(-L jw), e^(-L_Q jw) or the lag may turn between zero and the highest frequency a root can have, rad.
/// The work of every method grows with it; a servo is at some hundred at most.
const MAX_PHASE_RAD: f64 = 2.0e4;

impl Loop {
    /// Joins plant and gains.
    ///
    /// # Errors
    /// [`LoopError::Range`] names the first quantity that is not finite or outside the range its field states, and
    /// [`LoopError::TooStiff`] is for delays thousands of times longer than the loop's own time scale.
    pub fn new(plant: Plant, gains: Gains) -> Result<Self, LoopError> {
        let positive: fn(f64) -> bool = |v| v.is_finite() && v > 0.0;
        let not_negative: fn(f64) -> bool = |v| v.is_finite() && v >= 0.0;
        let above = "a finite number above 0";
        let at_least = "a finite number, 0 or more";
        let checks = [
            ("the inertia J (kg m2)", plant.inertia_kg_m2, positive, above),
            ("the torque delay L (s)", plant.torque_delay_s, positive, above),
            ("Q0 (N m s/rad)", plant.q0_nm_s_rad, not_negative, at_least),
            ("Q1 (N m s/rad)", plant.q1_nm_s_rad, not_negative, at_least),
            ("the fluid's delay (s)", plant.fluid.delay_s(), not_negative, at_least),
            ("the gain K_P (N m/rad)", gains.k_p_nm_rad, f64::is_finite, "a finite number"),
            ("the gain K_D (N m s/rad)", gains.k_d_nm_s_rad, f64::is_finite, "a finite number"),
        ];
        for (quantity, value, holds, allowed) in checks {
            if !holds(value) {
                return Err(LoopError::Range { quantity, value, allowed });
            }
        }
        let closed = Self { plant, gains };
        let phase = closed.frequency_bound_rad_s() * (plant.torque_delay_s + plant.fluid.delay_s());
        if phase.is_finite() && phase <= MAX_PHASE_RAD {
            Ok(closed)
        } else {
            Err(LoopError::TooStiff(format!("a phase of {phase:.1e} rad over the band of the loop")))
        }
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The gains, in N m.
    #[must_use]
    pub fn gains(&self) -> Gains {
        self.gains
    }

    /// The gains scaled with the inertia and the torque delay of this loop's own plant.
    #[must_use]
    pub fn normalised_gains(&self) -> NormalisedGains {
        self.gains.normalised(self.plant.inertia_kg_m2, self.plant.torque_delay_s)
    }

    /// J s^2 + Q(s) s, the part without the control torque, N m/rad; `s` in rad/s.
    #[must_use]
    pub fn open_denominator(&self, s: Complex<f64>) -> Complex<f64> {
        let Plant { inertia_kg_m2, q0_nm_s_rad, q1_nm_s_rad, fluid, .. } = self.plant;
        (s * inertia_kg_m2 + q0_nm_s_rad + fluid.transfer(s) * q1_nm_s_rad) * s
    }

    /// (K_P + K_D s) e^(-Ls), the control torque on an angle of 1 rad, N m/rad; `s` in rad/s.
    #[must_use]
    pub fn control(&self, s: Complex<f64>) -> Complex<f64> {
        (s * self.gains.k_d_nm_s_rad + self.gains.k_p_nm_rad) * (-s * self.plant.torque_delay_s).exp()
    }

    /// The characteristic function, denominator of (9), N m/rad; its zeros are the poles of the closed loop.
    #[must_use]
    pub fn characteristic(&self, s: Complex<f64>) -> Complex<f64> {
        self.open_denominator(s) + self.control(s)
    }

    /// dD/ds of the characteristic function, N m s/rad; `s` in rad/s.
    #[must_use]
    pub fn characteristic_slope(&self, s: Complex<f64>) -> Complex<f64> {
        let Plant { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid } = self.plant;
        let delay = fluid.transfer(s);
        let delay_slope = match fluid {
            Fluid::None => Complex::from(0.0),
            Fluid::DeadTime { l_q_s } => -delay * l_q_s,
            Fluid::Lag { t_q_s } => -delay * delay * t_q_s,
        };
        let control = (-s * torque_delay_s).exp() * self.gains.k_d_nm_s_rad - self.control(s) * torque_delay_s;
        s * (2.0 * inertia_kg_m2) + q0_nm_s_rad + (delay + s * delay_slope) * q1_nm_s_rad + control
    }

    /// No root with a real part of 0 or more has a modulus above this, rad/s.
    ///
    /// There |e^(-Ls)|, |e^(-L_Q s)| and |1 / (T_Q s + 1)| are at most 1, so a root needs
    /// J |s|^2 <= (Q0 + Q1 + |K_D|) |s| + |K_P|: the loop is of retarded type.
    #[must_use]
    pub fn frequency_bound_rad_s(&self) -> f64 {
        let viscosity = self.plant.q0_nm_s_rad + self.plant.q1_nm_s_rad + self.gains.k_d_nm_s_rad.abs();
        let inertia = self.plant.inertia_kg_m2;
        (viscosity + (viscosity * viscosity + 4.0 * inertia * self.gains.k_p_nm_rad.abs()).sqrt()) / (2.0 * inertia)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;

    const PLANT: Plant = Plant {
        inertia_kg_m2: 0.075,
        torque_delay_s: 0.005,
        q0_nm_s_rad: 0.2,
        q1_nm_s_rad: 10.0,
        fluid: Fluid::DeadTime { l_q_s: 0.005 },
    };

    #[test]
    fn the_papers_gains_are_240_and_6_96_at_5_ms() {
        let gains = NormalisedGains::PAPER.physical(0.075, 0.005);
        assert!((gains.k_p_nm_rad - 240.0).abs() < 1e-9 && (gains.k_d_nm_s_rad - 6.96).abs() < 1e-9);
        let back = gains.normalised(0.075, 0.005);
        assert!((back.kp - 0.08).abs() < 1e-12 && (back.kd - 0.464).abs() < 1e-12);
    }

    #[test]
    fn bad_values_are_named() {
        let gains = NormalisedGains::PAPER.physical(0.075, 0.005);
        for (plant, name) in [
            (Plant { inertia_kg_m2: 0.0, ..PLANT }, "inertia"),
            (Plant { torque_delay_s: f64::NAN, ..PLANT }, "torque delay"),
            (Plant { q0_nm_s_rad: -1.0, ..PLANT }, "Q0"),
            (Plant { q1_nm_s_rad: f64::INFINITY, ..PLANT }, "Q1"),
            (Plant { fluid: Fluid::Lag { t_q_s: -0.1 }, ..PLANT }, "fluid"),
            (Plant { fluid: Fluid::DeadTime { l_q_s: 1e6 }, ..PLANT }, "stiff"),
        ] {
            let message = Loop::new(plant, gains).unwrap_err().to_string();
            assert!(message.contains(name), "{message}");
        }
    }
}
