//! A reference as CSV.

use std::io::Write as _;
use std::path::Path;

use crate::read::AxisKind;
use crate::{Error, output};

/// Writes a reference as `simulate --reference` reads it: `t_s` and `reference_rad` (`reference_m`), every number to the bit.
///
/// # Errors
/// [`Error::Output`]; what stood in `file` before is untouched then.
pub fn write_reference(file: &Path, axis: AxisKind, reference: &[(f64, f64)]) -> Result<(), Error> {
    let unit = if axis == AxisKind::Linear { "m" } else { "rad" };
    output::write(file, |to| {
        writeln!(to, "t_s,reference_{unit}")?;
        reference.iter().try_for_each(|(t_s, position)| writeln!(to, "{t_s},{position}"))
    })
}
