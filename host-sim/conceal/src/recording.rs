//! The log of the drive as CSV.

use std::f64::consts::TAU;

use er_servo::COUNTS_PER_REV;

use crate::Error;
use crate::closed_loop::Row;

/// What the log keeps of the position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resolution {
    /// Every count, and what the law needs to be replayed.
    Counts,
    /// This many bits a revolution, and nothing finer.
    Bits(u32),
}

impl Resolution {
    /// Smallest step, rad.
    pub fn step_rad(self) -> f64 {
        match self {
            Self::Counts => TAU / f64::from(COUNTS_PER_REV),
            Self::Bits(bits) => TAU / f64::from(1_u32 << bits),
        }
    }
}

/// The recording's text: header and one row a control period.
///
/// # Errors
/// Text that could not be made.
pub fn csv(rows: &[Row], resolution: Resolution) -> Result<Vec<u8>, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let full = resolution == Resolution::Counts;
    let mut header = vec!["t_s", "reference_rad", "position_rad", "torque_cmd_nm", "field_cmd_kv_mm", "mode"];
    // The law's speed would tell the position between the steps of a coarse log.
    header.extend(full.then_some("velocity_rad_s"));
    header.push("seq");
    writer.write_record(&header)?;
    for row in rows {
        let step_rad = resolution.step_rad();
        let position_rad =
            if full { row.position.to_rad() } else { (row.position.to_rad() / step_rad).round() * step_rad };
        // Stamps of whole nanoseconds.
        let mut cells = vec![
            format!("{}", (row.t_s * 1e9).round() / 1e9),
            format!("{:?}", row.reference.to_rad()),
            format!("{position_rad:?}"),
            format!("{:?}", f64::from(row.torque_nm)),
            format!("{:?}", f64::from(row.field_kv_mm)),
            row.mode.name().to_owned(),
        ];
        cells.extend(full.then(|| format!("{:?}", f64::from(row.speed_rad_s))));
        cells.push(row.seq.to_string());
        writer.write_record(&cells)?;
    }
    writer.into_inner().map_err(|error| Error::Csv(error.into_error().into()))
}
