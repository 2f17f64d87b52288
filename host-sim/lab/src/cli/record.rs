//! `servo-lab record`.

use std::path::PathBuf;
use std::time::Duration;

use wire::log::Image;

use super::Overwrite;
use super::decode::note_parameters;
use super::link::seconds;
use crate::interrupt::Interrupt;
use crate::record::{Ended, Origin, Wanted, record};
use crate::{Error, output};

/// Flags of `record`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// ELF file of the image the drive runs.
    #[arg(long, value_name = "IMAGE")]
    elf: PathBuf,
    #[command(flatten)]
    from: From,
    /// Where the recording goes, .csv; it has this name once it has ended.
    #[arg(long, short, value_name = "FILE", value_parser = csv_name)]
    out: PathBuf,
    /// Number of the run; without one, the next that begins.
    #[arg(long, value_name = "NUMBER")]
    run: Option<u32>,
    /// End after this time, s; without it, when the drive ends the recording, or with Ctrl-C.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    for_s: Option<Duration>,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct From {
    /// Address of an RTT server that passes on channel 0 (OpenOCD `rtt server start`, J-Link, a bridge).
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// The first debug probe that is connected; it reads memory and never halts the core.
    #[cfg(feature = "probe")]
    #[arg(long)]
    probe: bool,
    /// File or pipe with the bytes of RTT channel 0; - is standard input.
    #[arg(value_name = "RTT")]
    log: Option<PathBuf>,
}

fn csv_name(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match file.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("csv") => Ok(file),
        _ => Err("the name must end in .csv, which can grow row by row".to_owned()),
    }
}

impl Args {
    #[cfg(feature = "probe")]
    fn origin(&self, elf: &[u8]) -> Result<Origin, Error> {
        if !self.from.probe {
            return Ok(self.stream());
        }
        let address = Image::rtt_address(elf);
        let rtt_address = address.map_err(|error| Error::input(&self.elf, None, "", error.to_string()))?;
        Ok(Origin::Probe { rtt_address })
    }

    #[cfg(not(feature = "probe"))]
    fn origin(&self, _: &[u8]) -> Result<Origin, Error> {
        Ok(self.stream())
    }

    fn stream(&self) -> Origin {
        match (&self.from.tcp, &self.from.log) {
            (Some(address), _) => Origin::Tcp(address.clone()),
            (None, Some(file)) if file.as_os_str() != "-" => Origin::File(file.clone()),
            _ => Origin::StandardInput,
        }
    }
}

/// Records one run; events and the summary go to standard error.
///
/// # Errors
/// Files that cannot be read or written, nobody at the address, a log of another image, a run that did not begin, a log that
/// broke off.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads(&args.elf);
    files.reads_all(&args.from.log);
    let out = files.writes(&args.out);
    let outputs = files.check()?;
    let unreadable = |message: String| Error::input(&args.elf, None, "", message);
    let elf = std::fs::read(&args.elf).map_err(|error| unreadable(format!("cannot open: {error}")))?;
    let image = Image::parse(&elf).map_err(|error| unreadable(error.to_string()))?;
    let out = outputs.growing(out)?;
    let wanted = Wanted { run: args.run, duration: args.for_s };
    let (summary, ended) = record(&image, &args.origin(&elf)?, &wanted, out, &Interrupt::watch()?)?;
    eprintln!("{summary}");
    note_parameters(&summary.begin.config);
    let reason = match ended {
        Ended::ByDrive => "the drive ended it",
        Ended::Interrupted => "interrupted",
        Ended::Time => "the time was over",
        Ended::EndOfLog => "the log ended before the recording",
        Ended::Broken(error) => {
            eprintln!("wrote {} as far as it came", args.out.display());
            return Err(error);
        }
    };
    output::print(&format!("wrote {}: {} rows, {reason}\n", args.out.display(), summary.ticks.taken))
}
