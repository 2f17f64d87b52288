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

mod dashes;
mod decimate;
mod draw;
mod figure;
mod ticks;

pub use figure::{Figure, Ink, Mark, Panel, Series, Stroke};

use std::path::Path;

use recording::{Error, output};

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
