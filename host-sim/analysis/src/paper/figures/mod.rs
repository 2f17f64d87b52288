//! The paper's figures, made from the model alone: its measured curves are not available.

mod law;
mod responses;

use crate::plot::Figure;
use recording::Error;

/// A figure and the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedFigure {
    /// Without folder.
    pub file: &'static str,
    /// What it shows.
    pub figure: Figure,
}

/// Figures that cannot be made, and why.
pub const LEFT_OUT: &str = "Figs. 1, 2, 7 and 8 are drawings; Fig. 11 compares with a measurement, which is not available; \
the other figures show the model's curves only";

/// The files of [`all`], in its order.
pub const FILES: [&str; 16] = [
    "fig03.svg",
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
];

/// All figures.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take.
pub fn all() -> Result<Vec<NamedFigure>, Error> {
    let mut figures = law::figures()?;
    figures.extend(responses::figures()?);
    Ok(figures)
}
