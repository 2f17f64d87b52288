//! Gains designed on a model that contains the fluid's delay: what the paper asks for in its last sentence.
//!
//! Two models judge each pair of gains. The linear loop of section V must keep margins over every delay within its
//! uncertainty and every viscosity of equation (5) up to a largest one ([`guarantee`]); it is hard on the damper, for it
//! delays the product Q w and lets a late damper push. The nonlinear loop, the flashed law on the plant, must settle
//! small and large steps without overshoot, and its settling time is minimised ([`trial`]).
//!
//! [`search`] is a grid over both gains and a compass search from its best places. The cost is flat between the steps
//! of a quantised, sampled loop and ends at constraints; a simplex or gradient method stalls there, two variables need
//! no better method, and the grid is the trade-off curve.

pub mod beside;
pub mod cycles;
pub mod guarantee;
mod report;
pub mod search;
pub mod series;
pub mod trial;

pub use guarantee::{Demands, Guarantee, Range};
pub use report::{figure, machine, summary};
pub use search::{Candidate, Tuning, tune};
pub use trial::{Steps, Trial};

use er_servo::Config;
use plant::{FluidResponse, Model};

use crate::stability::Gains;

/// Largest viscosity of equation (5), at rest, N m s/rad.
pub const PEAK_NM_S_RAD: f64 = 55.147;

/// What is tuned, and to what.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// The machine.
    pub model: Model,
    /// Parameters of the law; its gains are replaced.
    pub config: Config,
    /// Margins to keep.
    pub demands: Demands,
    /// Each delay may be off by this share.
    pub uncertainty: f64,
    /// Largest viscosity for which the margins are kept, N m s/rad; none for the peak of (5), or the next below it up to
    /// which some gains keep them.
    pub q1_nm_s_rad: Option<f64>,
    /// What the nonlinear loop must do.
    pub steps: Steps,
}

impl Task {
    /// The loops the margins are asked of, up to a largest viscosity, N m s/rad.
    ///
    /// The law adds to L half a period for the hold and, where it differentiates counts, half a period and its low-pass.
    /// Both are counted as delay of the whole control torque, which is more than they are.
    #[must_use]
    pub fn range(&self, q1_nm_s_rad: f64) -> Range {
        let config = trial::config_for(&self.config, Gains { k_p_nm_rad: 1.0, k_d_nm_s_rad: 0.0 }, &self.model, 0.0);
        let (period_s, filter_s) = (f64::from(config.period_s), f64::from(config.speed_filter_s));
        let estimate_s = if config.speed_from_converter { 0.0 } else { 0.5 * period_s + filter_s };
        let damped = self.config.er_enabled && self.model.er.is_some();
        Range {
            inertia_kg_m2: self.model.inertia,
            torque_delay_s: self.model.torque_delay_s,
            law_delay_s: 0.5 * period_s + estimate_s,
            fluid_s: if damped { self.fluid_s() } else { None },
            uncertainty: self.uncertainty,
            q0_nm_s_rad: self.model.viscous,
            q1_nm_s_rad,
        }
    }

    /// Dead time and lag of the fluid, s, of whatever they delay.
    fn fluid_s(&self) -> Option<(f64, f64)> {
        Some(match self.model.er.as_ref()?.response {
            FluidResponse::ViscosityDeadTime { dead_time_s, .. } => (dead_time_s, 0.0),
            FluidResponse::ViscosityLag { lag_s, .. } => (0.0, lag_s),
            FluidResponse::Field(field) => (field.dead_time_s, field.rise_s.max(field.fall_s)),
        })
    }
}
