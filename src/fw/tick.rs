//! The control interrupt.

use core::cell::RefCell;

use cortex_m::interrupt::Mutex;
use cortex_m::peripheral::{DWT, NVIC};
use er_servo::app::{InitError, Orders, Servo};
use er_servo::link::SILENCE_S;
use er_servo::{Counts, Faults, Frame, Params, Request, State, Supervisor, Timing};
use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::pac::{self, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::spi;
use stm32f4xx_hal::timer::{CounterHz, Flag};

use super::board::{Hardware, QUEUE_FRAMES, QUEUE_OFFSETS};

/// Ticks a second.
const TICK_HZ: u32 = 2000;
/// Core cycles from one tick to the next.
const TICK_CYCLES: u32 = 168_000_000 / TICK_HZ;
/// A tick that begins later than this after the one before is an overrun.
const LATE_CYCLES: u32 = TICK_CYCLES + TICK_CYCLES / 4;
/// The link is silent after so many ticks.
const SILENT_TICKS: u32 = (SILENCE_S * TICK_HZ as f32) as u32;

/// Why the chips did not come up.
pub type HardwareError = InitError<spi::Error, spi::Error>;

/// Where the reference comes from.
#[derive(Debug)]
enum Source {
    /// It stays where it is.
    Held,
    /// The link, whose silence is then a fault.
    Link,
    /// An experiment, counted from where the reference stood.
    Experiment { base: Counts },
}

/// What thread mode computes ahead of the tick: sixteen sines do not belong into an interrupt.
#[derive(Debug, Clone, Copy)]
pub enum Offset {
    /// From where the reference stood, counts.
    Counts(Counts),
    /// The experiment is over; the reference stays.
    End,
}

/// What the interrupt works on. Thread mode takes it for a few microseconds at a time, with interrupts off.
pub struct Tick {
    servo: Servo<Hardware>,
    timer: CounterHz<pac::TIM2>,
    frames: Producer<'static, Frame, QUEUE_FRAMES>,
    offsets: Consumer<'static, Offset, QUEUE_OFFSETS>,
    orders: Orders,
    source: Source,
    /// Ticks since the link was heard of.
    silent_ticks: u32,
    /// Number of the next tick.
    next_seq: u32,
    /// Cycle counter at the begin of the last tick; `None` before the first one and after a pause.
    began: Option<u32>,
    worst_cycles: u32,
}

static TICK: Mutex<RefCell<Option<Tick>>> = Mutex::new(RefCell::new(None));

/// Starts the ticks.
pub fn start(
    servo: Servo<Hardware>,
    mut timer: CounterHz<pac::TIM2>,
    frames: Producer<'static, Frame, QUEUE_FRAMES>,
    offsets: Consumer<'static, Offset, QUEUE_OFFSETS>,
    reset_faults: Faults,
) {
    // 2 kHz divides the timer's clock; a timer that refuses never ticks, and the watchdog says so.
    let _ = timer.start(TICK_HZ.Hz());
    let tick = Tick {
        servo,
        timer,
        frames,
        offsets,
        orders: Orders { reported: reset_faults, ..Orders::default() },
        source: Source::Held,
        silent_ticks: SILENT_TICKS,
        next_seq: 0,
        began: None,
        worst_cycles: 0,
    };
    cortex_m::interrupt::free(|cs| TICK.borrow(cs).replace(Some(tick)));
    unmask();
}

/// Lends the tick's data to thread mode; interrupts are off meanwhile, so a few microseconds at most. `None` before
/// [`start`].
pub fn with<T>(act: impl FnOnce(&mut Tick) -> T) -> Option<T> {
    cortex_m::interrupt::free(|cs| TICK.borrow(cs).try_borrow_mut().ok()?.as_mut().map(act))
}

/// Runs `act` with no tick before it has ended, however long it takes; the outputs stay as they are, so only in a safe
/// state.
pub fn paused<T>(act: impl FnOnce() -> T) -> T {
    NVIC::mask(pac::Interrupt::TIM2);
    let result = act();
    with(|tick| {
        tick.began = None;
        tick.timer.clear_flags(Flag::Update);
    });
    NVIC::unpend(pac::Interrupt::TIM2);
    unmask();
    result
}

fn unmask() {
    // SAFETY: the data of the handler is in place; no critical section depends on the mask.
    #[allow(unsafe_code)]
    unsafe {
        NVIC::unmask(pac::Interrupt::TIM2);
    }
}

impl Tick {
    /// Something valid was heard on the link.
    pub fn heard(&mut self) {
        self.silent_ticks = 0;
    }

    /// Makes a request in the next tick. Clearing also forgets what the last reset was: the user has been told.
    pub fn request(&mut self, request: Request) {
        if request == Request::ClearFault {
            self.orders.reported = Faults::empty();
        }
        self.orders.request = request;
    }

    /// The reference, from the link.
    pub fn follow(&mut self, reference: Counts) {
        self.source = Source::Link;
        self.orders.reference = reference;
    }

    /// Forgets the offsets of an experiment before; the reference stays.
    pub fn end_experiment(&mut self) {
        self.source = Source::Held;
        while self.offsets.dequeue().is_some() {}
    }

    /// Runs the experiment whose first offsets are in the queue, from where the reference stands.
    pub fn experiment(&mut self) {
        self.source = Source::Experiment { base: self.orders.reference };
    }

    /// Replaces the parameters; refused while running.
    pub fn set_params(&mut self, params: Params) -> Result<(), Supervisor> {
        self.servo.set_params(params)
    }

    /// State of the law, the number of the tick that will start from it, and the reference.
    pub fn now(&self) -> (State, u32, Counts) {
        (*self.servo.state(), self.next_seq, self.orders.reference)
    }

    /// Brings the chips up; 45 ms, so only while [`paused`].
    pub fn init(&mut self) -> Result<(), HardwareError> {
        self.servo.init()
    }

    /// Acknowledge, read, one step, write, enqueue.
    fn run(&mut self) {
        let began = DWT::cycle_count();
        self.timer.clear_flags(Flag::Update);
        let late = self.began.is_some_and(|before| began.wrapping_sub(before) > LATE_CYCLES);
        self.began = Some(began);

        let orders = self.orders(late);
        let mut frame = self.servo.tick(&orders);
        self.orders.request = Request::None;
        self.next_seq = frame.seq.wrapping_add(1);

        let cycles = DWT::cycle_count().wrapping_sub(began);
        self.worst_cycles = self.worst_cycles.max(cycles);
        frame.timing = Timing { cycles, worst_cycles: self.worst_cycles };
        if self.frames.enqueue(frame).is_err() {
            self.orders.lost = self.orders.lost.saturating_add(1);
        }
    }

    /// What this tick is told.
    fn orders(&mut self, late: bool) -> Orders {
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        self.orders.link_alive = self.silent_ticks < SILENT_TICKS;
        let state = self.servo.state();
        if state.supervisor() != Supervisor::Running {
            // The axis starts where it stands, whatever was asked of it before.
            self.source = Source::Held;
            self.orders.reference = state.position();
        }
        if let Source::Experiment { base } = self.source {
            match self.offsets.dequeue() {
                Some(Offset::Counts(offset)) => self.orders.reference = Counts(base.0.saturating_add(offset.0)),
                Some(Offset::End) => self.source = Source::Held,
                // Thread mode is more than 32 ms late: the reference waits for it.
                None => {}
            }
        }
        self.orders.reference_from_link = matches!(self.source, Source::Link);
        let mut orders = self.orders;
        if late {
            orders.reported |= Faults::TICK_OVERRUN;
        }
        orders
    }
}

#[interrupt]
fn TIM2() {
    with(Tick::run);
}
