//! What is drawn: panels of series.

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
    /// An error bar from each point to the next: pairs of its lower and its upper end.
    Bars,
}

/// What a series is drawn in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ink {
    /// The colour of its place among the series of the panel.
    #[default]
    ByPlace,
    /// Recorded data, the same in every figure.
    Recorded,
    /// The nominal model, likewise.
    Nominal,
    /// The improved model, likewise.
    Improved,
}

/// How the line of a curve is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stroke {
    /// Unbroken.
    #[default]
    Solid,
    /// Long dashes.
    Dashed,
    /// Dots.
    Dotted,
    /// Dashes and dots in turn.
    DashDot,
}

/// One curve or cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// How it is drawn.
    pub mark: Mark,
    /// How its line is drawn; a cloud has none.
    pub stroke: Stroke,
    /// Its colour.
    pub ink: Ink,
    /// (x, y) in the units of the panel's axes; a point that is not finite breaks the curve.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// A series of `points`, (x, y).
    pub fn new(name: &str, mark: Mark, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = points.into_iter().collect();
        Self { name: name.to_owned(), mark, stroke: Stroke::Solid, ink: Ink::ByPlace, points }
    }

    /// Error bars: at each x from low to high, as (x, low, high).
    pub fn bars(name: &str, bars: impl IntoIterator<Item = (f64, f64, f64)>) -> Self {
        Self::new(name, Mark::Bars, bars.into_iter().flat_map(|(x, low, high)| [(x, low), (x, high)]))
    }

    /// The same in another stroke.
    #[must_use]
    pub fn with(self, stroke: Stroke) -> Self {
        Self { stroke, ..self }
    }

    /// The same in another colour.
    #[must_use]
    pub fn inked(self, ink: Ink) -> Self {
        Self { ink, ..self }
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

/// Whether a point can be placed.
pub(super) fn is_shown(point: &(f64, f64)) -> bool {
    point.0.abs() <= LARGEST && point.1.abs() <= LARGEST
}
