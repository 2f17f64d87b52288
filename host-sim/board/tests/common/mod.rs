//! What every test on the emulated board begins with: the release image, and a world in which nothing is wrong.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod flash;

use std::path::{Path, PathBuf};

use board::bench::Firmware;
use board::core::{Hand, Upset};
use board::machine::ServoBoard;
use board::rotor::Rotor;
use board::rtt::Probe;
use board::world::{AMPLIFIER_READY, INTERLOCK, STOP_RELEASED, World};
use er_servo::events::Event;
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::{Answer, Command};
use object::{Object, ObjectSection, ObjectSymbol};
use rigless::emulator::{Finished, Host};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use wire::log::{Entry, Image, Recording, recordings};

pub type Run = Finished<ServoBoard, World>;

/// The image `cargo xtask firmware` builds, or the one `ER_SERVO_ELF` names.
pub fn elf() -> PathBuf {
    let built =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/firmware/thumbv7em-none-eabihf/release/er-servo");
    let elf = std::env::var_os("ER_SERVO_ELF").map_or(built, PathBuf::from);
    assert!(elf.exists(), "{} is missing: run `cargo xtask firmware` first", elf.display());
    elf
}

pub fn firmware() -> Firmware {
    Firmware::read(&elf()).unwrap()
}

pub fn ms(ms: f64) -> VirtualNanos {
    VirtualNanos((ms * 1e6) as u64)
}

/// An enable that needs no link afterwards.
pub const ENABLE: Command = Command::Enable { autonomous: true };

/// An experiment that needs no link meanwhile.
pub fn run_alone(shape: Shape, duration_s: f32) -> Command {
    Command::Run { experiment: Experiment { shape, duration_s }, torque_bound_nm: 0, autonomous: true }
}

/// Interlock closed, stop released, amplifier ready, a probe that reads the log; ends after so many milliseconds.
pub fn world(firmware: &Firmware, end_ms: f64) -> World {
    let mut world = World::new(Rotor::paper(0.0123).unwrap(), ms(end_ms));
    world.probe = Some(Probe::of(firmware).unwrap());
    world.drive_at(ms(0.0), INTERLOCK, true);
    world.drive_at(ms(0.0), STOP_RELEASED, true);
    world.drive_at(ms(0.0), AMPLIFIER_READY, true);
    world
}

/// A function of the image that panics at a place that is handed to it, and text of the image.
#[derive(Debug, Clone, Copy)]
pub struct Panics {
    function: u32,
    file: u32,
}

/// Memory that nothing uses: the lower half of the handlers' stack.
const SCRATCH: u64 = 0x1000_C100;

impl Panics {
    /// Finds them.
    pub fn of(elf: &object::File<'_>) -> Self {
        let function = elf.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains("already_borrowed")));
        let text = elf.section_by_name(".rodata").unwrap();
        let file = text.data().unwrap().windows(4).position(|bytes| bytes == b"src/").unwrap() as u64 + text.address();
        Self { function: function.unwrap().address() as u32, file: file as u32 }
    }

    /// The image panics with its next instruction.
    pub fn now(self, hand: &Hand, host: &mut dyn Host) {
        // A place in a source file: name, length, line, column.
        for (nth, word) in (0..).zip([self.file, 8, 77, 1]) {
            host.write(SCRATCH + 4 * nth, Width::W32, u64::from(word)).unwrap();
        }
        hand.upset(Upset::Jump { to: self.function, r0: SCRATCH as u32 });
    }
}

/// What people read.
pub fn log(run: &Run) -> Vec<Entry> {
    decoded(&run.driver.probe.as_ref().unwrap().events.bytes)
}

/// The last event that was asked for over the link.
pub fn event(run: &Run) -> Option<Event> {
    let answers = run.driver.link.replies.iter().rev().map(|(_, reply)| reply.answer);
    answers.into_iter().find_map(|answer| if let Answer::Event(event) = answer { event } else { None })
}

/// What was recorded over RTT.
pub fn recorded(run: &Run) -> Vec<Recording> {
    recordings(&decoded(&run.driver.probe.as_ref().unwrap().frames.bytes))
}

fn decoded(bytes: &[u8]) -> Vec<Entry> {
    Image::parse(&std::fs::read(elf()).unwrap()).unwrap().decode(bytes).unwrap()
}

pub fn events(log: &[Entry]) -> Vec<String> {
    log.iter().filter_map(|entry| if let Entry::Event(text) = entry { Some(text.clone()) } else { None }).collect()
}
