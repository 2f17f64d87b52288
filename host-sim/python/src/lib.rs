//! The native part of the Python package `servo_lab`: what the command line calls, on data that Python holds.
//!
//! Long work runs on a thread of its own, without Python's lock; Ctrl-C ends the wait for it, the work itself ends with what
//! it is at. An [`lab::Error`] becomes a `ServoLabError` with the same message.

mod arrow;
mod commands;
mod diagnose;
mod flags;
mod fleet;
mod work;

use pyo3::prelude::*;

/// What Python imports; the package beside it gives it types and documents.
#[pymodule]
mod _servo_lab {
    #[pymodule_export]
    use super::arrow::Table;
    #[pymodule_export]
    use super::commands::{compare, simulate, tune};
    #[pymodule_export]
    use super::diagnose::diagnose;
    #[pymodule_export]
    use super::fleet::{fleet, manifest};
    #[pymodule_export]
    use super::work::ServoLabError;
}
