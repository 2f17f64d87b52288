//! `servo-lab decode`.

use std::path::{Path, PathBuf};

use er_servo::Config;
use wire::log::Recording as Run;

use super::Overwrite;
use crate::decode::{other_parameters, recording, runs};
use crate::{Error, output};

/// Flags of `decode`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// ELF file of the image that wrote the log.
    #[arg(long, value_name = "IMAGE")]
    elf: PathBuf,
    /// Bytes of the recordings' RTT ring.
    #[arg(value_name = "RTT")]
    log: PathBuf,
    /// Which run, where the log holds several.
    #[arg(long, value_name = "NUMBER")]
    run: Option<u32>,
    /// Where the recording goes, `.csv`, `.parquet` or `.mcap`; without it, CSV on standard output.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Decodes one run of the log; the summary goes to standard error.
///
/// # Errors
/// Files that cannot be read, a log of another image, a run that is not there.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads_all([&args.elf, &args.log]);
    let out = args.out.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let (elf, log) = (bytes(&args.elf)?, bytes(&args.log)?);
    let runs = runs(&elf, &log).map_err(|message| Error::input(&args.log, None, "", message))?;
    let run = choose(&runs, args)?;
    let recording = recording(&args.log.display().to_string(), &run.begin, &run.frames);
    match out {
        Some(out) => outputs.recording(out, &recording).and_then(|()| outputs.finish())?,
        None => output::print(&recording.to_csv()?)?,
    }
    eprintln!(
        "run {}: {} ticks, {} lost in {} gaps, {} damaged messages",
        run.begin.run,
        run.frames.len(),
        run.lost(),
        recording.gaps.len(),
        run.damaged
    );
    note_parameters(&run.begin.config);
    Ok(())
}

/// Tells, on standard error, what `replay` cannot know from the recording.
pub(super) fn note_parameters(config: &Config) {
    let others = other_parameters(config);
    if !others.is_empty() {
        eprintln!("note: for `replay --machine`, the parameters in [controller] that are not the defaults:");
        eprint!("{others}");
    }
}

fn choose<'a>(runs: &'a [Run], args: &Args) -> Result<&'a Run, Error> {
    let numbers = || runs.iter().map(|run| run.begin.run.to_string()).collect::<Vec<_>>().join(", ");
    let several =
        |what: &str| Error::input(&args.log, None, "--run", format!("{what}; the log holds runs {}", numbers()));
    match (args.run, runs) {
        (None, [only]) => Ok(only),
        (None, _) => Err(several("which one?")),
        (Some(number), _) => {
            let mut found = runs.iter().filter(|run| run.begin.run == number);
            match (found.next(), found.next()) {
                (Some(run), None) => Ok(run),
                (None, _) => Err(several(&format!("no run {number}"))),
                _ => Err(several(&format!("run {number} is there more than once"))),
            }
        }
    }
}

fn bytes(file: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(file).map_err(|error| Error::input(file, None, "", error.to_string()))
}
