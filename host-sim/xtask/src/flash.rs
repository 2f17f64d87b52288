//! The image onto a drive, through a probe: with whatever compiler the image is built by.

use std::process::Command;

use crate::firmware;
use crate::option_bytes::CHIP;
use crate::run::{output, run};

/// Builds the image, writes and verifies it, and shows its events until Ctrl-C; or resets the drive and leaves it.
///
/// # Errors
///
/// As [`firmware::build`]; no probe-rs, no probe, or flash that does not hold what was written.
pub fn flash(watch: bool) -> Result<(), String> {
    if output(Command::new("probe-rs").arg("--version")).is_none() {
        return Err("probe-rs is not installed: https://probe.rs/docs/getting-started/installation".to_owned());
    }
    let image = firmware::build()?;
    image.print();
    let probe_rs = |arguments: &[&str]| {
        let mut command = Command::new("probe-rs");
        command.args(arguments).args(["--chip", CHIP]);
        command
    };
    let mut write = probe_rs(if watch { &["run", "--verify"] } else { &["download", "--verify"] });
    write.arg(&image.elf);
    run(write)?;
    if watch { Ok(()) } else { run(probe_rs(&["reset"])) }
}
