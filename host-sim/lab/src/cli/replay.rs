//! `servo-lab replay`.

use std::path::PathBuf;

use crate::read::{Machine, Recording};
use crate::replay::replay;
use crate::{Error, output};

/// Flags of `replay`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file whose section `controller` ran; without one, the law's defaults.
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// Recordings, of any format that is read (`help formats`).
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
}

/// Replays every recording and prints one line each.
///
/// # Errors
/// Files that cannot be read, or hold nothing to replay.
pub fn run(args: &Args) -> Result<(), Error> {
    let (machine, config) = match &args.machine {
        None => (None, er_servo::Config::default()),
        Some(file) => {
            let machine = Machine::read(file)?;
            let missing =
                || Error::input(file, None, "controller", "no [controller] section: which law ran is unknown");
            let config = machine.controller.ok_or_else(missing)?;
            (Some(machine), config)
        }
    };
    let mut text = String::new();
    for file in &args.recordings {
        let recording = match &machine {
            Some(machine) => Recording::of(file, machine)?,
            None => Recording::read(file, None)?,
        };
        let result = replay(&recording, &config)?;
        text.extend(recording.notes().iter().map(|note| format!("note: {note}\n")));
        text += &format!("{}: {result}\n", file.display());
    }
    output::print(&text)
}
