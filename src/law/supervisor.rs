//! Who may command torque and field.
//!
//! ```text
//!          boot_time over              enable (interlock closed,
//!          without a fault             stop released)
//!   Boot ------------------> Ready ---------------------------> Running
//!    ^  |                     |  ^-------------------------------|  |
//!    |  |                     |              disable                |
//!    |  | a fault is          | resolver, parameters,               | any fault, interlock
//!    |  v still there         v monitor, overrun, ...               v open, stop pressed
//!    |  +--------------------> Fault (latched, all causes kept) <---+
//!    |                          |
//!    +--------------------------+ clear, once every cause is gone
//! ```

use crate::step::InputFlags;
use crate::{Faults, Limits, Params};

/// State of the drive. Only `Running` commands anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Supervisor {
    /// The converter settles; faults are ignored until the end of it.
    Boot {
        /// Ticks spent here.
        ticks: u32,
    },
    /// Healthy and still: torque 0, field 0, high voltage disabled.
    Ready,
    /// The law commands torque and field.
    Running,
    /// Safe state, latched.
    Fault {
        /// Every cause seen since the first.
        faults: Faults,
    },
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::Boot { ticks: 0 }
    }
}

impl Supervisor {
    /// Name in logs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Boot { .. } => "boot",
            Self::Ready => "ready",
            Self::Running => "running",
            Self::Fault { .. } => "fault",
        }
    }

    /// The latched causes; empty outside the fault state.
    pub fn faults(self) -> Faults {
        if let Self::Fault { faults } = self { faults } else { Faults::empty() }
    }

    /// The state of this tick, from the last one, what is wrong now, and what is asked for.
    pub(crate) fn next(self, params: &Params, now: Faults, flags: InputFlags, request: Request) -> (Self, Limits) {
        let permitted = flags.contains(InputFlags::INTERLOCK_CLOSED) && !flags.contains(InputFlags::STOP_PRESSED);
        let refuse_enable = if request == Request::Enable { Limits::ENABLE_REFUSED } else { Limits::empty() };
        let refuse_clear = if request == Request::ClearFault { Limits::CLEAR_REFUSED } else { Limits::empty() };
        let refused = refuse_enable | refuse_clear;
        match self {
            Self::Boot { ticks } if ticks < params.boot_ticks => (Self::Boot { ticks: ticks + 1 }, refused),
            Self::Boot { .. } | Self::Ready | Self::Running if !now.is_empty() => {
                (Self::Fault { faults: now }, refused)
            }
            Self::Boot { .. } => (Self::Ready, refused),
            Self::Ready if request == Request::Enable && permitted => (Self::Running, Limits::empty()),
            Self::Ready => (Self::Ready, refused),
            Self::Running if request == Request::Disable => (Self::Ready, Limits::empty()),
            // Enabling twice is no error.
            Self::Running => (Self::Running, refuse_clear),
            Self::Fault { .. } if request == Request::ClearFault && now.is_empty() && permitted => {
                (Self::Boot { ticks: 0 }, Limits::empty())
            }
            Self::Fault { faults } => (Self::Fault { faults: faults | now }, refused),
        }
    }
}

/// What the user asks of the supervisor in this tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Request {
    /// Nothing.
    #[default]
    None,
    /// Ready to running.
    Enable,
    /// Running to ready.
    Disable,
    /// Fault to boot, once every cause is gone.
    ClearFault,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    const GOOD: InputFlags = InputFlags::INTERLOCK_CLOSED;

    fn next(from: Supervisor, now: Faults, flags: InputFlags, request: Request) -> (Supervisor, Limits) {
        from.next(&Params::new(&Config::default()).unwrap(), now, flags, request)
    }

    #[test]
    fn every_transition_of_the_diagram() {
        use Supervisor::{Boot, Fault, Ready, Running};
        let none = Faults::empty();
        let chip = Faults::RESOLVER_CHIP;
        let fault = |faults| Fault { faults };
        let table = [
            (Boot { ticks: 0 }, chip, GOOD, Request::None, Boot { ticks: 1 }),
            (Boot { ticks: 40 }, none, GOOD, Request::None, Ready),
            (Boot { ticks: 40 }, chip, GOOD, Request::None, fault(chip)),
            (Ready, none, GOOD, Request::Enable, Running),
            (Ready, none, InputFlags::empty(), Request::Enable, Ready),
            (Ready, none, GOOD | InputFlags::STOP_PRESSED, Request::Enable, Ready),
            (Ready, chip, GOOD, Request::Enable, fault(chip)),
            (Running, none, GOOD, Request::Disable, Ready),
            (Running, none, GOOD, Request::Enable, Running),
            (Running, chip, GOOD, Request::Disable, fault(chip)),
            (fault(chip), none, GOOD, Request::None, fault(chip)),
            (fault(chip), none, GOOD, Request::Enable, fault(chip)),
            (fault(chip), none, GOOD, Request::ClearFault, Boot { ticks: 0 }),
            (fault(chip), none, InputFlags::empty(), Request::ClearFault, fault(chip)),
            (fault(chip), Faults::LINK_LOST, GOOD, Request::ClearFault, fault(chip | Faults::LINK_LOST)),
        ];
        for (from, now, flags, request, to) in table {
            assert_eq!(next(from, now, flags, request).0, to, "{from:?} {now:?} {flags:?} {request:?}");
        }
    }

    #[test]
    fn refusals_are_coded() {
        let refused = next(Supervisor::Ready, Faults::empty(), InputFlags::empty(), Request::Enable).1;
        assert_eq!(refused, Limits::ENABLE_REFUSED);
        let refused = next(Supervisor::Ready, Faults::empty(), GOOD, Request::ClearFault).1;
        assert_eq!(refused, Limits::CLEAR_REFUSED);
    }
}
