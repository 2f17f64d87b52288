//! The delay models of section 7 of the specification, and the limit cycles of the loop under each.

use er_servo::Config;
use rayon::prelude::*;

use super::simulated::remaining_amplitude_rad;
use super::{Damper, DamperDelay, LimitCycle, NonlinearLoop, Search};
use crate::stability::case::{Gains, Loop};
use recording::Error;

/// The models by the names of the specification; none for the field off. A late viscosity gives at most the torque of the
/// highest field, and in the last three as much as (6) and (7) print.
pub const MODELS: [(&str, Option<DamperDelay>); 11] = [
    ("ER off", None),
    ("none", Some(DamperDelay::NONE)),
    ("Q dead 5 ms", Some(viscosity(5e-3, 0.0, true))),
    ("Q dead 50 ms", Some(viscosity(50e-3, 0.0, true))),
    ("Q lag 5 ms", Some(viscosity(0.0, 5e-3, true))),
    ("E dead 5 ms", Some(DamperDelay::Field { dead_time_s: 5e-3, lag_s: 0.0 })),
    ("E lag 5 ms", Some(DamperDelay::Field { dead_time_s: 0.0, lag_s: 5e-3 })),
    ("E dead 2 + lag 3 ms", Some(DamperDelay::Field { dead_time_s: 2e-3, lag_s: 3e-3 })),
    ("Q dead 5 ms, as printed", Some(viscosity(5e-3, 0.0, false))),
    ("Q dead 50 ms, as printed", Some(viscosity(50e-3, 0.0, false))),
    ("Q lag 5 ms, as printed", Some(viscosity(0.0, 5e-3, false))),
];

const fn viscosity(dead_time_s: f64, lag_s: f64, bounded: bool) -> DamperDelay {
    DamperDelay::Viscosity { dead_time_s, lag_s, bounded }
}

/// The limit cycles under one model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ModelCycles {
    /// Name in [`MODELS`].
    pub model: &'static str,
    /// By amplitude; empty where the harmonic balance has no solution within the search.
    pub cycles: Vec<LimitCycle>,
    /// What a run in time is left with, rad ([`remaining_amplitude_rad`]).
    pub simulated_amplitude_rad: f64,
}

/// Limit cycles of the plant and gains of `closed` under every model, with the dry friction `coulomb_nm` and the law of
/// `config`, whose gains are replaced, and what a run in time says. Q0 and Q1 of `closed` are the linear picture of the
/// same damper and are left out. The harmonic balance has half a control period more delay in each command, for the
/// hold.
///
/// # Errors
/// What the control library or the plant finds wrong at these gains.
pub fn cycles_by_model(
    closed: &Loop,
    config: &Config,
    coulomb_nm: f64,
    search: Search,
) -> Result<Vec<ModelCycles>, Error> {
    let gains = closed.gains();
    let Gains { k_p_nm_rad, k_d_nm_s_rad } = gains;
    // The library's parameters are in single precision.
    #[allow(clippy::cast_possible_truncation)]
    let config = Config { kp_nm_rad: k_p_nm_rad as f32, kd_nm_s_rad: k_d_nm_s_rad as f32, ..*config };
    let hold_s = 0.5 * f64::from(config.period_s);
    MODELS
        .into_par_iter()
        .map(|(model, delay)| {
            let simulated_amplitude_rad = remaining_amplitude_rad(closed, &config, coulomb_nm, delay)?;
            let damper = delay.map(|delay| Damper::new(&config, delay.later_by(hold_s))).transpose();
            let damper = damper.map_err(|error| Error::Usage(error.to_string()))?;
            let system = NonlinearLoop {
                inertia_kg_m2: closed.plant().inertia_kg_m2,
                torque_delay_s: closed.plant().torque_delay_s + hold_s,
                coulomb_nm,
                gains,
                torque_limit_nm: f64::from(config.torque_limit_nm),
                damper: damper.as_ref(),
            };
            Ok(ModelCycles { model, cycles: system.limit_cycles(search), simulated_amplitude_rad })
        })
        .collect()
}
