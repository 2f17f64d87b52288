//! One run: an image, a board, a world.

use std::path::Path;

use rigless::emulator::{self, Finished, Start};
use rigless::image::Image;
use rigless::session::Session;
use rigless::symbols::Symbols;
use rigless::time::VirtualNanos;

use crate::machine::ServoBoard;
use crate::world::World;

/// What can go wrong before the image runs, or with the emulator itself; in words.
pub type Error = Box<dyn std::error::Error + Send + Sync>;

/// Where the factory writes the size of the flash (RM0090 section 39.2), and the 2048 KiB of the part that is flashed, an
/// STM32F427VI.
const FLASH_SIZE_ADDRESS: u64 = 0x1FFF_7A22;
const FLASH_SIZE_KIB: u16 = 2048;

/// The image and its symbols.
#[derive(Debug)]
pub struct Firmware {
    image: Vec<Image>,
    symbols: Symbols,
}

impl Firmware {
    /// Reads an ELF file.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or that is none.
    pub fn read(elf: &Path) -> Result<Self, Error> {
        let bytes = std::fs::read(elf).map_err(|error| format!("{}: {error}", elf.display()))?;
        let symbols = Symbols::read(&bytes, |address| address & !1)?;
        let size = FLASH_SIZE_KIB.to_le_bytes().to_vec();
        let factory = Image::new(Path::new("flash size of the part"), size, Some(FLASH_SIZE_ADDRESS))?;
        Ok(Self { image: vec![Image::new(elf, bytes, None)?, factory], symbols })
    }

    /// Address of a symbol.
    ///
    /// # Errors
    ///
    /// A name the file does not have.
    pub fn address(&self, symbol: &str) -> Result<u64, Error> {
        Ok(self.symbols.get(symbol)?)
    }

    /// Runs the image on a new board in `world`, to the world's end.
    ///
    /// # Errors
    ///
    /// What the emulator refuses: an image that does not fit the part.
    pub fn run(&self, world: World) -> Result<Finished<ServoBoard, World>, Error> {
        let session =
            Session::new(Box::new(ServoBoard::new(world.flash.clone(), world.hand.clone())?), 0, VirtualNanos(0))?;
        Ok(emulator::run(session, &Start::new(&self.image), world)?)
    }
}
