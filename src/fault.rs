//! Faults, which stop the drive, kept apart from limits, which only bound a command.

use bitflags::bitflags;

bitflags! {
    /// What put the drive into its safe state. Any bit means torque 0, field 0, high voltage disabled, until cleared.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    ///
    /// Bit 16 stays free: in a recording it marks a tick in which the drive was not running.
    pub struct Faults: u32 {
        /// The resolver converter reports a fault; its own byte says which.
        const RESOLVER_CHIP = 1 << 0;
        /// The resolver could not be read (SPI error or parity).
        const RESOLVER_BUS = 1 << 1;
        /// Two readings lie further apart than the machine can move in a tick.
        const RESOLVER_JUMP = 1 << 2;
        /// The counts stand still under a torque that must move the rotor: frozen resolver, or a jammed axis.
        const RESOLVER_STALE = 1 << 3;
        /// The high-voltage interlock opened while running.
        const INTERLOCK_OPEN = 1 << 4;
        /// The emergency stop was pressed while running.
        const STOP_PRESSED = 1 << 5;
        /// The command link fell silent while the reference came from it.
        const LINK_LOST = 1 << 6;
        /// A tick began late, or its commands were not ready at the instant they act at.
        const TICK_OVERRUN = 1 << 7;
        /// The parameters in memory are not those that were checked.
        const PARAMETERS = 1 << 8;
        /// The monitor saw more field than the trip level.
        const FIELD_OVER = 1 << 9;
        /// A value of the law was not a number.
        const NOT_FINITE = 1 << 10;
        /// A command could not be written to the DAC or did not get to its outputs, or one of its output stages is overloaded or
        /// too hot.
        const OUTPUT_BUS = 1 << 11;
        /// The last reset came from the watchdog or from a panic.
        const ABNORMAL_RESET = 1 << 12;
        /// The axis was further from its reference than allowed, for longer than allowed.
        const FOLLOWING_ERROR = 1 << 13;
        /// The axis was faster than allowed.
        const OVER_SPEED = 1 << 14;
        /// The motor's amplifier is not ready, or a temperature contact is open.
        const AMPLIFIER = 1 << 15;
        /// There is still high voltage 100 ms after it was switched off.
        const HV_PRESENT = 1 << 17;
        /// The monitor does not see the field that was commanded.
        const FIELD_APART = 1 << 18;
    }
}

bitflags! {
    /// What bounded or refused a command in this tick, without stopping the drive.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct Limits: u8 {
        /// Torque held at the positive limit.
        const TORQUE_ABOVE = 1 << 0;
        /// Torque held at the negative limit.
        const TORQUE_BELOW = 1 << 1;
        /// Field held at its limit.
        const FIELD_ABOVE = 1 << 2;
        /// The error does not fit its counter and was held at the end of the range.
        const ERROR_RANGE = 1 << 3;
        /// Field off because the speed is over `off_speed_rad_s`.
        const OVER_OFF_SPEED = 1 << 4;
        /// Enable refused: not ready, interlock open or stop pressed.
        const ENABLE_REFUSED = 1 << 5;
        /// Clear refused: a cause is still there, or there is no fault.
        const CLEAR_REFUSED = 1 << 6;
    }
}

impl Limits {
    /// A few words for each set bit.
    pub fn explain(self) -> impl Iterator<Item = &'static str> {
        self.iter().map(|limit| match limit {
            Self::TORQUE_ABOVE => "torque at its upper limit",
            Self::TORQUE_BELOW => "torque at its lower limit",
            Self::FIELD_ABOVE => "field at its limit",
            Self::ERROR_RANGE => "error out of range",
            Self::OVER_OFF_SPEED => "field off over off_speed_rad_s",
            Self::ENABLE_REFUSED => "enable refused",
            _ => "clear refused",
        })
    }
}

impl Faults {
    /// Faults after which the count of pole pairs can no longer be trusted.
    pub(crate) const LOSES_POSITION: Self =
        Self::RESOLVER_CHIP.union(Self::RESOLVER_BUS).union(Self::RESOLVER_JUMP).union(Self::RESOLVER_STALE);

    /// Faults in which torque may still be commanded to bring the axis to rest.
    pub(crate) const PERMIT_STOP: Self = Self::LINK_LOST;

    /// One sentence for each set bit: what it means and how it is cleared.
    pub fn explain(self) -> impl Iterator<Item = &'static str> {
        self.iter().map(|fault| match fault {
            Self::RESOLVER_CHIP => "resolver converter reports a fault: check excitation and wiring, then clear",
            Self::RESOLVER_BUS => "resolver could not be read: check SPI1, then clear",
            Self::RESOLVER_JUMP => "resolver counts jumped: check shielding, clear, then home the axis",
            Self::RESOLVER_STALE => {
                "counts stand still under torque: free the axis or replace the resolver, then clear"
            }
            Self::INTERLOCK_OPEN => "high-voltage interlock opened: close it, then clear",
            Self::STOP_PRESSED => "emergency stop pressed: release it, then clear",
            Self::LINK_LOST => "command link lost: reconnect, then clear",
            Self::TICK_OVERRUN => {
                "a control tick overran, or a debugger halted the core: read the cycle counts, then clear"
            }
            Self::PARAMETERS => "parameters damaged or out of range: write a full set and save it, then clear",
            Self::FIELD_OVER => "field over the trip level: check the high-voltage amplifier, then clear",
            Self::NOT_FINITE => "a value was not a number: save the log, reset",
            Self::OUTPUT_BUS => {
                "command DAC not written or loaded, overloaded or too hot: check SPI2, LDAC and its loads, then clear"
            }
            Self::ABNORMAL_RESET => "the watchdog or a panic reset the drive: save the log, then clear",
            Self::FOLLOWING_ERROR => {
                "axis too far from its reference: free it or raise following_error_rad, then clear"
            }
            Self::OVER_SPEED => "axis too fast: check gains and load, or raise over_speed_rad_s, then clear",
            Self::AMPLIFIER => "motor amplifier not ready, or too hot: check its supply and let it cool, then clear",
            Self::HV_PRESENT => "high voltage still there 100 ms after off: do not touch, check its supply, then clear",
            Self::FIELD_APART => {
                "field monitor and command apart: check high-voltage amplifier and monitor, then clear"
            }
            _ => "unknown fault bit: the log is newer than this tool",
        })
    }
}
