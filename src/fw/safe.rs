//! What is left when nothing else works: outputs off by pins, a note of what happened, then the watchdog.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::sync::atomic::{Ordering, compiler_fence};

use cortex_m_rt::{ExceptionFrame, exception};
use er_servo::events::Restart;
use stm32f4xx_hal::pac;

use super::board::{CLEAR_PIN, FAULT_LAMP_PIN, HV_ENABLE_PIN};
use super::tick::TICKS_PER_MS;

/// Says that the note is one, and not what the memory held at power-up.
const NOTE: u32 = 0x4E4F_5445;
/// Where the image's strings are; a note of another image may point elsewhere.
const FLASH: core::ops::Range<usize> = 0x0800_0000..0x0810_0000;
/// Longest file name of a panic that is believed.
const LONGEST_NAME: usize = 120;

/// What survives a reset, but no loss of power. Its words are only read and written as volatile: the compiler must not
/// conclude anything from the value that they do not begin with.
struct Survivors(UnsafeCell<MaybeUninit<[u32; 6]>>);

// SAFETY: whole words, each read and written at once, by one core.
#[allow(unsafe_code)]
unsafe impl Sync for Survivors {}

/// Words of [`Survivors`]: [`NOTE`], ticks since the reset, which [`Why`], and three words of it.
const MARK: usize = 0;
const TICKS: usize = 1;
const KIND: usize = 2;
const DETAILS: [usize; 3] = [3, 4, 5];

#[allow(unsafe_code)]
#[unsafe(link_section = ".uninit.survivors")]
static SURVIVORS: Survivors = Survivors(UnsafeCell::new(MaybeUninit::uninit()));

impl Survivors {
    fn place(&self, word: usize) -> *mut u32 {
        self.0.get().cast::<u32>().wrapping_add(word)
    }

    fn get(&self, word: usize) -> u32 {
        // SAFETY: the callers name words that there are, and every content of memory is a word.
        #[allow(unsafe_code)]
        unsafe {
            self.place(word).read_volatile()
        }
    }

    fn set(&self, word: usize, value: u32) {
        // SAFETY: as above.
        #[allow(unsafe_code)]
        unsafe {
            self.place(word).write_volatile(value);
        }
    }
}

/// Why the drive went to its safe state for good.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Why {
    /// Nothing was noted: the watchdog, the reset pin, or power.
    Unknown,
    /// A panic in a file, at a line.
    Panic(&'static str, u32),
    /// A hard fault at an address, called from another.
    HardFault(u32, u32),
    /// The crystal failed, or another non-maskable interrupt.
    ClockFailed,
    /// An interrupt that has no handler.
    Interrupt(u32),
}

impl From<Why> for Restart {
    /// As short as the event log has it.
    fn from(why: Why) -> Self {
        match why {
            Why::Unknown => Self::Watchdog,
            Why::Panic(_, line) => Self::Panic(u16::try_from(line).unwrap_or(u16::MAX)),
            Why::HardFault(..) => Self::HardFault,
            Why::ClockFailed => Self::ClockFailed,
            Why::Interrupt(number) => Self::Interrupt(number as u16),
        }
    }
}

/// What happened before this reset: how long the drive had run, ms, and why it stopped. `None` after power-up.
pub fn take_note() -> Option<(u32, Why)> {
    let [first, second, third] = DETAILS.map(|word| SURVIVORS.get(word));
    let why = match SURVIVORS.get(KIND) {
        1 => name(first, third).map_or(Why::Unknown, |file| Why::Panic(file, second)),
        2 => Why::HardFault(first, second),
        3 => Why::ClockFailed,
        4 => Why::Interrupt(first),
        _ => Why::Unknown,
    };
    let ran_ms = SURVIVORS.get(TICKS) / TICKS_PER_MS;
    let found = (SURVIVORS.get(MARK) == NOTE).then_some((ran_ms, why));
    SURVIVORS.set(TICKS, 0);
    SURVIVORS.set(KIND, 0);
    SURVIVORS.set(MARK, NOTE);
    found
}

/// A string of the image, from the words of a note.
fn name(start: u32, length: u32) -> Option<&'static str> {
    let (start, length) = (start as usize, length as usize);
    if length > LONGEST_NAME || !FLASH.contains(&start) || !FLASH.contains(&(start + length)) {
        return None;
    }
    // SAFETY: flash is there to be read, and nothing writes to the image.
    #[allow(unsafe_code)]
    let bytes = unsafe { core::slice::from_raw_parts(core::ptr::with_exposed_provenance(start), length) };
    core::str::from_utf8(bytes).ok()
}

/// Counts a tick.
pub fn ticked(seq: u32) {
    SURVIVORS.set(TICKS, seq);
}

fn remember(kind: u32, words: [u32; 3]) {
    SURVIVORS.set(KIND, kind);
    for (place, word) in DETAILS.into_iter().zip(words) {
        SURVIVORS.set(place, word);
    }
}

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
    if let Some(at) = info.location() {
        remember(1, [at.file().as_ptr().addr() as u32, at.line(), at.file().len() as u32]);
        defmt::error!("panic at {=str}:{=u32}", at.file(), at.line());
    }
    halt()
}

/// Words of the frame that the core stacks: r0 to r3, r12, lr, pc, xpsr (ARMv7-M reference manual, B1.5.7).
const FRAME_LR: usize = 5;
const FRAME_PC: usize = 6;

// The handler has a stack of its own, so that an overflow of thread mode's ends here and not in a locked-up core.
#[allow(unsafe_code)]
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    outputs_off();
    // First safe, then curious: after an overflow of the stack the frame may lie where there is no memory, and a core that
    // faults again here locks up. Nothing of the frame may be read before, which a reference alone would allow.
    compiler_fence(Ordering::SeqCst);
    remember(2, [0; 3]);
    let [pc, lr] = [FRAME_PC, FRAME_LR].map(|word| {
        // SAFETY: as above: a frame that is not there is not read but faults, with everything done that must be.
        #[allow(unsafe_code)]
        unsafe {
            core::ptr::from_ref(frame).cast::<u32>().add(word).read_volatile()
        }
    });
    remember(2, [pc, lr, 0]);
    halt()
}

// The clock security system has seen the crystal fail; the core runs on from its own oscillator.
#[allow(unsafe_code)]
#[exception]
unsafe fn NonMaskableInt() -> ! {
    outputs_off();
    remember(3, [0; 3]);
    halt()
}

#[allow(unsafe_code)]
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    outputs_off();
    remember(4, [number as u32, 0, 0]);
    halt()
}
