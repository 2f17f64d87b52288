//! A probe on the image's RTT rings: reads what the image has written, and moves the read offsets, or leaves them.

use rigless::emulator::Memory;
use rigless::soc::Width;

use crate::bench::{Error, Firmware};

/// Offsets of up-channel 0 in a control block: two ints after the 16-byte name, then name, buffer, size, write, read.
const BUFFER: u64 = 24 + 4;
const SIZE: u64 = 24 + 8;
const WRITE: u64 = 24 + 12;
const READ: u64 = 24 + 16;

/// The probe.
#[derive(Debug)]
pub struct Probe {
    /// What people read.
    pub events: Ring,
    /// Recordings.
    pub frames: Ring,
}

/// One ring.
#[derive(Debug)]
pub struct Ring {
    /// Address of the control block.
    block: u64,
    /// Everything read so far.
    pub bytes: Vec<u8>,
}

impl Probe {
    /// Finds the rings of an image.
    ///
    /// # Errors
    ///
    /// An ELF file that is none of this image.
    pub fn of(firmware: &Firmware) -> Result<Self, Error> {
        let ring = |symbol| Ok::<_, Error>(Ring { block: firmware.address(symbol)?, bytes: Vec::new() });
        Ok(Self { events: ring("_SEGGER_RTT")?, frames: ring("ER_SERVO_FRAMES")? })
    }

    /// Takes what is there.
    pub fn drain(&mut self, memory: &mut dyn Memory) {
        self.events.drain(memory);
        self.frames.drain(memory);
    }
}

impl Ring {
    /// Takes what is there. Quietly nothing before the image has set its control block up.
    fn drain(&mut self, memory: &mut dyn Memory) {
        let word = |memory: &mut dyn Memory, at: u64| memory.read(self.block + at, Width::W32).ok();
        let (Some(buffer), Some(size), Some(write), Some(mut read)) =
            (word(memory, BUFFER), word(memory, SIZE), word(memory, WRITE), word(memory, READ))
        else {
            return;
        };
        if write >= size || read >= size {
            return;
        }
        while read != write {
            if let Ok(byte) = memory.read(buffer + read, Width::W8) {
                self.bytes.push(byte as u8);
            }
            read = (read + 1) % size;
        }
        // A probe that cannot write the offset back reads the same bytes again; the emulated RAM takes it.
        let _ = memory.write(self.block + READ, Width::W32, read);
    }
}
