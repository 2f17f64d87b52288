//! The timer of the tick, TIM3: it raises the interrupt and makes the edges that the loop's delay lies between.
//!
//! ```text
//! count     0                       LOAD                      RISE         TOP
//! SAMPLE    falls, the interrupt    .                         rises
//! LDAC      .  high while written   falls, if a pair is ready
//! ```
//!
//! From SAMPLE to the outputs it is [`SAMPLE_TO_OUTPUT_NS`] in every tick, however late the interrupt came and however long it
//! took. LDAC falls at its count only in a tick that has armed it, which a tick does once it has written both commands, and is
//! high whenever one is written: half a pair never gets to the outputs. A tick that arms too late lets LDAC fall at once.
//!
//! The safe state waits for none of this. A fault's zeros are loaded as soon as they are written, and CLR (a pin of its own,
//! [`super::safe`]) forces the outputs to 0 V and holds them there, whatever LDAC does.

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};
use er_servo::SAMPLE_TO_OUTPUT_NS;
use er_servo::drivers::dac::Load;
use stm32f4xx_hal::gpio::{Alternate, PB0, PC6};
use stm32f4xx_hal::pac;

use super::clock::TIMER_HZ;
use super::tick::TICK_HZ;

/// Counts of a tick, less one.
const TOP: u16 = (TIMER_HZ / TICK_HZ - 1) as u16;
/// LDAC falls.
const LOAD: u16 = counts(SAMPLE_TO_OUTPUT_NS) as u16;
/// SAMPLE rises: when every tick that is not an overrun has read, and long before it falls again.
const RISE: u16 = TOP / 2;
/// Number of the alternate function with which both pins are outputs of TIM3 (data sheet, table 12).
const TIM3_FUNCTION: u8 = 2;
/// PC6, as a bit of the port's registers.
const LDAC_BIT: u32 = 1 << 6;

/// Counts of a time; rounded up, so that a wait is never too short.
const fn counts(time_ns: u32) -> u32 {
    // 84 counts a microsecond.
    (time_ns * (TIMER_HZ / 1_000_000)).div_ceil(1000)
}

/// The timer, and with it when there are ticks.
pub struct Edges {
    timer: pac::TIM3,
}

impl Edges {
    /// Counting, without ticks yet, SAMPLE and LDAC high. Its clock must be on, and both pins still be no outputs.
    pub fn new(timer: pac::TIM3) -> Self {
        timer.ccmr1_output().write(|w| w.oc1m().force_active());
        timer.ccmr2_output().write(|w| w.oc3m().force_active());
        let mut edges = Self { timer };
        edges.set_up();
        let timer = &edges.timer;
        timer.egr().write(|w| w.ug().set_bit());
        timer.dier().write(|w| w.uie().set_bit());
        timer.cr1().write(|w| w.cen().set_bit());
        edges.acknowledge();
        edges
    }

    /// Writes the counts of the edges, again in every tick: one that was upset lasts no longer than that.
    fn set_up(&mut self) {
        let timer = &self.timer;
        timer.arr().write(|w| w.arr().set(TOP));
        timer.ccr1().write(|w| w.ccr().set(LOAD));
        timer.ccr3().write(|w| w.ccr().set(RISE));
        timer.ccer().write(|w| w.cc1e().set_bit().cc3e().set_bit());
    }

    /// SAMPLE falls by itself from now on, for the first time half a tick from now, with the tick's interrupt.
    pub fn start(&mut self) {
        self.timer.cnt().write(|w| w.cnt().set(RISE));
        self.timer.ccmr2_output().write(|w| w.oc3m().pwm_mode2());
        self.acknowledge();
    }

    /// SAMPLE is the driver's, to bring the chip up, and high.
    pub fn stop(&mut self) {
        self.timer.ccmr2_output().write(|w| w.oc3m().force_active());
    }

    /// A tick begins.
    pub fn begin(&mut self) {
        self.acknowledge();
        self.set_up();
    }

    fn acknowledge(&mut self) {
        // SAFETY: zeros clear flags, of which nobody reads another.
        #[allow(unsafe_code)]
        self.timer.sr().write(|w| unsafe { w.bits(0) });
    }
}

fn timer() -> &'static pac::tim3::RegisterBlock {
    // SAFETY: the pins' own fields of it are theirs alone, and reading the counter changes nothing.
    #[allow(unsafe_code)]
    unsafe {
        &*pac::TIM3::ptr()
    }
}

/// Waits until so many nanoseconds after SAMPLE fell in this tick; no longer than that, whenever it is asked.
pub fn wait_since_sample(wait_ns: u32) {
    let until = counts(wait_ns);
    while u32::from(timer().cnt().read().cnt().bits()) < until {}
}

/// SAMPLE, PB0. While ticks run it follows the timer and nothing else; while they do not, the driver.
pub struct Sample {
    _pin: PB0<Alternate<TIM3_FUNCTION>>,
}

impl Sample {
    /// The pin.
    pub fn new(pin: PB0<Alternate<TIM3_FUNCTION>>) -> Self {
        Self { _pin: pin }
    }

    fn is_timed() -> bool {
        timer().ccmr2_output().read().oc3m().is_pwm_mode2()
    }
}

impl ErrorType for Sample {
    type Error = Infallible;
}

impl OutputPin for Sample {
    fn set_low(&mut self) -> Result<(), Infallible> {
        if !Self::is_timed() {
            timer().ccmr2_output().write(|w| w.oc3m().force_inactive());
        }
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        if !Self::is_timed() {
            timer().ccmr2_output().write(|w| w.oc3m().force_active());
        }
        Ok(())
    }
}

/// LDAC, PC6.
pub struct Ldac {
    _pin: PC6<Alternate<TIM3_FUNCTION>>,
}

impl Ldac {
    /// The pin.
    pub fn new(pin: PC6<Alternate<TIM3_FUNCTION>>) -> Self {
        Self { _pin: pin }
    }
}

impl Load for Ldac {
    type Error = Infallible;

    fn loaded(&mut self) -> Result<bool, Infallible> {
        // The pin itself, and not what the timer was told: a timer that lost its settings would otherwise go unseen.
        // SAFETY: reading the levels of a port changes nothing.
        #[allow(unsafe_code)]
        let levels = unsafe { &*pac::GPIOC::ptr() }.idr().read().bits();
        Ok(levels & LDAC_BIT == 0)
    }

    fn hold(&mut self) -> Result<(), Infallible> {
        timer().ccmr1_output().write(|w| w.oc1m().force_active());
        Ok(())
    }

    fn load(&mut self) -> Result<(), Infallible> {
        timer().ccmr1_output().write(|w| w.oc1m().force_inactive());
        Ok(())
    }

    fn load_on_time(&mut self) -> Result<bool, Infallible> {
        timer().ccmr1_output().write(|w| w.oc1m().inactive_on_match());
        // The pin keeps its level until the count comes; read after arming, so that no count is between the two.
        let in_time = timer().cnt().read().cnt().bits() < LOAD;
        if !in_time {
            self.load()?;
        }
        Ok(in_time)
    }
}
