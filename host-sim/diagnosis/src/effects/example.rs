//! An effect from nothing to clear, on the servo of the paper: what the field guide shows of it.

/// Sizes of an effect on the default machine of the field guide.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// Fitted values at a size: 0 is the default machine (or the limit towards it), 1 is clear in any recording.
    pub at: fn(f64) -> Vec<f64>,
    /// Which reported parameter tells the size.
    pub told_by: usize,
    /// False where no size is the default machine: the model is another one.
    pub nested: bool,
}

/// Told by the first reported parameter.
pub(crate) const fn shown(at: fn(f64) -> Vec<f64>) -> Option<Example> {
    shown_by(0, at)
}

/// Told by the reported parameter at that index.
pub(crate) const fn shown_by(told_by: usize, at: fn(f64) -> Vec<f64>) -> Option<Example> {
    Some(Example { at, told_by, nested: true })
}

/// Of a model that is no size of the default one.
pub(crate) const fn shown_as_another(at: fn(f64) -> Vec<f64>) -> Option<Example> {
    Some(Example { at, told_by: 0, nested: false })
}
