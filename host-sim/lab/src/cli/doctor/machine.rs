//! This computer: compiler, target, probe, serial ports and the right to open them.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Check, State};

/// What the image is compiled for.
const TARGET: &str = "thumbv7em-none-eabihf";
/// Makers of debug probes by their USB number: ST, SEGGER, Arm's DAPLink, Raspberry Pi.
const PROBES: &[(&str, &str)] =
    &[("0483", "ST-Link"), ("1366", "J-Link"), ("0d28", "CMSIS-DAP"), ("2e8a", "Debug Probe")];

pub(super) fn checks() -> Vec<Check> {
    let mut checks = vec![compiler(), target(), tool()];
    checks.push(probe());
    checks.push(serial());
    checks
}

/// The first line a program prints.
fn says(program: &str, words: &[&str]) -> Option<String> {
    let output = Command::new(program).args(words).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn compiler() -> Check {
    match says("rustc", &["--version"]) {
        Some(version) => Check::new(State::Good, "compiler", version),
        None => Check::new(State::Note, "compiler", "no rustc; needed to build the image only: see rustup.rs"),
    }
}

fn target() -> Check {
    let libraries = says("rustc", &["--print", "target-libdir", "--target", TARGET]).map(PathBuf::from);
    if libraries.is_some_and(|folder| folder.is_dir()) {
        return Check::new(State::Good, "target", TARGET);
    }
    let message = format!("{TARGET} is not installed; needed to build the image only: rustup target add {TARGET}");
    Check::new(State::Note, "target", message)
}

fn tool() -> Check {
    match says("probe-rs", &["--version"]) {
        Some(version) => Check::new(State::Good, "probe-rs", version.lines().next().unwrap_or_default()),
        None => Check::new(State::Note, "probe-rs", "not installed; flashes the image: cargo install probe-rs-tools"),
    }
}

/// Debug probes by what Linux lists of USB; elsewhere probe-rs tells.
fn probe() -> Check {
    let Ok(devices) = std::fs::read_dir("/sys/bus/usb/devices") else {
        return Check::new(State::Note, "probe", "USB is not listed here; `probe-rs list` shows debug probes");
    };
    let maker = |device: &Path| std::fs::read_to_string(device.join("idVendor")).ok();
    let number = |device: &Path, file: &str| {
        std::fs::read_to_string(device.join(file)).ok().and_then(|text| text.trim().parse::<u32>().ok())
    };
    for device in devices.flatten().map(|entry| entry.path()) {
        let Some((_, name)) = maker(&device).and_then(|id| PROBES.iter().find(|(maker, _)| *maker == id.trim())) else {
            continue;
        };
        let (Some(bus), Some(place)) = (number(&device, "busnum"), number(&device, "devnum")) else { continue };
        let node = PathBuf::from(format!("/dev/bus/usb/{bus:03}/{place:03}"));
        return match std::fs::OpenOptions::new().read(true).write(true).open(&node) {
            Ok(_) => Check::new(State::Good, "probe", format!("{name} at {}", node.display())),
            Err(error) => {
                let message =
                    format!("{name} at {} cannot be opened ({error}): see probe.rs/docs, udev rules", node.display());
                Check::new(State::Bad, "probe", message)
            }
        };
    }
    Check::new(State::Note, "probe", "none is connected")
}

/// Serial ports that a drive may be on, and whether they may be opened.
fn serial() -> Check {
    let names = std::fs::read_dir("/dev").into_iter().flatten().flatten().map(|entry| entry.path());
    let is_port = |file: &PathBuf| {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        ["ttyUSB", "ttyACM", "cu.usb"].iter().any(|kind| name.starts_with(kind))
    };
    let mut ports: Vec<PathBuf> = names.filter(is_port).collect();
    ports.sort();
    if ports.is_empty() {
        return Check::new(State::Note, "serial", "no USB serial port is connected");
    }
    for port in &ports {
        if let Err(error) = std::fs::OpenOptions::new().read(true).write(true).open(port) {
            let message = format!(
                "{} cannot be opened ({error}); where that is a matter of rights: sudo usermod -aG dialout $USER, then log in anew",
                port.display()
            );
            return Check::new(State::Bad, "serial", message);
        }
    }
    let ports: Vec<String> = ports.iter().map(|port| port.display().to_string()).collect();
    Check::new(State::Good, "serial", ports.join(", "))
}
