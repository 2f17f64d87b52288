//! The control interrupt.

use core::cell::RefCell;

use cortex_m::interrupt::{CriticalSection, Mutex};
use cortex_m::peripheral::DWT;
use er_servo::app::{Orders, Servo};
use er_servo::{Faults, Frame, Request, Timing};
use heapless::spsc::Producer;
use stm32f4xx_hal::pac::{self, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::timer::{CounterHz, Flag};

use super::board::Hardware;

/// Ticks a second.
const TICK_HZ: u32 = 2000;
/// Core cycles from one tick to the next.
const TICK_CYCLES: u32 = 168_000_000 / TICK_HZ;
/// A tick that begins later than this after the one before is an overrun.
const LATE_CYCLES: u32 = TICK_CYCLES + TICK_CYCLES / 4;

/// What the interrupt works on. Thread mode takes it for a few microseconds at a time, with interrupts off.
pub struct Tick {
    servo: Servo<Hardware>,
    timer: CounterHz<pac::TIM2>,
    frames: Producer<'static, Frame>,
    orders: Orders,
    /// Cycle counter at the begin of the last tick; `None` before the first one and after a pause.
    began: Option<u32>,
    worst_cycles: u32,
}

static TICK: Mutex<RefCell<Option<Tick>>> = Mutex::new(RefCell::new(None));

/// Brings the chips up and starts the ticks.
pub fn start(
    mut servo: Servo<Hardware>,
    mut timer: CounterHz<pac::TIM2>,
    frames: Producer<'static, Frame>,
    reset_faults: Faults,
) {
    if let Err(error) = servo.init() {
        super::log::init_failed(&error);
    }
    // 2 kHz divides the timer's clock; a timer that refuses never ticks, and the watchdog says so.
    let _ = timer.start(TICK_HZ.Hz());
    let orders = Orders { reported: reset_faults, ..Orders::default() };
    let tick = Tick { servo, timer, frames, orders, began: None, worst_cycles: 0 };
    cortex_m::interrupt::free(|cs| TICK.borrow(cs).replace(Some(tick)));
    // SAFETY: the data of the handler is in place; no critical section depends on the mask.
    #[allow(unsafe_code)]
    unsafe {
        cortex_m::peripheral::NVIC::unmask(pac::Interrupt::TIM2);
    }
}

/// Lends the tick's data to thread mode; interrupts are off meanwhile, so a few microseconds at most. `None` before
/// [`start`].
pub fn with<T>(act: impl FnOnce(&mut Tick) -> T) -> Option<T> {
    cortex_m::interrupt::free(|cs| with_in(cs, act))
}

fn with_in<T>(cs: &CriticalSection, act: impl FnOnce(&mut Tick) -> T) -> Option<T> {
    TICK.borrow(cs).try_borrow_mut().ok()?.as_mut().map(act)
}

impl Tick {
    /// Acknowledge, read, one step, write, enqueue.
    fn run(&mut self) {
        let began = DWT::cycle_count();
        self.timer.clear_flags(Flag::Update);
        let late = self.began.is_some_and(|before| began.wrapping_sub(before) > LATE_CYCLES);
        self.began = Some(began);
        let mut orders = self.orders;
        if late {
            orders.reported |= Faults::TICK_OVERRUN;
        }
        let mut frame = self.servo.tick(&orders);
        // A request is made once, and a fault found outside the law is reported until the user clears it.
        self.orders.request = Request::None;

        let cycles = DWT::cycle_count().wrapping_sub(began);
        self.worst_cycles = self.worst_cycles.max(cycles);
        frame.timing = Timing { cycles, worst_cycles: self.worst_cycles };
        if self.frames.enqueue(frame).is_err() {
            self.orders.lost = self.orders.lost.saturating_add(1);
        }
    }
}

#[interrupt]
fn TIM2() {
    cortex_m::interrupt::free(|cs| with_in(cs, Tick::run));
}
