//! The image: start-up, and what thread mode does between ticks.
//!
//! | priority | runs | may |
//! |---|---|---|
//! | TIM2 interrupt, highest | [`tick`]: read, one step, write, enqueue | neither log, wait nor allocate |
//! | thread mode | [`log`], [`link`], storage, watchdog | take the tick's data for a few microseconds at a time |
//!
//! There is no other interrupt: the link is received by DMA, so that its bytes, however many, cost the tick nothing.

mod board;
mod log;
mod safe;
mod tick;

use cortex_m_rt::entry;
use defmt_rtt as _;

use board::Board;

#[entry]
fn main() -> ! {
    // The peripherals are there exactly once; without them there is nothing to do but to be safe.
    let Some(Board { servo, timer, watchdog, frames_in, mut frames, reset_faults, .. }) = Board::take() else {
        safe::halt()
    };
    let mut watchdog = watchdog;
    tick::start(servo, timer, frames_in, reset_faults);
    let mut log = log::Log::new();
    log.booted(reset_faults);
    loop {
        let mut ticked = false;
        while let Some(frame) = frames.dequeue() {
            ticked = true;
            log.frame(&frame);
        }
        if ticked {
            watchdog.feed();
        }
        cortex_m::asm::wfi();
    }
}
