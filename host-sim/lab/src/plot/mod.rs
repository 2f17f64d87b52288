//! Figures as SVG: panels one above the other over one x axis, each axis named with its unit.
//!
//! The same figure gives the same bytes. Curves of any length are thinned to what the pixels can show, so that a file
//! stays under 500 kB. Numbers that are not finite leave a break in a curve.
//!
//! ```
//! use lab::plot::{Figure, Panel};
//!
//! let t_s = [0.0, 0.5, 1.0];
//! let svg = Figure::new("Step", "time", "s")
//!     .panel(Panel::new("position", "rad").line("measured", &t_s, &[0.0, 0.4, 0.5]).step("reference", &t_s, &[0.5; 3]))
//!     .to_svg();
//! assert!(svg.is_ok_and(|svg| svg.starts_with("<svg")));
//! ```

mod decimate;
mod draw;
mod ticks;

use std::path::Path;

use crate::{Error, output};

/// Numbers beyond this size are left out of a figure: the span of an axis must be finite.
const LARGEST: f64 = 1e300;

/// How the points of a series are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Style {
    /// Joined by straight lines.
    Line,
    /// Each value held until the next point, as commands are.
    Step,
    /// A dot each.
    Scatter,
}

/// One curve or cloud; points as (x, y).
#[derive(Debug, Clone, PartialEq)]
struct Series {
    label: String,
    style: Style,
    points: Vec<(f64, f64)>,
}

/// One coordinate system of a figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    y_label: String,
    series: Vec<Series>,
}

impl Panel {
    /// A panel whose y axis is named `quantity`, in `unit` (empty for a pure number).
    pub fn new(quantity: &str, unit: &str) -> Self {
        Self { y_label: axis_label(quantity, unit), series: Vec::new() }
    }

    /// Adds a curve through the points; an empty `label` keeps it out of the legend.
    #[must_use]
    pub fn line(self, label: &str, x: &[f64], y: &[f64]) -> Self {
        self.with(label, Style::Line, x, y)
    }

    /// Adds a curve that holds each value until the next point.
    #[must_use]
    pub fn step(self, label: &str, x: &[f64], y: &[f64]) -> Self {
        self.with(label, Style::Step, x, y)
    }

    /// Adds a dot for each point.
    #[must_use]
    pub fn scatter(self, label: &str, x: &[f64], y: &[f64]) -> Self {
        self.with(label, Style::Scatter, x, y)
    }

    /// Points beyond the shorter of `x` and `y` have no partner and are left out.
    fn with(mut self, label: &str, style: Style, x: &[f64], y: &[f64]) -> Self {
        let points = x.iter().copied().zip(y.iter().copied()).collect();
        self.series.push(Series { label: label.to_owned(), style, points });
        self
    }
}

/// A figure: a title, and panels over one x axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    title: String,
    x_label: String,
    panels: Vec<Panel>,
}

impl Figure {
    /// A figure whose x axis is named `quantity`, in `unit` (empty for a pure number).
    pub fn new(title: &str, quantity: &str, unit: &str) -> Self {
        Self { title: title.to_owned(), x_label: axis_label(quantity, unit), panels: Vec::new() }
    }

    /// Adds a panel below those there are.
    #[must_use]
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    ///
    /// What the drawing library says; none is known for finite points.
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

fn axis_label(quantity: &str, unit: &str) -> String {
    if unit.is_empty() { quantity.to_owned() } else { format!("{quantity} [{unit}]") }
}

/// Whether a point can be placed.
fn is_shown(point: &(f64, f64)) -> bool {
    point.0.abs() <= LARGEST && point.1.abs() <= LARGEST
}
