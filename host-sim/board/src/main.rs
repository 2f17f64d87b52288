//! Runs the image on the emulated board: boots, enables, steps, and says what was seen.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use board::bench::{Error, Firmware};
use board::rotor::Rotor;
use board::rtt::Probe;
use board::world::{AMPLIFIER_READY, INTERLOCK, STOP_RELEASED, World};
use clap::Parser;
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::Command;
use rigless::time::VirtualNanos;
use wire::log::{Entry, Image, recordings};

/// Runs the flashed image on an emulated STM32F427 with the servo behind its pins.
#[derive(Debug, Parser)]
struct Arguments {
    /// The image's ELF file.
    #[arg(long)]
    elf: PathBuf,
    /// Step of the reference, rad.
    #[arg(long, default_value_t = std::f32::consts::FRAC_PI_6)]
    step_rad: f32,
    /// How long the step lasts, s; between 0.01 and 100.
    #[arg(long, default_value_t = 1.0)]
    seconds: f32,
    /// Where the bytes of the recording go, for `servo-lab decode`.
    #[arg(long)]
    rtt: Option<PathBuf>,
}

/// The chips are up and the drive is ready after this, ns.
const READY_NS: u64 = 100_000_000;

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("board: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Error> {
    if !(0.01..=100.0).contains(&arguments.seconds) {
        return Err(format!("--seconds {}: 0.01 to 100 is allowed", arguments.seconds).into());
    }
    let firmware = Firmware::read(&arguments.elf)?;
    let image = Image::parse(&std::fs::read(&arguments.elf)?)?;
    let end_ns = READY_NS + 100_000_000 + (f64::from(arguments.seconds) * 1e9) as u64;
    let mut world = World::new(Rotor::paper(0.0)?, VirtualNanos(end_ns));
    world.probe = Some(Probe::of(&firmware)?);
    world.drive_at(VirtualNanos(0), INTERLOCK, true);
    world.drive_at(VirtualNanos(0), STOP_RELEASED, true);
    world.drive_at(VirtualNanos(0), AMPLIFIER_READY, true);
    let experiment =
        Experiment { shape: Shape::Step { amplitude_rad: arguments.step_rad }, duration_s: arguments.seconds };
    let commands = [
        Command::StartRecording { run: 1, over_link: false },
        Command::Enable { autonomous: true },
        Command::Run { experiment, torque_bound_nm: 0, autonomous: true },
        Command::Status,
    ];
    for (nth, command) in (0_u64..).zip(commands) {
        world.link.at(VirtualNanos(READY_NS + nth * 10_000_000), command);
    }

    let start = Instant::now();
    let finished = firmware.run(world)?;
    let (took_s, ran_s) = (start.elapsed().as_secs_f64(), end_ns as f64 * 1e-9);
    println!("{ran_s:.2} s in {took_s:.2} s, {:.1} times real time", ran_s / took_s);
    let (events, frames) =
        finished.driver.probe.map(|probe| (probe.events.bytes, probe.frames.bytes)).unwrap_or_default();
    for entry in &image.decode(&events)? {
        if let Entry::Event(text) = entry {
            println!("  {text}");
        }
    }
    for recording in recordings(&image.decode(&frames)?) {
        let cycles = recording.frames.iter().map(|frame| frame.timing.cycles).max().unwrap_or_default();
        println!(
            "recording {}: {} frames, {} lost; most instructions in a tick {cycles}",
            recording.begin.run,
            recording.frames.len(),
            recording.lost()
        );
    }
    println!("angle {:.5} rad, reference {:.5} rad", finished.driver.rotor.angle_rad(), arguments.step_rad);
    if let Some(path) = &arguments.rtt {
        std::fs::write(path, &frames).map_err(|error| format!("{}: {error}", path.display()))?;
        println!("{} bytes of the recording in {}", frames.len(), path.display());
    }
    Ok(())
}
