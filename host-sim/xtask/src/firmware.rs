//! The image, and the emulated board that runs it.

use std::fs;
use std::path::PathBuf;

use crate::root;
use crate::run::{cargo, run};
use crate::toolchain::{TARGET, Toolchain};

/// Flash the image may take, bytes: what was agreed when homing, supervision, controlled stops and the event log came in
/// (64 KiB before).
const FLASH_BUDGET: u64 = 80 * 1024;

/// A built image.
#[derive(Debug)]
pub struct Image {
    /// The ELF file.
    pub elf: PathBuf,
    sections: Vec<Section>,
    /// As `servo-lab link status` names the image that a drive has.
    build: String,
}

#[derive(Debug)]
struct Section {
    name: String,
    address: u64,
    /// In the file.
    offset: usize,
    bytes: u64,
    in_file: bool,
}

/// Builds the release image.
///
/// # Errors
///
/// No compiler, a failed build, an image that is not an ELF file or takes more flash than it may.
pub fn build() -> Result<Image, String> {
    let root = root();
    let target_dir = root.join("target/firmware");
    let toolchain = Toolchain::find(&root)?;
    let mut command = toolchain.cargo(&root, &target_dir, &["build", "--release", "--bin", "er-servo"]);
    // Calls across crates in the tick cost some 100 instructions; not in the manifest, where every host build would pay.
    command.env("CARGO_PROFILE_RELEASE_LTO", "fat");
    // The log's places in the source; on the host, they would make every program of tests ten times the size.
    command.env("CARGO_PROFILE_RELEASE_DEBUG", "line-tables-only");
    run(command)?;
    let elf = target_dir.join(TARGET).join("release/er-servo");
    let image = Image::read(elf)?;
    let flash = image.flash_bytes();
    if flash > FLASH_BUDGET {
        return Err(format!("the image takes {flash} bytes of flash, {FLASH_BUDGET} are allowed"));
    }
    Ok(image)
}

/// Lints the image's own code, which a lint for the host never sees; warnings are errors. In the profile of the image, whose
/// macros and build scripts are built already.
///
/// # Errors
///
/// No compiler, or a lint.
pub fn lint() -> Result<(), String> {
    let root = root();
    let toolchain = Toolchain::find(&root)?;
    let mut command =
        toolchain.cargo(&root, &root.join("target/firmware"), &["clippy", "--release", "--bin", "er-servo"]);
    command.args(["--", "-D", "warnings"]);
    run(command)
}

/// Builds the image and runs it on the emulated board.
///
/// # Errors
///
/// As [`build`], and whatever ends the board.
pub fn board(arguments: &[String]) -> Result<(), String> {
    let image = build()?;
    let mut command =
        cargo(&root().join("host-sim/board"), &["run", "--release", "--ignore-rust-version", "--quiet", "--"]);
    command.arg("--elf").arg(&image.elf).args(arguments);
    run(command)
}

impl Image {
    /// Bytes of flash: everything that is loaded, initial values of RAM included.
    pub fn flash_bytes(&self) -> u64 {
        self.sections.iter().filter(|section| section.in_file).map(|section| section.bytes).sum()
    }

    /// Bytes of RAM taken by statics, the stack not counted.
    pub fn ram_bytes(&self) -> u64 {
        self.sections.iter().filter(|section| section.address >= 0x1000_0000).map(|section| section.bytes).sum()
    }

    /// Says what the image takes.
    pub fn print(&self) {
        println!("{}\nbuild {}", self.elf.display(), self.build);
        for section in &self.sections {
            println!("  {:<14} {:#010x} {:>7} bytes", section.name, section.address, section.bytes);
        }
        println!("flash {} of {FLASH_BUDGET} bytes, static RAM {} bytes", self.flash_bytes(), self.ram_bytes());
    }

    /// The allocated sections, straight from the section headers of a 32-bit little-endian ELF.
    fn read(elf: PathBuf) -> Result<Self, String> {
        let bytes = fs::read(&elf).map_err(|error| format!("{}: {error}", elf.display()))?;
        let sections = sections(&bytes).ok_or_else(|| format!("{}: not a 32-bit ELF file", elf.display()))?;
        let build = build_id(&bytes, &sections).ok_or_else(|| format!("{}: has no build id", elf.display()))?;
        Ok(Self { elf, sections, build })
    }
}

/// The first eight bytes of the linker's hash over the image: behind the head of its note (16 bytes), where memory.x puts it.
fn build_id(elf: &[u8], sections: &[Section]) -> Option<String> {
    let section = sections.iter().find(|section| section.name == ".build_id")?;
    let id = elf.get(section.offset..)?.get(16..24)?;
    Some(id.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn sections(elf: &[u8]) -> Option<Vec<Section>> {
    const ALLOCATED: u32 = 2;
    const NO_BITS: u32 = 8;
    let word = |at: usize| Some(u32::from_le_bytes(elf.get(at..at.checked_add(4)?)?.try_into().ok()?));
    let half = |at: usize| Some(u16::from_le_bytes(elf.get(at..at.checked_add(2)?)?.try_into().ok()?));
    if elf.get(..5)? != b"\x7fELF\x01" {
        return None;
    }
    let (table, size, count, names) = (word(32)? as usize, half(46)? as usize, half(48)?, half(50)? as usize);
    let header = |nth: usize| table + nth * size;
    let names_at = word(header(names) + 16)? as usize;
    let mut found = Vec::new();
    for nth in 0..usize::from(count) {
        let at = header(nth);
        let bytes = word(at + 20)?;
        if word(at + 8)? & ALLOCATED != 0 && bytes > 0 {
            let name = elf.get(names_at + word(at)? as usize..)?.split(|byte| *byte == 0).next()?;
            found.push(Section {
                name: String::from_utf8_lossy(name).into_owned(),
                address: word(at + 12)?.into(),
                offset: word(at + 16)? as usize,
                bytes: bytes.into(),
                in_file: word(at + 4)? != NO_BITS,
            });
        }
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An ELF file with the sections `.build_id` and that of the names.
    fn elf(note: &[u8]) -> Vec<u8> {
        let names = b".build_id\0.shstrtab\0";
        let words = |words: [u32; 10]| words.into_iter().flat_map(u32::to_le_bytes).collect::<Vec<u8>>();
        let table_at = 52 + names.len() + note.len();
        let mut file = vec![0; 52];
        file[..5].copy_from_slice(b"\x7fELF\x01");
        file[32..36].copy_from_slice(&(table_at as u32).to_le_bytes());
        // Size, number and name section of the headers.
        for (at, half) in [(46, 40_u16), (48, 2), (50, 1)] {
            file[at..at + 2].copy_from_slice(&half.to_le_bytes());
        }
        file.extend_from_slice(names);
        file.extend_from_slice(note);
        let note_at = (52 + names.len()) as u32;
        file.extend(words([0, 7, 2, 0x0800_01AC, note_at, note.len() as u32, 0, 0, 4, 0]));
        file.extend(words([10, 3, 0, 0, 52, names.len() as u32, 0, 0, 1, 0]));
        file
    }

    #[test]
    fn an_image_is_named_by_the_first_eight_bytes_of_its_hash() {
        let note: Vec<u8> = (0..36).collect();
        let file = elf(&note);
        let found = sections(&file).unwrap_or_default();
        assert_eq!(build_id(&file, &found).as_deref(), Some("1011121314151617"));
        assert_eq!(build_id(&file, &[]), None);
        assert_eq!(build_id(&file[..60], &found), None);
    }
}
