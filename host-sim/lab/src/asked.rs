//! What the diagnosis reads of a recording, with what the law asked for where no column has it.

use diagnosis::hypothesis::evaluate;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::first_noise;
use er_servo::Params;

use crate::delays::late_viscosities;
use crate::read::{Machine, Mode, Recording};

/// A recording with the coefficient of viscosity that the law asked for. At rest it is finite and the field is zero, so field and
/// speed do not tell it; what the fluid does when the rotor starts, a dead time later, hangs on it.
pub(crate) fn recorded(machine: &Machine, file: &Recording) -> Recorded {
    let mut recorded = Recorded::new(file);
    let (Some(modes), Some(speeds)) = (&file.mode, &file.velocity) else { return recorded };
    // Modes are logged by this law alone: a file that leaves its parameters out leaves them at their defaults.
    let config = machine.controller.unwrap_or_default();
    // A law with values that are not allowed asked for nothing that is known.
    let Ok(params) = Params::new(&config) else { return recorded };
    for ((command, mode), speed_rad_s) in recorded.commands.iter_mut().zip(modes).zip(speeds) {
        command.viscosity = match mode {
            Mode::Off => Some(0.0),
            Mode::Damper => Some(f64::from(params.viscosity_nm_s_rad(*speed_rad_s as f32))),
            Mode::Brake => None,
        };
    }
    recorded
}

/// Of the recordings as their columns have them and as [`recorded`] reads them, those of which a late viscosity is likelier: a fluid
/// may be late in what the law asks for or in what the field makes of it, and at rest these differ.
pub(crate) fn likelier(columns: Problem, asked: impl FnOnce() -> Problem) -> Problem {
    if columns.excitation.field_peak <= 0.0 {
        return columns;
    }
    let asked = asked();
    if columns.recordings == asked.recordings {
        return columns;
    }
    let noise = first_noise(&columns);
    let starts = late_viscosities();
    let best = |problem: &Problem| {
        let all = starts.iter().filter_map(|start| {
            let found = evaluate(problem, &start.physics(&problem.nominal), &noise, 0..problem.fitted)?;
            Some(found.fitted(problem))
        });
        all.fold(f64::NEG_INFINITY, f64::max)
    };
    if best(&asked) > best(&columns) { asked } else { columns }
}
