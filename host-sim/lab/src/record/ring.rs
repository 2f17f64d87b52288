//! The RTT ring of the recordings as a debugger reads it beside the running core: memory is read, and one word written.

/// How the control block begins.
const NAME: &[u8] = b"ER-SERVO FRAMES";
/// Words of its only channel in the control block: address of its buffer, size, write offset, read offset.
const CHANNEL: u64 = 28;
const READ_OFFSET: u64 = 40;

/// Memory of the MCU, reached without its core.
pub(super) trait Memory {
    /// What goes wrong on the way.
    type Error;

    fn words<const N: usize>(&mut self, address: u64) -> Result<[u32; N], Self::Error>;
    fn bytes(&mut self, address: u64, place: &mut [u8]) -> Result<(), Self::Error>;
    fn put_word(&mut self, address: u64, word: u32) -> Result<(), Self::Error>;
}

/// Whether a control block is at an address.
pub(super) fn is_there<M: Memory>(memory: &mut M, block: u64) -> Result<bool, M::Error> {
    let mut name = [0; NAME.len()];
    memory.bytes(block, &mut name)?;
    Ok(name == *NAME)
}

/// Takes what the image has written, up to the end of the ring; what is at its begin comes the next time. Number of bytes.
pub(super) fn take<M: Memory>(memory: &mut M, block: u64, buffer: &mut [u8]) -> Result<usize, M::Error> {
    let [start, size, write, read] = memory.words(block + CHANNEL)?;
    if read >= size || write >= size {
        return Ok(0);
    }
    let end = if write >= read { write } else { size };
    let count = ((end - read) as usize).min(buffer.len());
    if count > 0 {
        memory.bytes(u64::from(start) + u64::from(read), &mut buffer[..count])?;
        memory.put_word(block + READ_OFFSET, (read + count as u32) % size)?;
    }
    Ok(count)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::convert::Infallible;

    const BLOCK: u64 = 0x2000_0000;
    const BUFFER: u32 = 0x2000_0100;

    /// Memory of an image, and every address a debugger has written.
    struct Ram {
        bytes: Vec<u8>,
        written: Vec<u64>,
    }

    impl Ram {
        fn place(&mut self, address: u64, bytes: &[u8]) {
            let at = (address - BLOCK) as usize;
            self.bytes[at..at + bytes.len()].copy_from_slice(bytes);
        }
    }

    impl Memory for Ram {
        type Error = Infallible;

        fn words<const N: usize>(&mut self, address: u64) -> Result<[u32; N], Infallible> {
            let at = (address - BLOCK) as usize;
            Ok(std::array::from_fn(|nth| u32::from_le_bytes(self.bytes[at + 4 * nth..][..4].try_into().unwrap())))
        }

        fn bytes(&mut self, address: u64, place: &mut [u8]) -> Result<(), Infallible> {
            let at = (address - BLOCK) as usize;
            place.copy_from_slice(&self.bytes[at..at + place.len()]);
            Ok(())
        }

        fn put_word(&mut self, address: u64, word: u32) -> Result<(), Infallible> {
            self.written.push(address);
            self.place(address, &word.to_le_bytes());
            Ok(())
        }
    }

    /// A ring of 8 bytes, with the offsets of image and debugger.
    fn ram(write: u32, read: u32) -> Ram {
        let mut ram = Ram { bytes: vec![0; 0x200], written: Vec::new() };
        ram.place(BLOCK, b"ER-SERVO FRAMES\0");
        for (nth, word) in [BUFFER, 8, write, read].into_iter().enumerate() {
            ram.place(BLOCK + CHANNEL + 4 * nth as u64, &word.to_le_bytes());
        }
        ram.place(BUFFER.into(), b"abcdefgh");
        ram
    }

    #[test]
    fn nothing_but_the_read_offset_is_written_so_that_no_core_is_halted() {
        let mut ram = ram(3, 6);
        assert_eq!(is_there(&mut ram, BLOCK), Ok(true));
        assert_eq!(is_there(&mut ram, BLOCK + 0x100), Ok(false));
        let mut buffer = [0; 16];
        let mut all = Vec::new();
        for _ in 0..3 {
            let count = take(&mut ram, BLOCK, &mut buffer).unwrap();
            all.extend_from_slice(&buffer[..count]);
        }
        assert_eq!(all, b"ghabc");
        assert!(ram.written.iter().all(|address| *address == BLOCK + READ_OFFSET), "{:x?}", ram.written);
    }

    #[test]
    fn an_image_that_has_not_started_has_nothing_to_read() {
        let mut buffer = [0; 16];
        let mut blank = Ram { bytes: vec![0xFF; 0x200], written: Vec::new() };
        assert_eq!(take(&mut blank, BLOCK, &mut buffer), Ok(0));
        assert_eq!(take(&mut ram(5, 5), BLOCK, &mut buffer), Ok(0));
        assert!(blank.written.is_empty());
    }
}
