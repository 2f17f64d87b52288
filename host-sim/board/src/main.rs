//! Runs the image on the emulated board: boots, enables, steps, and says what was seen.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use board::bench::{Error, Firmware};
use board::rotor::Rotor;
use board::rtt::Probe;
use board::tcp::{Pace, Port};
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
    /// Instead of a step: the command link on this port of the loopback address, for `servo-lab link --tcp 127.0.0.1:PORT`,
    /// no faster than the clock, until Ctrl-C; 0 takes any port that is free.
    #[arg(long, conflicts_with_all = ["step_rad", "seconds", "rtt"])]
    tcp: Option<u16>,
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

/// Nothing is wrong in it.
fn sound_world(end_ns: u64) -> Result<World, Error> {
    let mut world = World::new(Rotor::paper(0.0)?, VirtualNanos(end_ns));
    for pin in [INTERLOCK, STOP_RELEASED, AMPLIFIER_READY] {
        world.drive_at(VirtualNanos(0), pin, true);
    }
    Ok(world)
}

/// A day of the board, for a client.
const DAY_NS: u64 = 86_400_000_000_000;

fn serve(firmware: &Firmware, port: u16) -> Result<(), Error> {
    let port = Port::open(port, Pace::Clock).map_err(|error| format!("--tcp {port}: {error}"))?;
    println!("the drive is at {}; Ctrl-C ends it", port.address()?);
    let mut world = sound_world(DAY_NS)?;
    world.port = Some(port);
    firmware.run(world).map(|_| ())
}

fn run(arguments: &Arguments) -> Result<(), Error> {
    if !(0.01..=100.0).contains(&arguments.seconds) {
        return Err(format!("--seconds {}: 0.01 to 100 is allowed", arguments.seconds).into());
    }
    let firmware = Firmware::read(&arguments.elf)?;
    if let Some(port) = arguments.tcp {
        return serve(&firmware, port);
    }
    let image = Image::parse(&std::fs::read(&arguments.elf)?)?;
    let end_ns = READY_NS + 100_000_000 + (f64::from(arguments.seconds) * 1e9) as u64;
    let mut world = sound_world(end_ns)?;
    world.probe = Some(Probe::of(&firmware)?);
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
