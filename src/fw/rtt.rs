//! RTT: messages that a debugger reads in memory, beside the running core. Events go to one ring, recordings to another.
//!
//! Recordings have a control block of their own, by another name: `probe-rs run` shows every channel of the block it finds, and
//! frames as characters. Not `defmt-rtt`, which has one ring. Not `rtt-target`, which masks interrupts while it writes a message, and
//! waits for the reader once a debugger has set the ring so, as probe-rs does. Here a message is in its ring whole or not at all,
//! and nothing waits.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

use cortex_m::peripheral::SCB;
use cortex_m::peripheral::scb::VectActive;

/// Bytes of a ring: 80 ms of frames. A power of two, so that an index costs a mask and cannot be out of bounds.
const BYTES: usize = 8192;

type Bytes = [AtomicU8; BYTES];

/// A control block with one ring, as debuggers know it.
#[repr(C)]
struct Block {
    id: [u8; 16],
    up_channels: u32,
    down_channels: u32,
    name: &'static [u8; 8],
    bytes: &'static Bytes,
    size: u32,
    /// Where the image writes next.
    write: AtomicU32,
    /// Where the debugger reads next.
    read: AtomicU32,
    /// What a full ring does; a debugger may write here, and nobody looks: messages that do not fit are dropped.
    mode: AtomicU32,
}

static EVENT_BYTES: Bytes = [const { AtomicU8::new(0) }; BYTES];
static FRAME_BYTES: Bytes = [const { AtomicU8::new(0) }; BYTES];

/// Where debuggers look for a log. probe-rs and cargo-embed know its encoding by the name.
// SAFETY: no other symbol of the image has this name.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
static _SEGGER_RTT: Block = Block::new(*b"SEGGER RTT\0\0\0\0\0\0", b"defmt\0\0\0", &EVENT_BYTES);

/// Where `servo-lab` looks for recordings.
// SAFETY: as above.
#[allow(unsafe_code)]
#[unsafe(no_mangle)]
static ER_SERVO_FRAMES: Block = Block::new(*b"ER-SERVO FRAMES\0", b"frames\0\0", &FRAME_BYTES);

impl Block {
    const fn new(id: [u8; 16], name: &'static [u8; 8], bytes: &'static Bytes) -> Self {
        let (write, read, mode) = (AtomicU32::new(0), AtomicU32::new(0), AtomicU32::new(0));
        Self { id, up_channels: 1, down_channels: 0, name, bytes, size: BYTES as u32, write, read, mode }
    }

    /// Puts bytes at an offset, which moves on; false where they do not fit. The debugger sees them with [`Self::show`].
    fn put(&self, at: &mut usize, bytes: &[u8]) -> bool {
        let read = self.read.load(Ordering::Relaxed) as usize;
        if read.wrapping_sub(*at + 1) % BYTES < bytes.len() {
            return false;
        }
        for byte in bytes {
            self.bytes[*at % BYTES].store(*byte, Ordering::Relaxed);
            *at = (*at + 1) % BYTES;
        }
        true
    }

    fn show(&self, at: usize) {
        self.write.store(at as u32, Ordering::Release);
    }
}

/// Whoever writes a message, as [`WRITER`] has it.
const NOBODY: u8 = 0;
const THREAD: u8 = 1;
const HANDLER: u8 = 2;

/// Thread mode, or the handler that panics; of two at once the later is dropped, and a panic is in the memory that survives
/// the reset anyway.
static WRITER: AtomicU8 = AtomicU8::new(NOBODY);
/// Where messages of thread mode go.
static TO_RECORDING: AtomicBool = AtomicBool::new(false);

struct Message {
    encoder: defmt::Encoder,
    block: &'static Block,
    at: usize,
    fits: bool,
}

struct Open(UnsafeCell<Message>);

// SAFETY: only whoever is in WRITER has a reference.
#[allow(unsafe_code)]
unsafe impl Sync for Open {}

static OPEN: Open =
    Open(UnsafeCell::new(Message { encoder: defmt::Encoder::new(), block: &_SEGGER_RTT, at: 0, fits: false }));

/// Sends the messages of `tell` to the recording.
pub fn to_recording(tell: impl FnOnce()) {
    TO_RECORDING.store(true, Ordering::Relaxed);
    tell();
    TO_RECORDING.store(false, Ordering::Relaxed);
}

fn context() -> u8 {
    if SCB::vect_active() == VectActive::ThreadMode { THREAD } else { HANDLER }
}

/// Lets `change` have the message that is open, if the caller has opened it.
fn with_message(
    change: impl FnOnce(&mut defmt::Encoder, &mut dyn FnMut(&[u8])),
) -> Option<(&'static Block, usize, bool)> {
    if WRITER.load(Ordering::Acquire) != context() {
        return None;
    }
    // SAFETY: the caller is in WRITER, so that nobody else comes here, and the reference ends with this function.
    #[allow(unsafe_code)]
    let Message { encoder, block, at, fits } = unsafe { &mut *OPEN.0.get() };
    change(encoder, &mut |bytes| *fits = *fits && block.put(at, bytes));
    Some((*block, *at, *fits))
}

#[defmt::global_logger]
struct Logger;

// SAFETY: a message is opened by one context at a time, and calls of another until its release do nothing.
#[allow(unsafe_code)]
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        let context = context();
        if WRITER.compare_exchange(NOBODY, context, Ordering::Acquire, Ordering::Relaxed).is_err() {
            return;
        }
        let is_recording = context == THREAD && TO_RECORDING.load(Ordering::Relaxed);
        let block = if is_recording { &ER_SERVO_FRAMES } else { &_SEGGER_RTT };
        // SAFETY: as in `with_message`.
        let message = unsafe { &mut *OPEN.0.get() };
        (message.block, message.at, message.fits) = (block, block.write.load(Ordering::Relaxed) as usize, true);
        with_message(|encoder, put| encoder.start_frame(put));
    }

    unsafe fn flush() {}

    unsafe fn release() {
        let Some((block, at, fits)) = with_message(|encoder, put| encoder.end_frame(put)) else { return };
        if fits {
            block.show(at);
        }
        WRITER.store(NOBODY, Ordering::Release);
    }

    unsafe fn write(bytes: &[u8]) {
        with_message(|encoder, put| encoder.write(bytes, put));
    }
}
