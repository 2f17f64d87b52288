//! Who may command torque and field.
//!
//! ```text
//!          boot_time over              enable (interlock closed,
//!          without a fault             stop released)
//!   Boot ------------------> Ready ---------------------------> Running
//!    ^  |                     |  ^-------------------------------|  |
//!    |  |                     |    disable, through Stopping       |
//!    |  | a fault is          | resolver, parameters,               | any fault, interlock
//!    |  v still there         v monitor, overrun, ...               v open, stop pressed
//!    |  +--------------------> Fault (latched, all causes kept) <---+
//!    |                          |
//!    +--------------------------+ clear, once every cause is gone
//! ```
//!
//! Stopping lies between Running and Ready after a disable, or between Running and Fault after a lost link, where the
//! parameters ask for a controlled stop (category 1 of IEC 60204-1) and the axis moves: it brakes until the axis rests or
//! its time is over. Any other fault ends it at once (category 0).

use crate::step::InputFlags;
use crate::{Faults, Limits, Params};

/// State of the drive. Only `Running` and `Stopping` command anything.
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
    /// The axis is brought to rest.
    Stopping {
        /// What is latched once it rests; none after a disable.
        faults: Faults,
    },
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
            Self::Stopping { .. } => "stopping",
            Self::Fault { .. } => "fault",
        }
    }

    /// The latched causes, or those of a stop; empty in other states.
    pub fn faults(self) -> Faults {
        match self {
            Self::Fault { faults } | Self::Stopping { faults } => faults,
            _ => Faults::empty(),
        }
    }

    /// The state of this tick, from the last one, what is wrong now, what is asked for, and whether the axis rests (or had
    /// its time to).
    pub(crate) fn next(
        self,
        params: &Params,
        now: Faults,
        flags: InputFlags,
        request: Request,
        at_rest: bool,
    ) -> (Self, Limits) {
        let permitted = flags.contains(InputFlags::INTERLOCK_CLOSED) && !flags.contains(InputFlags::STOP_PRESSED);
        let refuse_enable = if request == Request::Enable { Limits::ENABLE_REFUSED } else { Limits::empty() };
        let refuse_clear = if request == Request::ClearFault { Limits::CLEAR_REFUSED } else { Limits::empty() };
        let refused = refuse_enable | refuse_clear;
        match self {
            Self::Boot { ticks } if ticks < params.boot_ticks => (Self::Boot { ticks: ticks + 1 }, refused),
            Self::Running if params.stop.on_link_loss && !now.is_empty() && Faults::PERMIT_STOP.contains(now) => {
                (Self::stopped(now, at_rest), refused)
            }
            Self::Boot { .. } | Self::Ready | Self::Running if !now.is_empty() => {
                (Self::Fault { faults: now }, refused)
            }
            // A silent link is no reason to let go of an axis that is being stopped.
            Self::Stopping { faults } if !Faults::PERMIT_STOP.contains(now) => {
                (Self::Fault { faults: faults | now }, refused)
            }
            Self::Stopping { faults } => (Self::stopped(faults, at_rest), refused),
            Self::Boot { .. } => (Self::Ready, refused),
            Self::Ready if request == Request::Enable && permitted => (Self::Running, Limits::empty()),
            Self::Ready => (Self::Ready, refused),
            Self::Running if request == Request::Disable => {
                (Self::stopped(Faults::empty(), at_rest || !params.stop.on_disable), Limits::empty())
            }
            // Enabling twice is no error.
            Self::Running => (Self::Running, refuse_clear),
            Self::Fault { .. } if request == Request::ClearFault && now.is_empty() && permitted => {
                (Self::Boot { ticks: 0 }, Limits::empty())
            }
            Self::Fault { faults } => (Self::Fault { faults: faults | now }, refused),
        }
    }

    /// On the way to rest, or there.
    fn stopped(faults: Faults, at_rest: bool) -> Self {
        match at_rest {
            false => Self::Stopping { faults },
            true if faults.is_empty() => Self::Ready,
            true => Self::Fault { faults },
        }
    }
}

/// One count a sample, rad/s: a slower motion cannot be told from rest (control.md section 3).
const ONE_COUNT_RAD_S: f32 = 0.0257;

/// Whether a speed is rest for a controlled stop.
pub(crate) fn is_rest(params: &Params, speed_rad_s: f32) -> bool {
    let limit = params.brake_deadband_rad_s;
    speed_rad_s.abs() <= if limit > ONE_COUNT_RAD_S { limit } else { ONE_COUNT_RAD_S }
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
    /// The position is to be called what the reference says; only while ready.
    SetPosition,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    const GOOD: InputFlags = InputFlags::INTERLOCK_CLOSED;

    fn next(from: Supervisor, now: Faults, flags: InputFlags, request: Request) -> (Supervisor, Limits) {
        from.next(&Params::new(&Config::default()).unwrap(), now, flags, request, true)
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
    fn a_stop_ends_at_rest_and_any_fault_that_forbids_torque_ends_it_at_once() {
        use Supervisor::{Fault, Ready, Running, Stopping};
        let config = Config { stop_on_link_loss: true, ..Config::default() };
        let params = Params::new(&config).unwrap();
        let (none, lost, chip) = (Faults::empty(), Faults::LINK_LOST, Faults::RESOLVER_CHIP);
        let table = [
            (Running, none, Request::Disable, false, Stopping { faults: none }),
            (Running, none, Request::Disable, true, Ready),
            (Running, lost, Request::None, false, Stopping { faults: lost }),
            (Running, lost, Request::None, true, Fault { faults: lost }),
            (Running, lost | chip, Request::None, false, Fault { faults: lost | chip }),
            (Stopping { faults: none }, none, Request::Enable, false, Stopping { faults: none }),
            (Stopping { faults: none }, lost, Request::None, false, Stopping { faults: none }),
            (Stopping { faults: none }, none, Request::None, true, Ready),
            (Stopping { faults: lost }, lost, Request::None, true, Fault { faults: lost }),
            (Stopping { faults: lost }, chip, Request::None, false, Fault { faults: lost | chip }),
        ];
        for (from, now, request, at_rest, to) in table {
            assert_eq!(from.next(&params, now, GOOD, request, at_rest).0, to, "{from:?} {now:?} {request:?} {at_rest}");
        }
        let at_once = Params::new(&Config { stop_on_disable: false, ..Config::default() }).unwrap();
        assert_eq!(Running.next(&at_once, none, GOOD, Request::Disable, false).0, Ready);
        assert_eq!(Running.next(&at_once, lost, GOOD, Request::None, false).0, Fault { faults: lost });
    }

    #[test]
    fn refusals_are_coded() {
        let refused = next(Supervisor::Ready, Faults::empty(), InputFlags::empty(), Request::Enable).1;
        assert_eq!(refused, Limits::ENABLE_REFUSED);
        let refused = next(Supervisor::Ready, Faults::empty(), GOOD, Request::ClearFault).1;
        assert_eq!(refused, Limits::CLEAR_REFUSED);
    }
}
