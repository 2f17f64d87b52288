//! The control interrupt.

use core::cell::RefCell;

use cortex_m::interrupt::Mutex;
use cortex_m::peripheral::{DWT, NVIC};
use er_servo::app::{InitError, Orders, Servo};
use er_servo::link::{Commander, Offset, Pace, SILENCE_S};
use er_servo::motion::MotionLimits;
use er_servo::{Counts, Faults, Frame, Params, State, Supervisor, Timing};
use heapless::spsc::{Consumer, Producer};
use stm32f4xx_hal::pac::{self, interrupt};
use stm32f4xx_hal::spi;

use super::board::{Hardware, QUEUE_FRAMES, QUEUE_OFFSETS};
use super::edges::Edges;
use super::{clock, safe};

/// Ticks a second.
pub const TICK_HZ: u32 = 2000;
/// The same in a millisecond.
pub const TICKS_PER_MS: u32 = TICK_HZ / 1000;
/// A tick that begins earlier or later than this after the one before is an overrun: a quarter of a period either way.
const ON_TIME_US: core::ops::RangeInclusive<u32> = 1_000_000 / TICK_HZ * 3 / 4..=1_000_000 / TICK_HZ * 5 / 4;
/// The link is silent after so many ticks.
const SILENT_TICKS: u32 = (SILENCE_S * TICK_HZ as f32) as u32;

/// Why the chips did not come up.
pub type HardwareError = InitError<spi::Error, spi::Error>;

/// What the interrupt works on. Thread mode takes it for a few microseconds at a time, with interrupts off.
pub struct Tick {
    servo: Servo<Hardware>,
    edges: Edges,
    frames: Producer<'static, Frame, QUEUE_FRAMES>,
    offsets: Consumer<'static, Offset, QUEUE_OFFSETS>,
    /// What thread mode wants of the next tick.
    pub commander: Commander,
    /// Number of the next tick.
    next_seq: u32,
    /// Microseconds at the begin of the last tick; `None` before the first one and after a pause. Not of the cycle counter,
    /// which stands still while a debugger halts the core.
    began: Option<u32>,
    worst_cycles: u32,
}

static TICK: Mutex<RefCell<Option<Tick>>> = Mutex::new(RefCell::new(None));

/// Starts the ticks.
pub fn start(
    servo: Servo<Hardware>,
    mut edges: Edges,
    frames: Producer<'static, Frame, QUEUE_FRAMES>,
    offsets: Consumer<'static, Offset, QUEUE_OFFSETS>,
    reset_faults: Faults,
) {
    edges.start();
    let tick = Tick {
        servo,
        edges,
        frames,
        offsets,
        commander: Commander::new(reset_faults, SILENT_TICKS),
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
    NVIC::mask(pac::Interrupt::TIM3);
    with(|tick| tick.edges.stop());
    let result = act();
    with(|tick| {
        tick.began = None;
        tick.servo.pause();
        tick.edges.start();
    });
    unmask();
    result
}

fn unmask() {
    // The timer has run on meanwhile: what it has asked for since is no tick.
    NVIC::unpend(pac::Interrupt::TIM3);
    // SAFETY: the data of the handler is in place; no critical section depends on the mask.
    #[allow(unsafe_code)]
    unsafe {
        NVIC::unmask(pac::Interrupt::TIM3);
    }
}

impl Tick {
    /// Sends the reference there.
    pub fn follow(&mut self, target: Counts, pace: &Pace, torque_bound_nm: u8) {
        self.commander.follow(target, self.servo.params().motion(), pace, torque_bound_nm);
    }

    /// What bounds a reference.
    pub fn motion(&self) -> MotionLimits {
        *self.servo.params().motion()
    }

    /// Forgets the offsets of an experiment before.
    pub fn forget_offsets(&mut self) {
        while self.offsets.dequeue().is_some() {}
    }

    /// Replaces the parameters; refused while running.
    pub fn set_params(&mut self, params: Params) -> Result<(), Supervisor> {
        self.servo.set_params(params)
    }

    /// State of the law, and the number of the tick that will start from it.
    pub fn now(&self) -> (State, u32) {
        (*self.servo.state(), self.next_seq)
    }

    /// Brings the chips up; 45 ms, so only while [`paused`].
    pub fn init(&mut self) -> Result<(), HardwareError> {
        self.servo.init()
    }

    /// Acknowledge, sample, read, one step, write, enqueue.
    fn run(&mut self) {
        let began = DWT::cycle_count();
        let now_us = clock::microseconds();
        self.edges.begin();
        let late = self.began.is_some_and(|before| !ON_TIME_US.contains(&now_us.wrapping_sub(before)));
        self.began = Some(now_us);
        self.servo.sample();

        let orders = self.orders(late);
        let mut frame = self.servo.tick(&orders);
        self.next_seq = frame.seq.wrapping_add(1);
        safe::ticked(self.next_seq);

        let cycles = DWT::cycle_count().wrapping_sub(began);
        self.worst_cycles = self.worst_cycles.max(cycles);
        frame.timing = Timing { cycles, worst_cycles: self.worst_cycles };
        if self.frames.enqueue(frame).is_err() {
            self.commander.lost_frame();
        }
    }

    /// What this tick is told.
    fn orders(&mut self, late: bool) -> Orders {
        // Without a value thread mode is more than 32 ms late: the reference waits for it.
        let Self { commander, servo, offsets, .. } = self;
        let mut orders = commander.orders(servo.state(), servo.params().motion(), || offsets.dequeue());
        if late {
            orders.reported |= Faults::TICK_OVERRUN;
        }
        orders
    }
}

#[interrupt]
fn TIM3() {
    with(Tick::run);
}
