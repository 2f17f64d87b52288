//! The application loop of the firmware over embedded-hal: the image runs it on its pins, host-sim on the plant's chips.

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;

use crate::drivers::ad2s1210::{self, Ad2s1210, SAMPLE_TO_READ_NS, Settings};
use crate::drivers::dac::{self, Dac, Load, When};
use crate::drivers::scaling::{FieldCode, TorqueCode};
use crate::guard::Guard;
use crate::{
    Counts, Faults, Frame, InputFlags, Inputs, Mode, MonitorCode, Outputs, Params, Request, ResolverCode,
    ResolverSample, State, Supervisor, Timing, step,
};

/// The monitor of the field that really acts.
pub trait FieldMonitor {
    /// The last conversion; must not wait.
    fn read(&mut self) -> MonitorCode;
}

/// Short waits, and one that counts from an instant, so that work fits between.
pub trait SampleDelay: DelayNs {
    /// SAMPLE has just been told to fall; a clock that knows the instant by itself does nothing.
    fn mark(&mut self);
    /// Waits until so many nanoseconds after it fell.
    fn wait_since_mark(&mut self, wait_ns: u32);
}

/// Everything the drive is wired to. Input pins are fail-safe: a broken wire reads low, which is interlock open and stop
/// pressed.
#[derive(Debug)]
pub struct Wiring<ResolverSpi, Sample, ResolverPin, DacSpi, Ldac, Clear, Input, Output, Monitor, Delay> {
    /// Resolver converter.
    pub resolver: Ad2s1210<ResolverSpi, Sample, ResolverPin, ResolverPin, ResolverPin>,
    /// Torque and field commands.
    pub dac: Dac<DacSpi, Ldac, Clear>,
    /// High: the high-voltage interlock is closed.
    pub interlock_closed: Input,
    /// High: the emergency stop is released.
    pub stop_released: Input,
    /// High: the motor's amplifier is ready and no temperature contact is open.
    pub amplifier_ready: Input,
    /// High: the high-voltage supply may be on.
    pub hv_enable: Output,
    /// High: a fault is latched.
    pub fault_lamp: Output,
    /// High: the damper is used as a brake.
    pub brake_feedback: Output,
    /// Changes its level at the end of every tick. A monostable outside takes torque and high voltage off without it.
    pub heartbeat: Output,
    /// Field monitor.
    pub monitor: Monitor,
    /// Short waits.
    pub delay: Delay,
}

/// What the user, the link and the watch over the interrupt want of one tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Orders {
    /// Asked of the supervisor.
    pub request: Request,
    /// Reference position.
    pub reference: Counts,
    /// The reference comes from the link, so that its silence is a fault.
    pub reference_from_link: bool,
    /// The link has been heard of recently.
    pub link_alive: bool,
    /// The reference is held at a soft limit.
    pub reference_limited: bool,
    /// Greatest torque of this command, whole N m; 0 for no bound but the parameter's.
    pub torque_bound_nm: u8,
    /// Faults found outside the law: overrun, abnormal reset, refused parameters.
    pub reported: Faults,
    /// Frames the log lost so far.
    pub lost: u16,
}

/// Why the chips did not come up.
#[derive(Debug, PartialEq, Eq)]
pub enum InitError<R, D> {
    /// The resolver converter.
    Resolver(ad2s1210::Error<R>),
    /// The command DAC.
    Dac(dac::Error<D>),
}

/// The DAC is asked for its state every so many ticks, 64 ms: heat and a short circuit last longer.
const DAC_STATUS_TICKS: u32 = 128;

/// The servo: wiring, parameters, state of the law.
#[derive(Debug)]
pub struct Servo<W> {
    wiring: W,
    params: Params,
    state: State,
    seq: u32,
    hardware_faults: Faults,
    /// The commands of the last tick were not ready at their instant.
    late: bool,
    guard: Guard,
    /// What the law decided in the last tick.
    last: Option<Outputs>,
    /// No tick was made for a while before the next one.
    paused: bool,
    beat: bool,
    /// SAMPLE has fallen for the next tick.
    sampled: bool,
}

impl<RS, S, RP, DS, L, C, I, O, M, D> Servo<Wiring<RS, S, RP, DS, L, C, I, O, M, D>>
where
    RS: SpiDevice,
    S: OutputPin,
    RP: OutputPin,
    DS: SpiDevice,
    L: Load,
    C: OutputPin,
    I: InputPin,
    O: OutputPin,
    M: FieldMonitor,
    D: SampleDelay,
{
    /// Takes wiring and parameters; touches nothing before [`Self::init`].
    pub fn new(wiring: Wiring<RS, S, RP, DS, L, C, I, O, M, D>, params: Params) -> Self {
        let hardware_faults = Faults::RESOLVER_BUS | Faults::OUTPUT_BUS;
        Self {
            wiring,
            params,
            state: State::default(),
            seq: 0,
            hardware_faults,
            late: false,
            guard: Guard::default(),
            last: None,
            paused: false,
            beat: false,
            sampled: false,
        }
    }

    /// Brings both chips up with their outputs at 0, in thread mode and with ticks stopped; takes about 45 ms. Called at
    /// reset and before a fault of the hardware is cleared.
    ///
    /// # Errors
    /// The first chip that does not come up. The drive can tick on: the fault is reported to the law at every tick.
    pub fn init(&mut self) -> Result<(), InitError<RS::Error, DS::Error>> {
        self.hardware_faults = Faults::RESOLVER_BUS | Faults::OUTPUT_BUS;
        self.late = false;
        self.pause();
        let wiring = &mut self.wiring;
        wiring.dac.init(&mut wiring.delay).map_err(InitError::Dac)?;
        self.hardware_faults.remove(Faults::OUTPUT_BUS);
        wiring.resolver.init(&Settings::default(), &mut wiring.delay).map_err(InitError::Resolver)?;
        self.hardware_faults.remove(Faults::RESOLVER_BUS);
        Ok(())
    }

    /// The position is what it is now: SAMPLE falls, or a timer has made it fall for this tick. What the tick needs besides may be
    /// worked out until [`Self::tick`], while the converter takes its time.
    pub fn sample(&mut self) {
        // A pin that cannot be driven shows as a position that is not read, or stands still.
        self.sampled = self.wiring.resolver.latch().is_ok();
        self.wiring.delay.mark();
    }

    /// One tick, in the interrupt: [`Self::sample`] if that was not done, read, one [`step()`], write. A command that cannot be written is a fault in this very
    /// tick: outputs are cleared by pin and high voltage is disabled; the law latches it in the next.
    pub fn tick(&mut self, orders: &Orders) -> Frame {
        if !self.sampled {
            self.sample();
        }
        let mut inputs = self.read(orders);
        if core::mem::take(&mut self.late) {
            inputs.reported |= Faults::TICK_OVERRUN;
        }
        inputs.reported |= self.guard.check(&self.params, &inputs, self.last.as_ref());
        let outputs = step(&self.params, &mut self.state, &inputs);
        if self.write(&outputs).is_err() {
            self.hardware_faults |= Faults::OUTPUT_BUS;
            self.emergency_off();
        }
        let frame = Frame { seq: self.seq, lost: orders.lost, inputs, outputs, timing: Timing::default() };
        self.seq = self.seq.wrapping_add(1);
        self.last = Some(outputs);
        self.beat = !self.beat;
        // Without the pulse the monostable takes the outputs off: a pin that fails is safe.
        let _ = self.wiring.heartbeat.set_state(self.beat.into());
        frame
    }

    /// Notes that no tick is made for a while: where the axis goes meanwhile is not seen, so the position is lost.
    pub fn pause(&mut self) {
        self.paused = true;
    }

    /// Everything off by pins alone, for panics and hard faults; needs no bus and no sound memory beyond the pins.
    pub fn emergency_off(&mut self) {
        self.hv_off();
        // Nothing is left to do about a pin that fails here; the high voltage is disabled by another.
        let _ = self.wiring.dac.clear();
    }

    /// Replaces the parameters, between two ticks. Refused while running: a gain that changes under load is a step of
    /// torque.
    ///
    /// # Errors
    /// The state the drive is in.
    pub fn set_params(&mut self, params: Params) -> Result<(), Supervisor> {
        match self.state.supervisor() {
            moving @ (Supervisor::Running | Supervisor::Stopping { .. }) => Err(moving),
            _ => {
                self.params = params;
                Ok(())
            }
        }
    }

    /// Parameters of the law.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// State of the law, for the snapshot a recording begins with.
    pub fn state(&self) -> &State {
        &self.state
    }

    fn read(&mut self, orders: &Orders) -> Inputs {
        let sampled = core::mem::take(&mut self.sampled);
        let wiring = &mut self.wiring;
        let mut flags = InputFlags::empty();
        // A pin that cannot be read counts as open or pressed.
        flags.set(InputFlags::INTERLOCK_CLOSED, wiring.interlock_closed.is_high().unwrap_or(false));
        flags.set(InputFlags::STOP_PRESSED, !wiring.stop_released.is_high().unwrap_or(false));
        flags.set(InputFlags::LINK_ALIVE, orders.link_alive);
        flags.set(InputFlags::REFERENCE_FROM_LINK, orders.reference_from_link);
        flags.set(InputFlags::REFERENCE_LIMITED, orders.reference_limited);
        flags.set(InputFlags::AMPLIFIER_READY, wiring.amplifier_ready.is_high().unwrap_or(false));
        flags.set(InputFlags::PAUSED, core::mem::take(&mut self.paused));
        wiring.delay.wait_since_mark(SAMPLE_TO_READ_NS);
        let resolver = match wiring.resolver.read() {
            Ok(reading) if sampled => ResolverSample {
                code: ResolverCode(reading.counts),
                fault_byte: reading.faults.bits(),
                speed_rad_s: 0.0,
            },
            _ => {
                flags |= InputFlags::RESOLVER_UNREAD;
                ResolverSample::default()
            }
        };
        Inputs {
            resolver,
            flags,
            reference: orders.reference,
            request: orders.request,
            torque_bound_nm: orders.torque_bound_nm,
            field_monitor: wiring.monitor.read(),
            reported: orders.reported | self.hardware_faults,
        }
    }

    fn write(&mut self, outputs: &Outputs) -> Result<(), ()> {
        let torque = TorqueCode::from_torque_nm(outputs.torque_nm);
        let field = FieldCode::from_field_kv_mm(outputs.field_kv_mm);
        let hv = self.wiring.hv_enable.set_state(outputs.hv_enable.into()).map_err(|_| ());
        // A DAC that failed stays cleared by its pin until `init`; writing to it again would not help.
        let failed_before = self.hardware_faults.contains(Faults::OUTPUT_BUS);
        // What moves the axis acts at its instant, so that the loop has one delay; a zero acts as soon as it can.
        let when = if outputs.hv_enable { When::OnTime } else { When::Now };
        let commands = if failed_before { Ok(()) } else { self.command(torque, field, when) };
        let faulted = matches!(outputs.supervisor, Supervisor::Fault { .. });
        // Lamps: a failed one is no reason to stop.
        let _ = self.wiring.fault_lamp.set_state(faulted.into());
        let _ = self.wiring.brake_feedback.set_state((outputs.mode == Mode::Brake).into());
        hv.and(commands)
    }

    /// Writes both commands. In one tick of many the DAC is asked for its state behind them; it answers while the next
    /// tick's are written, so that no tick has to wait for two more frames.
    fn command(&mut self, torque: TorqueCode, field: FieldCode, when: When) -> Result<(), ()> {
        let dac = &mut self.wiring.dac;
        let written = if self.seq.is_multiple_of(DAC_STATUS_TICKS) {
            dac.write_and_ask(torque, field, when)
        } else {
            dac.write(torque, field, when)
        };
        self.late = !written.map_err(|_| ())?;
        Ok(())
    }

    fn hv_off(&mut self) {
        let _ = self.wiring.hv_enable.set_low();
    }
}
