//! What goes to the host over RTT: events a person reads, and while recording one frame a tick.

use core::fmt::{Debug, Write};

use er_servo::app::InitError;
use er_servo::{Faults, Frame, Supervisor};

/// Watches the frames for events.
pub struct Log {
    supervisor: Supervisor,
}

impl Log {
    /// Before the first frame.
    pub fn new() -> Self {
        Self { supervisor: Supervisor::default() }
    }

    /// The drive has come up.
    pub fn booted(&mut self, reset_faults: Faults) {
        defmt::info!("er-servo, build {=str}", env!("CARGO_PKG_VERSION"));
        for sentence in reset_faults.explain() {
            defmt::warn!("{=str}", sentence);
        }
    }

    /// Logs what changed with this frame.
    pub fn frame(&mut self, frame: &Frame) {
        let now = frame.outputs.supervisor;
        if now.name() != self.supervisor.name() || now.faults() != self.supervisor.faults() {
            let new = now.faults().difference(self.supervisor.faults());
            defmt::info!("tick {=u32}: {=str}", frame.seq, now.name());
            for sentence in new.explain() {
                defmt::error!("{=str}", sentence);
            }
        }
        self.supervisor = now;
    }
}

/// A chip did not come up; the drive ticks on and reports it.
pub fn init_failed<R: Debug, D: Debug>(error: &InitError<R, D>) {
    let mut text = heapless::String::<160>::new();
    // A message that is too long is cut, not lost.
    let _ = match error {
        InitError::Resolver(error) => write!(text, "{error}"),
        InitError::Dac(error) => write!(text, "{error}"),
    };
    defmt::error!("{=str}", text.as_str());
}
