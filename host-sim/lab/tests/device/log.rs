//! A log as the image writes it: its strings by their indices in the ELF file, rzCOBS, a zero behind each message.

use std::path::{Path, PathBuf};

use er_servo::{Config, FRAME_SCHEMA, Frame, State, parameters};
use object::{Object, ObjectSection, ObjectSymbol};
use wire::log::{Build, Image};

const BEGIN: &str = "recording run {=u32} schema {=u8} build {=[u8; 8]} tick {=u32} state {=[u8]} parameters {=[u8]}";
const FRAME: &str = "frame {=[u8; 48]}";
const END: &str = "recording ended";
const EVENT: &str = "{=str}";

/// The image `cargo xtask firmware` builds, or the one `ER_SERVO_ELF` names; none, with the reason printed, where it has not
/// been built: it needs the compiler's thumb target.
pub fn elf() -> Option<PathBuf> {
    let built =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/firmware/thumbv7em-none-eabihf/release/er-servo");
    let elf = std::env::var_os("ER_SERVO_ELF").map_or(built, PathBuf::from);
    if !elf.exists() {
        println!("skipped: {} is missing; `cargo xtask firmware` builds it", elf.display());
        return None;
    }
    Some(elf)
}

/// Writes the messages of one image.
#[derive(Debug, Clone)]
pub struct Encoder {
    pub build: Build,
    begin: u16,
    frame: u16,
    end: u16,
    event: u16,
}

impl Encoder {
    pub fn of(elf: &[u8]) -> Self {
        let file = object::File::parse(elf).unwrap();
        let index = |data: &str| {
            let tag = format!("\"data\":\"{data}\"");
            let found = file.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains(&tag)));
            found.unwrap_or_else(|| panic!("the image has no message {data:?}")).address() as u16
        };
        let build = Image::parse(elf).unwrap().build();
        Self { build, begin: index(BEGIN), frame: index(FRAME), end: index(END), event: index(EVENT) }
    }

    pub fn begin(&self, run: u32, tick: u32, state: &State, config: &Config) -> Vec<u8> {
        let values = parameters::TABLE.iter().flat_map(|parameter| (parameter.get)(config).to_le_bytes());
        let mut plain = stamped(self.begin);
        plain.extend(run.to_le_bytes());
        plain.push(FRAME_SCHEMA);
        plain.extend(self.build);
        plain.extend(tick.to_le_bytes());
        plain.extend(slice(&state.encode()));
        plain.extend(slice(&values.collect::<Vec<u8>>()));
        message(&plain)
    }

    pub fn frame(&self, frame: &Frame) -> Vec<u8> {
        message(&[&stamped(self.frame)[..], &frame.encode()].concat())
    }

    pub fn end(&self) -> Vec<u8> {
        message(&stamped(self.end))
    }

    pub fn event(&self, text: &str) -> Vec<u8> {
        message(&[&stamped(self.event)[..], &slice(text.as_bytes())].concat())
    }
}

/// Which message, and when, in microseconds: nobody looks at it.
fn stamped(message: u16) -> Vec<u8> {
    [&message.to_le_bytes()[..], &[0; 4]].concat()
}

/// Bytes with their number before them.
fn slice(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

/// Reverse zero-compressing COBS: behind up to 7 bytes a mask of which were zeros and are left out, or behind a longer run
/// without a zero its length.
pub fn message(plain: &[u8]) -> Vec<u8> {
    let (mut out, mut run, mut zeros) = (Vec::new(), 0_u8, 0_u8);
    for byte in plain {
        let is_zero = *byte == 0;
        if !is_zero {
            out.push(*byte);
        }
        if run < 7 {
            zeros |= u8::from(is_zero) << run;
        }
        run += 1;
        let code = match run {
            1..=7 => (run == 7 && zeros != 0).then_some(zeros),
            _ if is_zero => Some((run - 8) | 0x80),
            _ => (run == 134).then_some(0xff),
        };
        if let Some(code) = code {
            out.push(code);
            (run, zeros) = (0, 0);
        }
    }
    match run {
        0 => {}
        1..=6 => out.push((zeros | 0xff << run) & 0x7f),
        _ => out.push((run - 7) | 0x80),
    }
    out.push(0);
    out
}

/// The ELF file of another build: the same but for its build id.
pub fn other_build(elf: &[u8]) -> Vec<u8> {
    let file = object::File::parse(elf).unwrap();
    let (at, bytes) = file.section_by_name(".build_id").unwrap().file_range().unwrap();
    let mut other = elf.to_vec();
    let last = (at + bytes) as usize;
    // The hash stands behind a header of 16 bytes.
    other[last - (bytes as usize - 16)] ^= 0xff;
    other
}
