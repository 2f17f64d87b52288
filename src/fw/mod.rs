//! The image: start-up, and what thread mode does between ticks.
//!
//! | priority | runs | may |
//! |---|---|---|
//! | TIM3 interrupt, highest | [`tick`]: read, one step, write, enqueue | neither log, wait nor allocate |
//! | thread mode | [`log`], [`link`], storage, watchdog | take the tick's data for a few microseconds at a time |
//!
//! A crystal that fails is a non-maskable interrupt, which ends in the safe state ([`safe`]). There is no other interrupt: the link is received by DMA, so that its bytes, however many, cost the tick nothing.

mod board;
mod clock;
mod edges;
mod link;
mod log;
mod pin;
mod rtt;
mod safe;
mod spi;
mod storage;
mod tick;

use cortex_m_rt::entry;

use board::Board;
use er_servo::Params;
use er_servo::events::Restart;
use er_servo::link::Server;
use link::Link;
use log::Log;

/// Top of thread mode's stack. Above it are 16 KiB for handlers; below it nothing but 48 KiB of stack, down to the end of the
/// memory: an overflow of thread mode faults, and the handler of the fault still has a stack.
const THREAD_STACK_TOP: u32 = 0x1000_C000;

#[entry]
fn main() -> ! {
    // SAFETY: the new stack is memory that nothing uses, and nothing returns to what is on the old one, which is left to
    // the handlers from here on.
    #[allow(unsafe_code)]
    unsafe {
        core::arch::asm!(
            "msr psp, {top}",
            "mrs r0, control",
            "orr r0, r0, #2",
            "msr control, r0",
            "isb",
            "bl {thread}",
            "udf #0",
            top = in(reg) THREAD_STACK_TOP,
            thread = sym thread,
            options(noreturn)
        )
    }
}

extern "C" fn thread() -> ! {
    let before = safe::take_note();
    // The peripherals are there exactly once; without them there is nothing to do but to be safe.
    let Some(mut board) = Board::take() else { safe::halt() };
    let mut log = Log::new();
    log.booted(board.reset_faults, before);
    if Params::for_image(&board.config, false).is_err() {
        log::forced();
    }
    if let Err(error) = board.servo.init() {
        log::init_failed(&error);
    }
    board.watchdog.feed();
    tick::start(board.servo, board.edges, board.frames_in, board.offsets, board.reset_faults);
    let server = Server::new(board.config, board.source);
    let restart = before.map_or(Restart::Watchdog, |(_, why)| why.into());
    let mut link = Link::new(board.ring, board.tx, board.storage, server, board.offsets_in, restart);
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
