//! Loops the tests of this module share.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::case::{Fluid, Loop, NormalisedGains, Plant};

/// The machine of the specification with a torque delay, Q0 and Q1, and a dead time of 5 ms.
pub fn plant(torque_delay_s: f64, q0_nm_s_rad: f64, q1_nm_s_rad: f64) -> Plant {
    let fluid = Fluid::DeadTime { l_q_s: 0.005 };
    Plant { inertia_kg_m2: 0.075, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid }
}

/// That machine with another fluid and the gains of the paper, scaled with its torque delay.
pub fn closed(torque_delay_s: f64, q0_nm_s_rad: f64, q1_nm_s_rad: f64, fluid: Fluid) -> Loop {
    let plant = Plant { fluid, ..plant(torque_delay_s, q0_nm_s_rad, q1_nm_s_rad) };
    Loop::new(plant, NormalisedGains::PAPER.physical(plant.inertia_kg_m2, torque_delay_s)).unwrap()
}
