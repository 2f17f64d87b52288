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

/// All figures.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take.
pub fn all() -> Result<Vec<NamedFigure>, Error> {
    let mut figures = law::figures()?;
    figures.extend(responses::figures()?);
    Ok(figures)
}
