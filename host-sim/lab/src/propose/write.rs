//! A reference as CSV.

use std::fmt::Write as _;

use crate::output::mark;
use crate::read::AxisKind;

/// A reference as `simulate --reference` reads it: `t_s` and `reference_rad` (`reference_m`), every number to the bit, with the
/// mark of this tool in its header.
pub fn reference_csv(axis: AxisKind, reference: &[(f64, f64)]) -> String {
    let unit = if axis == AxisKind::Linear { "m" } else { "rad" };
    let mut text = mark::csv_header(&["t_s", &format!("reference_{unit}")]);
    for (t_s, position) in reference {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{t_s},{position}");
    }
    text
}
