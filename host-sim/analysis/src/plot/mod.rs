//! Figures as SVG: panels one above the other, each axis named with its unit.
//!
//! Neighbouring panels of the same x label share their x axis. The same figure gives the same bytes. Curves of any
//! length are thinned to what the pixels can show, so that a file stays under 500 kB. Numbers that are not finite leave
//! a break in a curve.
//!
//! ```
//! use analysis::plot::{Figure, Mark, Panel, Series};
//!
//! let series = vec![
//!     Series::new("reference", Mark::Step, [(0.0, 0.5), (1.0, 0.5)]),
//!     Series::new("measured", Mark::Line, [(0.0, 0.0), (0.5, 0.4), (1.0, 0.5)]),
//! ];
//! let figure = Figure { title: "Step".to_owned(), panels: vec![Panel::new("time (s)", "position (rad)", series)] };
//! assert!(figure.to_svg().is_ok_and(|svg| svg.starts_with("<svg")));
//! ```

mod decimate;
mod draw;
mod ticks;

use std::path::Path;

use recording::{Error, output};

/// Numbers beyond this size are left out of a figure: the span of an axis must be finite.
const LARGEST: f64 = 1e300;

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Straight from point to point.
    Line,
    /// Each value held until the next point, as commands are.
    Step,
    /// A dot at each point.
    Points,
}

/// One curve or cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// (x, y) in the units of the panel's axes; a point that is not finite breaks the curve.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series of `points`, (x, y).
    pub fn new(name: &str, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.to_owned(), mark, points: points.into_iter().collect() }
    }

    /// A cross at a single point, larger than a dot; its half width and height are in the units of the axes.
    pub fn cross(name: &str, (x, y): (f64, f64), (half_width, half_height): (f64, f64)) -> Self {
        let gap = (f64::NAN, f64::NAN);
        let bars = [(x - half_width, y), (x + half_width, y), gap, (x, y - half_height), (x, y + half_height)];
        Self::new(name, Mark::Line, bars)
    }
}

/// One coordinate system of a figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Quantity and unit, such as `time (s)`.
    pub x_label: String,
    /// Quantity and unit.
    pub y_label: String,
    /// What is drawn, first at the bottom.
    pub series: Vec<Series>,
}

impl Panel {
    /// A panel; labels name quantity and unit.
    pub fn new(x_label: &str, y_label: &str, series: Vec<Series>) -> Self {
        Self { x_label: x_label.to_owned(), y_label: y_label.to_owned(), series }
    }
}

/// Panels under one title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Above the panels.
    pub title: String,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

impl Figure {
    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    ///
    /// What the drawing library says; none is known.
    pub fn to_svg(&self) -> Result<String, String> {
        draw::svg(self)
    }

    /// Writes the figure to an SVG file.
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; what stood in `file` before is untouched then.
    pub fn write(&self, file: &Path) -> Result<(), Error> {
        let svg = self.to_svg().map_err(|reason| Error::Output { file: file.to_path_buf(), reason })?;
        output::write_text(file, &svg)
    }
}

/// Whether a point can be placed.
fn is_shown(point: &(f64, f64)) -> bool {
    point.0.abs() <= LARGEST && point.1.abs() <= LARGEST
}
