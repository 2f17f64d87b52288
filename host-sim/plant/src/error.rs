//! What can be wrong with a model or with a run.

/// Why a model, a command or a time was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter of the model is outside its range.
    #[error("{key} = {value}: must be {allowed}")]
    Parameter {
        /// The key as the machine file writes it.
        key: String,
        /// The value found.
        value: f64,
        /// The allowed range in words.
        allowed: &'static str,
    },
    /// A command that is not a finite number.
    #[error("command at t = {t_s} s: {quantity} = {value} is not a finite number")]
    Command {
        /// When it was given, s.
        t_s: f64,
        /// Which of its quantities.
        quantity: &'static str,
        /// The value found.
        value: f64,
    },
    /// Time does not run forward.
    #[error("time runs back: {t_s} s after {previous_s} s")]
    Time {
        /// The time before, s.
        previous_s: f64,
        /// The offending time, s.
        t_s: f64,
    },
    /// The model took more work than [`crate::Mechanics::at_most`] allows.
    #[error(
        "the model is too stiff to follow along so many rows; check its inertia, and stiffness and amplitudes of its effects"
    )]
    TooStiff,
    /// Slices that must match do not.
    #[error("{left} is {left_len} long and {right} is {right_len}")]
    Length {
        /// First slice.
        left: &'static str,
        /// Its length.
        left_len: usize,
        /// Second slice.
        right: &'static str,
        /// Its length.
        right_len: usize,
    },
}
