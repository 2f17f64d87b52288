//! The application loop with its hardware swapped for the simulated plant: real drivers, SPI bytes, simulated chips.
//!
//! ```text
//! Servo::tick -> drivers -> SPI bytes, pins -> chips -> torque, field -> plant -> angle -> chips -> ...
//! ```
extern crate std;

use core::cell::Cell;
use core::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use plant::chips::hal::{ChipDelay, ChipPin, Socket, SpiPort};
use plant::chips::{self, Chip};
use plant::{Command, Model, Plant};

use crate::app::{FieldMonitor, InitError, Orders, SampleDelay, Servo, Wiring};
use crate::drivers::ad2s1210::{self, Ad2s1210};
use crate::drivers::dac::{self, Dac};
use crate::{Frame, Mode, MonitorCode, Params, Request, Supervisor};

/// A pin that is just a wire.
#[derive(Debug, Clone, Default)]
pub struct Wire(Rc<Cell<bool>>);

impl Wire {
    /// The level on it.
    pub fn level(&self) -> bool {
        self.0.get()
    }

    /// Puts a level on it.
    pub fn set(&self, high: bool) {
        self.0.set(high);
    }
}

impl ErrorType for Wire {
    type Error = Infallible;
}

impl InputPin for Wire {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.get())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.get())
    }
}

impl OutputPin for Wire {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(true);
        Ok(())
    }
}

impl SampleDelay for ChipDelay<chips::Ad2s1210> {
    // Nothing but waits takes time here.
    fn mark(&mut self) {}

    fn wait_since_mark(&mut self, wait_ns: u32) {
        embedded_hal::delay::DelayNs::delay_ns(self, wait_ns);
    }
}

/// The field monitor, fed by the plant.
#[derive(Debug, Clone, Default)]
pub struct SimulatedMonitor(Rc<Cell<u16>>);

impl FieldMonitor for SimulatedMonitor {
    fn read(&mut self) -> MonitorCode {
        MonitorCode(self.0.get())
    }
}

type ResolverSocket = Socket<chips::Ad2s1210>;
type DacSocket = Socket<chips::Dac>;
type SimulatedWiring = Wiring<
    SpiPort<chips::Ad2s1210>,
    ChipPin<chips::Ad2s1210>,
    ChipPin<chips::Ad2s1210>,
    SpiPort<chips::Dac>,
    ChipPin<chips::Dac>,
    ChipPin<chips::Dac>,
    Wire,
    Wire,
    SimulatedMonitor,
    ChipDelay<chips::Ad2s1210>,
>;

/// The drive on a bench: application loop, chips, plant, and everything a test may pull at.
#[derive(Debug)]
pub struct Bench {
    /// The application loop.
    pub servo: Servo<SimulatedWiring>,
    /// The resolver converter; its faults are injected here.
    pub resolver: ResolverSocket,
    /// The DAC; its faults are injected here.
    pub dac: DacSocket,
    /// The interlock contact; high is closed.
    pub interlock_closed: Wire,
    /// The emergency stop; high is released.
    pub stop_released: Wire,
    /// The amplifier's ready contact; high is ready.
    pub amplifier_ready: Wire,
    /// Changes with every tick.
    pub heartbeat: Wire,
    /// The high-voltage supply's enable.
    pub hv_enable: Wire,
    /// The fault lamp.
    pub fault_lamp: Wire,
    /// The brake feedback.
    pub brake_feedback: Wire,
    /// Field added to what the amplifier puts out, kV/mm: a broken amplifier.
    pub stray_field_kv_mm: f64,
    /// Torque on the rotor from outside, N m.
    pub external_torque_nm: f64,
    monitor: SimulatedMonitor,
    plant: Plant,
    ticks: u32,
    period_s: f64,
}

/// Why the bench stopped.
pub type BenchError = plant::Error;

impl Bench {
    /// Wires everything up; the rotor rests at 0, the interlock is closed, the stop released, nothing is initialised.
    ///
    /// # Errors
    /// A model the plant refuses.
    pub fn new(model: &Model, params: Params, period_s: f64) -> Result<Self, BenchError> {
        let resolver = Socket::new(chips::Ad2s1210::new());
        let dac = Socket::new(chips::Dac::new(chips::dac::Part::Dual));
        let [interlock_closed, stop_released, amplifier_ready, heartbeat, hv_enable, fault_lamp, brake_feedback] =
            core::array::from_fn(|_| Wire::default());
        [&interlock_closed, &stop_released, &amplifier_ready].iter().for_each(|wire| wire.set(true));
        let monitor = SimulatedMonitor::default();
        let wiring = Wiring {
            resolver: Ad2s1210::new(resolver.spi(), resolver_pins(&resolver)),
            dac: Dac::new(dac.spi(), dac_pins(&dac), dac::Part::Dual),
            interlock_closed: interlock_closed.clone(),
            stop_released: stop_released.clone(),
            amplifier_ready: amplifier_ready.clone(),
            heartbeat: heartbeat.clone(),
            hv_enable: hv_enable.clone(),
            fault_lamp: fault_lamp.clone(),
            brake_feedback: brake_feedback.clone(),
            monitor: monitor.clone(),
            delay: resolver.delay(),
        };
        Ok(Self {
            servo: Servo::new(wiring, params),
            resolver,
            dac,
            interlock_closed,
            stop_released,
            amplifier_ready,
            heartbeat,
            hv_enable,
            fault_lamp,
            brake_feedback,
            stray_field_kv_mm: 0.0,
            external_torque_nm: 0.0,
            monitor,
            plant: Plant::new(model, plant::State::default(), 0.0)?,
            ticks: 0,
            period_s,
        })
    }

    /// Initialises the chips as the firmware does at reset.
    ///
    /// # Errors
    /// What the drivers say.
    pub fn init(&mut self) -> Result<(), InitError<embedded_hal::spi::ErrorKind, embedded_hal::spi::ErrorKind>> {
        self.servo.init()
    }

    /// Torque and field that act on the plant now, from the DAC's volts and the enable pin.
    pub fn acting(&self) -> (f64, f64) {
        let (torque_nm, field_kv_mm) = self.dac.with(|dac| (dac.torque_nm(), dac.field_kv_mm()));
        let field_kv_mm = if self.hv_enable.level() { field_kv_mm.max(0.0) } else { 0.0 };
        (torque_nm, field_kv_mm + self.stray_field_kv_mm)
    }

    /// True position, rad, and speed, rad/s.
    pub fn truth(&self) -> plant::State {
        *self.plant.state()
    }

    /// One control period: the chips see the rotor, the application ticks, the plant moves on.
    ///
    /// # Errors
    /// A simulated quantity that left the finite numbers.
    pub fn tick(&mut self, orders: &Orders) -> Result<Frame, BenchError> {
        let truth = self.truth();
        let period_s = self.period_s;
        self.resolver.with(|chip| {
            chip.advance(period_s);
            chip.set_motion(truth.position, truth.velocity);
        });
        let (_, field_kv_mm) = self.acting();
        self.monitor.0.set(MonitorCode::from_kv_mm(field_kv_mm as f32).0);
        let frame = self.servo.tick(orders);
        let (torque, field_kv_mm) = self.acting();
        let command = Command {
            torque,
            field_kv_mm,
            braking: frame.outputs.mode == Mode::Brake,
            speed_estimate: f64::from(frame.outputs.speed_rad_s),
            external_torque: self.external_torque_nm,
            ..Command::default()
        };
        self.ticks += 1;
        self.plant.advance(&command, f64::from(self.ticks) * self.period_s)?;
        Ok(frame)
    }

    /// Ticks through boot and an enable, the reference where the axis stands; returns the last frame.
    ///
    /// # Errors
    /// As [`Self::tick`].
    pub fn enable(&mut self) -> Result<Frame, BenchError> {
        let mut frame = self.tick(&Orders::default())?;
        while matches!(frame.outputs.supervisor, Supervisor::Boot { .. }) {
            frame = self.tick(&Orders::default())?;
        }
        let reference = frame.outputs.position;
        self.tick(&Orders { request: Request::Enable, reference, ..Orders::default() })
    }
}

fn resolver_pins(
    socket: &ResolverSocket,
) -> ad2s1210::Pins<
    ChipPin<chips::Ad2s1210>,
    ChipPin<chips::Ad2s1210>,
    ChipPin<chips::Ad2s1210>,
    ChipPin<chips::Ad2s1210>,
> {
    use chips::ad2s1210::Pin;
    ad2s1210::Pins {
        sample: socket.pin(Pin::Sample),
        a0: socket.pin(Pin::A0),
        a1: socket.pin(Pin::A1),
        reset: socket.pin(Pin::Reset),
    }
}

fn dac_pins(socket: &DacSocket) -> dac::Pins<ChipPin<chips::Dac>, ChipPin<chips::Dac>> {
    use chips::dac::Pin;
    dac::Pins { ldac: socket.pin(Pin::Ldac), clear: socket.pin(Pin::Clear) }
}
