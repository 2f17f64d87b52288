//! Clocks, and what must go on when one fails or the core is halted.

use er_servo::link::Neighbours;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::{self, Rcc};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// The core's clock, Hz.
pub const CORE_HZ: u32 = 168_000_000;
/// Counts a second of the free-running timer.
const MICROSECONDS_HZ: u32 = 1_000_000;
/// APB1 timers run at twice the 42 MHz of their bus.
pub const TIMER_HZ: u32 = 84_000_000;
/// Looks at the random generator, which makes a number in 40 periods of 48 MHz: 140 core cycles.
const RANDOM_LOOKS: u32 = 1000;
/// Numbers to ask for before one must have passed: the first is never used, and two that are the same are a chance of one in 2^32.
const RANDOM_DRAWS: u32 = 3;

/// 0.36 ms of the core's clock, and more of the 16 MHz that it starts with; five cycles of the watchdog's clock at its slowest,
/// 17 kHz, are 0.3 ms.
const WATCHDOG_CROSSING_CYCLES: u32 = 60_000;

/// Gives the watchdog so long from now on, and starts it if it does not run.
pub fn set_watchdog(watchdog: &mut IndependentWatchdog, time_ms: u32) {
    watchdog.start(time_ms.millis());
    // The values take up to five cycles of its clock to reach the counter (RM0090 section 21.4.4), and the HAL reloads before
    // that, with the old ones; one that was just started would count from 4096, which is 33 s.
    cortex_m::asm::delay(WATCHDOG_CROSSING_CYCLES);
    watchdog.feed();
}

/// 168 MHz from the crystal, with the clock security system on: a crystal that fails is a non-maskable interrupt.
pub fn start(registers: pac::RCC) -> Rcc {
    let config = rcc::Config::hse(8.MHz()).sysclk(CORE_HZ.Hz()).pclk1(42.MHz()).pclk2(84.MHz()).require_pll48clk();
    let rcc = registers.freeze(config);
    rcc.cr().modify(|_, w| w.csson().on());
    // The timer of the tick, the free-running one, and the random generator.
    rcc.apb1enr().modify(|_, w| w.tim3en().set_bit().tim5en().set_bit());
    rcc.ahb2enr().modify(|_, w| w.rngen().set_bit());
    rcc
}

/// A core that a debugger halts must not leave torque and field as they are: watchdog and timers go on, whatever a debugger
/// has set before. The debugger may look while the core sleeps.
pub fn go_on_when_halted(debug: &pac::DBGMCU) {
    debug
        .apb1_fz()
        .modify(|_, w| w.dbg_iwdg_stop().clear_bit().dbg_tim3_stop().clear_bit().dbg_tim5_stop().clear_bit());
    debug.cr().modify(|_, w| w.dbg_sleep().set_bit());
}

/// Starts the timer by which a late tick is found: the core's cycle counter stands still while the core is halted, this one
/// does not.
pub fn start_microseconds(timer: &pac::TIM5) {
    timer.psc().write(|w| w.psc().set((TIMER_HZ / MICROSECONDS_HZ - 1) as u16));
    // SAFETY: every value of the register is a period.
    #[allow(unsafe_code)]
    timer.arr().write(|w| unsafe { w.bits(u32::MAX) });
    timer.egr().write(|w| w.ug().set_bit());
    timer.cr1().modify(|_, w| w.cen().set_bit());
}

/// Microseconds since then; wraps after 71 minutes.
pub fn microseconds() -> u32 {
    // SAFETY: reading the counter changes nothing.
    #[allow(unsafe_code)]
    unsafe { &*pac::TIM5::ptr() }.cnt().read().bits()
}

/// The random generator.
#[derive(Default)]
pub struct Random {
    neighbours: Neighbours,
}

impl Random {
    /// A number nobody can guess; if the generator fails, one that is at least not the one before.
    pub fn number(&mut self) -> u32 {
        let passed = (0..RANDOM_DRAWS).find_map(|_| self.neighbours.pass(drawn()?));
        // A linear congruence (Numerical Recipes) of the time: it spreads the few bits that differ.
        passed.unwrap_or_else(|| {
            cortex_m::peripheral::DWT::cycle_count().wrapping_mul(1_664_525).wrapping_add(1_013_904_223)
        })
    }
}

/// What the random generator has, unless it fails.
fn drawn() -> Option<u32> {
    // SAFETY: nobody else uses the random generator.
    #[allow(unsafe_code)]
    let generator = unsafe { &*pac::RNG::ptr() };
    generator.cr().modify(|_, w| w.rngen().set_bit());
    let ready = (0..RANDOM_LOOKS).any(|_| generator.sr().read().drdy().bit_is_set());
    let failed = generator.sr().read().cecs().bit_is_set() || generator.sr().read().secs().bit_is_set();
    (ready && !failed).then(|| generator.dr().read().bits())
}
