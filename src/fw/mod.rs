//! The image: start-up, and what thread mode does between ticks.
//!
//! | priority | runs | may |
//! |---|---|---|
//! | TIM2 interrupt, highest | [`tick`]: read, one step, write, enqueue | neither log, wait nor allocate |
//! | thread mode | [`log`], [`link`], storage, watchdog | take the tick's data for a few microseconds at a time |
//!
//! There is no other interrupt: the link is received by DMA, so that its bytes, however many, cost the tick nothing.

mod board;
mod link;
mod log;
mod pin;
mod safe;
mod spi;
mod storage;
mod tick;

use cortex_m_rt::entry;
use defmt_rtt as _;

use board::Board;
use link::Link;
use log::Log;

#[entry]
fn main() -> ! {
    // The peripherals are there exactly once; without them there is nothing to do but to be safe.
    let Some(mut board) = Board::take() else { safe::halt() };
    let mut log = Log::new();
    log.booted(board.reset_faults);
    if let Err(error) = board.servo.init() {
        log::init_failed(&error);
    }
    board.watchdog.feed();
    tick::start(board.servo, board.timer, board.frames_in, board.offsets, board.reset_faults);
    let mut link = Link::new(board.ring, board.tx, board.storage, board.config, board.offsets_in);
    loop {
        let mut ticked = false;
        while let Some(frame) = board.frames.dequeue() {
            ticked = true;
            log.frame(&frame);
            link.frame(&frame);
        }
        link.poll(&mut log, &mut board.watchdog);
        // Only while ticks advance: a tick that hangs restarts the drive, as does a thread that hangs.
        if ticked {
            board.watchdog.feed();
        }
        if !link.sending() {
            cortex_m::asm::wfi();
        }
    }
}
