//! What can go wrong, and what must be seen of it.

/// A cause is seen by the next sample, half a millisecond later at most, and acted upon within the same tick.
const ONE_TICK_NS: u64 = 500_000 + 25_000;
/// The converter of the field monitor is read a tick after it was started, the guard sees what the law did a tick before.
const TWO_TICKS_NS: u64 = 2 * ONE_TICK_NS;
const MS: u64 = 1_000_000;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cause {
    ChipFault,
    Garbage,
    AllOnes,
    AllZeros,
    Jump,
    Frozen,
    Interlock,
    Stop,
    LinkCut,
    Flood,
    Replay,
    BitInTick,
    BitInRam,
    BitInStack,
    Reset,
    NoReader,
    CommandBus,
    FieldOver,
    FieldApart,
    Amplifier,
    OverSpeed,
    Overrun,
    Halt,
    Panic,
    HardFault,
    StackOverflow,
    Crystal,
    SecondClient,
    DamagedFlash,
    StuckHighVoltage,
    TimerUpset,
}

pub const CAUSES: [Cause; 30] = [
    Cause::Garbage,
    Cause::AllOnes,
    Cause::AllZeros,
    Cause::Jump,
    Cause::Frozen,
    Cause::Interlock,
    Cause::Stop,
    Cause::LinkCut,
    Cause::Flood,
    Cause::Replay,
    Cause::BitInTick,
    Cause::BitInRam,
    Cause::BitInStack,
    Cause::Reset,
    Cause::NoReader,
    Cause::CommandBus,
    Cause::FieldOver,
    Cause::FieldApart,
    Cause::Amplifier,
    Cause::OverSpeed,
    Cause::Overrun,
    Cause::Halt,
    Cause::Panic,
    Cause::HardFault,
    Cause::StackOverflow,
    Cause::Crystal,
    Cause::SecondClient,
    Cause::DamagedFlash,
    Cause::StuckHighVoltage,
    Cause::TimerUpset,
];

/// What must be seen of a cause.
pub enum Expected {
    /// Outputs zero within so many nanoseconds, and this in the log.
    Safe(u64, &'static str),
    /// The same, and a restart by the watchdog, after which the drive stands still.
    Restarts(u64, &'static str),
    /// The drive goes on as if nothing had happened.
    Undisturbed,
    /// The drive never starts, and says this.
    Never(&'static str),
    /// Nothing but the limits, and that ticks go on (after a restart by the watchdog, if need be).
    Bounded,
}

impl Cause {
    pub fn expected(self) -> Expected {
        use Expected::{Bounded, Never, Restarts, Safe, Undisturbed};
        match self {
            Self::ChipFault | Self::AllOnes => Safe(ONE_TICK_NS, "resolver converter reports a fault"),
            // Noise may be a fault byte, or none and a jump.
            Self::Garbage => Safe(ONE_TICK_NS, "resolver"),
            Self::AllZeros | Self::Jump => Safe(ONE_TICK_NS, "resolver counts jumped"),
            // A rotor at rest is no fault; one at rest under a torque that must move it is, after stale_time_s (20 ms).
            Self::Frozen => Safe(21 * MS + ONE_TICK_NS, "counts stand still under torque"),
            Self::Interlock => Safe(ONE_TICK_NS, "interlock opened"),
            Self::Stop => Safe(ONE_TICK_NS, "emergency stop pressed"),
            // The cause is the silence, which is one after 250 ms.
            Self::LinkCut => Safe(250 * MS + ONE_TICK_NS, "command link lost"),
            Self::Reset => Safe(ONE_TICK_NS, "er-servo"),
            // The DAC is asked for its state every 64 ms.
            Self::CommandBus => Safe(64 * MS + TWO_TICKS_NS, "command DAC not written"),
            Self::FieldOver => Safe(TWO_TICKS_NS, "field over the trip level"),
            // 20 ms apart without a break, while the step changes the field; with that of the brake it is over the trip level.
            Self::FieldApart => Safe(70 * MS, "field "),
            Self::Amplifier => Safe(ONE_TICK_NS, "motor amplifier not ready"),
            // From rest to the trip level under the push.
            Self::OverSpeed => Safe(60 * MS, "axis too fast"),
            // The core stands still for up to 1.8 ms.
            Self::Overrun => Safe(1_800_000 + ONE_TICK_NS, "a control tick overran"),
            // Two milliseconds of the monostable, and the look of the world every half millisecond.
            Self::Halt => Restarts(2 * MS + ONE_TICK_NS, ""),
            Self::Panic => Restarts(ONE_TICK_NS, "it panicked at src/"),
            Self::HardFault | Self::StackOverflow => Restarts(ONE_TICK_NS, "hard fault"),
            Self::Crystal => Restarts(ONE_TICK_NS, "the crystal failed"),
            Self::Flood | Self::Replay | Self::NoReader | Self::SecondClient => Undisturbed,
            Self::DamagedFlash => Never("parameters damaged or out of range"),
            // The drive is disabled: what is left is to say so.
            Self::StuckHighVoltage => Safe(101 * MS, "high voltage still there"),
            // A flipped bit in a reference or a state is a value like any other; in the parameters it is a fault.
            // The counts of the edges are written anew in every tick; without ticks the monostable and the watchdog act.
            Self::BitInTick | Self::BitInRam | Self::BitInStack | Self::TimerUpset => Bounded,
        }
    }

    /// How long to watch after the cause, ns: until it must have shown, or the drive has come up again.
    pub fn watched_ns(self) -> u64 {
        match self.expected() {
            Expected::Restarts(..) => 200 * MS,
            Expected::Bounded | Expected::Undisturbed => 130 * MS,
            Expected::Safe(within_ns, _) if self == Self::Reset => within_ns + 90 * MS,
            Expected::Safe(within_ns, _) => within_ns + 25 * MS,
            Expected::Never(_) => 20 * MS,
        }
    }
}
