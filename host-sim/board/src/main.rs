//! Runs the image on the emulated board.

use std::path::PathBuf;
use std::process::ExitCode;

use board::bench::{Error, Firmware};
use board::rotor::Rotor;
use board::rtt::Probe;
use board::world::{INTERLOCK, STOP_RELEASED, World};
use rigless::time::VirtualNanos;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("board: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let elf = std::env::args().skip_while(|a| a != "--elf").nth(1).ok_or("--elf IMAGE")?;
    let firmware = Firmware::read(&PathBuf::from(elf))?;
    let mut world = World::new(Rotor::held(0.01), VirtualNanos(200_000_000));
    world.probe = Some(Probe { block: firmware.address("_SEGGER_RTT")?, bytes: Vec::new() });
    world.drive_at(VirtualNanos(0), INTERLOCK, true);
    world.drive_at(VirtualNanos(0), STOP_RELEASED, true);
    let start = std::time::Instant::now();
    let finished = firmware.run(world)?;
    println!("{:?} in {:?}", finished.stop, start.elapsed());
    println!("unmapped {:?}", finished.session.unmapped());
    println!("refused {:?}", finished.session.refused());
    println!("resets {:?}", finished.session.resets());
    println!("samples {} {:?}", finished.driver.samples.len(), finished.driver.samples.last());
    println!("commands {} {:?}", finished.driver.commands.len(), finished.driver.commands.last());
    println!("rtt {}", finished.driver.probe.map_or(0, |p| p.bytes.len()));
    Ok(())
}
