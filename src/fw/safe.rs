//! What is left when nothing else works: outputs off by pins, then the watchdog.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use stm32f4xx_hal::pac;

use super::board::{CLEAR_PIN, FAULT_LAMP_PIN, HV_ENABLE_PIN};

/// High voltage disabled, both DAC outputs forced to 0 V, lamp on: one write to one register, so it takes effect whatever
/// else is broken.
pub fn outputs_off() {
    let off = 1 << (16 + HV_ENABLE_PIN) | 1 << (16 + CLEAR_PIN) | 1 << FAULT_LAMP_PIN;
    // SAFETY: a write to BSRR changes only the pins it names, and these may go to their safe level at any time.
    #[allow(unsafe_code)]
    unsafe {
        (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(off));
    }
}

/// Safe outputs, then nothing: the watchdog is no longer fed and restarts the drive, which then reports an abnormal
/// reset. Until then the log can still be read.
pub fn halt() -> ! {
    cortex_m::interrupt::disable();
    outputs_off();
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    outputs_off();
    match info.location() {
        Some(at) => defmt::error!("panic at {=str}:{=u32}", at.file(), at.line()),
        None => defmt::error!("panic"),
    }
    halt()
}

// The handler of an overflowed stack has no stack either: the core then locks up, outputs as they were, until the
// watchdog restarts it. Only hardware could be quicker.
#[allow(unsafe_code)]
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    outputs_off();
    defmt::error!("hard fault, pc {=u32:#010x}, lr {=u32:#010x}", frame.pc(), frame.lr());
    halt()
}
