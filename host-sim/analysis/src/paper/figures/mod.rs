//! The paper's figures, made from the model alone: its measured curves are not available. A recording of one's own can be
//! drawn into them.

mod joint;
mod law;
mod linearised;
mod responses;

use super::claims::Joint;
use crate::plot::Figure;
use recording::{Error, Recording};

/// A figure and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedFigure {
    /// Without folder.
    pub file: &'static str,
    /// What it shows.
    pub figure: Figure,
}

/// Figures that cannot be made, and why.
pub const LEFT_OUT: &str = "Figs. 1, 2, 7 and 8 are drawings; Fig. 3 is a measurement of the fluid and Fig. 11 compares with \
one, and neither is available; the other figures show the model's curves only";

/// The figures' files, in the order they are made; the last only where the joint search found a machine.
pub const FILES: [&str; 16] = [
    "fig04.svg",
    "fig05.svg",
    "fig06.svg",
    "fig09.svg",
    "fig10.svg",
    "fig12.svg",
    "fig13.svg",
    "fig14.svg",
    "fig15.svg",
    "fig16.svg",
    "fig17.svg",
    "fig16_slow_plant.svg",
    "fig18.svg",
    "fig19.svg",
    "speed_from_counts.svg",
    "claims_together.svg",
];

/// All figures; `measured` is drawn dashed into those of responses.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take.
pub(super) fn all(joint: Option<&Joint>, measured: Option<&Recording>) -> Result<Vec<NamedFigure>, Error> {
    let mut figures = law::figures()?;
    figures.push(linearised::figure()?);
    figures.extend(responses::figures(measured)?);
    figures.extend(joint.map(joint::figure));
    Ok(figures)
}
