//! A drawn machine as its log and its machine file.

use std::fmt::Write as _;

use er_servo::parameters;
use rand::rngs::StdRng;

use super::motion::Sample;
use super::setting::{Law, MeasuredTorque, Setting};
use crate::Error;
use crate::sensor::unit_normal;

/// What the log keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kept {
    /// Step of the position, rad or m.
    pub(crate) step: f64,
    /// What the flashed law needs to be replayed.
    pub(crate) controller: bool,
    /// Standard deviation of a measured torque, N m or N.
    pub(crate) torque_noise: f64,
}

/// The recording's text.
///
/// # Errors
/// Text that could not be made.
pub(crate) fn csv(rows: &[Sample], setting: &Setting, kept: Kept, random: &mut StdRng) -> Result<Vec<u8>, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let (unit, effort) = if setting.linear { ("m", "force_cmd_n") } else { ("rad", "torque_cmd_nm") };
    let fluid = setting.has_fluid();
    let mut header = vec!["t_s".to_owned(), format!("reference_{unit}"), format!("position_{unit}"), effort.to_owned()];
    header.extend(fluid.then(|| ["field_cmd_kv_mm".to_owned(), "mode".to_owned()]).into_iter().flatten());
    header.extend(kept.controller.then(|| format!("velocity_{unit}_s")));
    header.push("seq".to_owned());
    writer.write_record(&header)?;
    for (index, row) in rows.iter().enumerate() {
        let reading = if kept.controller { row.reading } else { (row.reading / kept.step).round() * kept.step };
        let torque = match setting.measured {
            None => row.command.torque_nm,
            Some(law) => late(rows, index, setting.period_s, law) + kept.torque_noise * unit_normal(random),
        };
        // Stamps of whole nanoseconds.
        let stamp = (row.t_s * 1e9).round() / 1e9;
        let mut cells =
            vec![format!("{stamp}"), format!("{:?}", row.reference), format!("{reading:?}"), format!("{torque:?}")];
        if fluid {
            cells.extend([format!("{:?}", row.command.field_kv_mm), row.mode.name().to_owned()]);
        }
        cells.extend(kept.controller.then(|| format!("{:?}", row.command.speed_rad_s)));
        cells.push(row.seq.to_string());
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(|error| Error::Csv(error.into_error().into()))
}

/// Torque of the drive some time before a row.
fn late(rows: &[Sample], index: usize, period_s: f64, law: MeasuredTorque) -> f64 {
    let at = (index as f64 - law.skew_s / period_s).clamp(0.0, (rows.len() - 1) as f64);
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    rows[low].drive + at.fract() * (rows[high].drive - rows[low].drive)
}

/// The machine file's text.
pub(crate) fn machine(setting: &Setting, kept: Kept) -> String {
    let physics = &setting.physics;
    let (friction, drive, fluid) = (&physics.friction, &physics.drive, &physics.fluid);
    let kind = if setting.linear { "linear" } else { "rotary" };
    let mut text = format!(
        "schema = 1\nname = \"machine\"\n\n[axis]\nkind = \"{kind}\"\nsample_period_s = {:?}\nresolution = {:?}\n\n[plant]\ninertia = {:?}\n\
         coulomb = {:?}\nviscous = {:?}\ntorque_delay_s = {:?}\n",
        setting.period_s,
        kept.step,
        physics.inertia_kg_m2,
        friction.coulomb_nm,
        friction.viscous_nm_s_rad,
        drive.delay_s
    );
    if drive.limit_nm.is_finite() {
        let _ = writeln!(text, "torque_limit = {:?}", drive.limit_nm);
    }
    if setting.has_fluid() {
        let _ = writeln!(
            text,
            "\n[plant.er]\na = {:?}\nb = {:?}\ndead_time_s = {:?}\nlag_s = {:?}",
            fluid.a, fluid.b, fluid.dead_time_s, fluid.rise_s
        );
    }
    if let (true, Law::Servo(config)) = (kept.controller, &setting.law) {
        text += "\n[controller]\n";
        for parameter in parameters::TABLE {
            let value = (parameter.get)(config);
            let _ = match parameter.unit {
                "flag" => writeln!(text, "{} = {}", parameter.name, value != 0.0),
                _ => writeln!(text, "{} = {value:?}", parameter.name),
            };
        }
    }
    text
}
