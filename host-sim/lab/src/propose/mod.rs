//! What to record next: references that the firmware runs, within what the machine may be put through.

pub mod drive;
mod limits;
pub mod menu;
mod write;

pub use limits::Limits;
pub use menu::Item;
pub use write::reference_csv;

/// What to record next.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// One or two sentences: what, for how long, why.
    pub text: String,
    /// Identifiers of the rivals.
    pub separates: Vec<String>,
    /// (t, position from where the axis stands), s and rad (m); one a control period. Empty where no motion tells.
    pub reference: Vec<(f64, f64)>,
}
