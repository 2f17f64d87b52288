//! Ctrl-C as something a command looks at, so that it can end in order.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::Error;

/// Whether the user has pressed Ctrl-C, or the system has asked the process to end.
#[derive(Debug, Clone, Default)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// From now on Ctrl-C no longer ends the process by itself. To be called once.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] where the system does not let it.
    pub fn watch() -> Result<Self, Error> {
        let interrupt = Self::default();
        let raised = interrupt.clone();
        ctrlc::set_handler(move || raised.raise())
            .map_err(|error| Error::Usage(format!("Ctrl-C cannot be watched: {error}")))?;
        Ok(interrupt)
    }

    /// As Ctrl-C does.
    pub fn raise(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it has come.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
