//! The numbers of an effect: what bounds them, and how they are fitted.

use super::Size;

/// One number of an effect that the fit moves.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Smallest value that physics allows.
    pub low: f64,
    /// Largest value that physics allows.
    pub high: f64,
    /// A change of this size is typical; steps of the fit and of its derivatives are taken relative to it.
    pub scale: f64,
    /// False for numbers the start grid decides, such as an order per revolution.
    pub free: bool,
    /// Found by a search of the likelihood along it and not by derivatives.
    pub searched: bool,
    /// Found by derivatives and, where those lead no further, by such a search too: its likelihood is rough.
    pub rough: bool,
    /// What bounds and scale are multiples of.
    pub size: Size,
}

/// Bounds and scale of a parameter on a machine, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Typical change.
    pub scale: f64,
}

impl Range {
    /// A step of that size from a value towards the side that is allowed.
    pub(crate) fn allowed(&self, value: f64, step: f64) -> f64 {
        if value + step > self.high { -step } else { step }
    }
}

/// A free parameter between two bounds.
pub(crate) const fn free(low: f64, high: f64, scale: f64) -> Parameter {
    Parameter { low, high, scale, free: true, searched: false, rough: false, size: Size::Unit }
}

/// A free parameter whose bounds and scale are multiples of a size of the machine.
pub(crate) const fn sized(size: Size, low: f64, high: f64, scale: f64) -> Parameter {
    Parameter { low, high, scale, free: true, searched: false, rough: false, size }
}

/// A parameter the start grid decides.
pub(crate) const fn fixed() -> Parameter {
    Parameter {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        scale: 1.0,
        free: false,
        searched: false,
        rough: false,
        size: Size::Unit,
    }
}

/// A number above zero that no derivative of the innovations tells.
pub(crate) const fn searched(low: f64, high: f64) -> Parameter {
    Parameter { low, high, scale: 1.0, free: false, searched: true, rough: false, size: Size::Unit }
}

/// A free parameter above zero whose likelihood is rough.
pub(crate) const fn rough(parameter: Parameter) -> Parameter {
    Parameter { rough: true, ..parameter }
}
