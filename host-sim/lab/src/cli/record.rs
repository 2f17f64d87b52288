//! `servo-lab record`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use er_servo::link::BAUD;
use wire::log::Image;

use super::Overwrite;
use super::decode::note_parameters;
use super::link::seconds;
use crate::interrupt::Interrupt;
use crate::line::Line;
use crate::record::{Ended, Origin, Wanted, record, record_over_link};
use crate::{Error, output};

/// Flags of `record`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// ELF file of the image the drive runs, for what comes by RTT; over the command link none is needed.
    #[arg(long, value_name = "IMAGE")]
    elf: Option<PathBuf>,
    #[command(flatten)]
    from: From,
    /// Where the recording goes, .csv; it has this name once it has ended.
    #[arg(long, short, value_name = "FILE", value_parser = csv_name)]
    out: PathBuf,
    /// Number of the run; without one, the next that begins.
    #[arg(long, value_name = "NUMBER")]
    run: Option<u32>,
    /// End after this time, s; without it, when the drive ends the recording, or with Ctrl-C.
    #[arg(long, alias = "for-s", value_name = "SECONDS", value_parser = seconds)]
    duration_s: Option<Duration>,
    #[command(flatten)]
    overwrite: Overwrite,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct From {
    /// Serial port of the drive's command link.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// With --elf an RTT server that passes on recordings (OpenOCD: `rtt setup ADDRESS 24 "ER-SERVO FRAMES"`, ADDRESS that of the
    /// symbol ER_SERVO_FRAMES in the ELF file, then `rtt start`, `rtt server start PORT 0`); without, a tunnel on this machine to
    /// the drive's command link.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
    /// The first debug probe that is connected; it reads memory and never halts the core.
    #[cfg(feature = "probe")]
    #[arg(long, requires = "elf")]
    probe: bool,
    /// File or pipe with the bytes of the recordings' RTT ring; - is standard input.
    #[arg(value_name = "RTT", requires = "elf")]
    log: Option<PathBuf>,
}

pub(super) fn csv_name(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    match file.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("csv") => Ok(file),
        _ => Err("the name must end in .csv, which can grow row by row".to_owned()),
    }
}

impl Args {
    /// The command link; none where the log is read.
    fn line(&self) -> Option<Line> {
        match (&self.from.port, &self.from.tcp, &self.elf) {
            (Some(port), ..) => Some(Line::Serial { port: port.clone(), baud: BAUD }),
            (None, Some(address), None) => Some(Line::Tcp(address.clone())),
            _ => None,
        }
    }

    #[cfg(feature = "probe")]
    fn origin(&self, file: &Path, elf: &[u8]) -> Result<Origin, Error> {
        if !self.from.probe {
            return Ok(self.stream());
        }
        let address = Image::frames_address(elf);
        let address = address.map_err(|error| Error::input(file, None, "", error.to_string()))?;
        Ok(Origin::Probe { address })
    }

    #[cfg(not(feature = "probe"))]
    fn origin(&self, _: &Path, _: &[u8]) -> Result<Origin, Error> {
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
    files.reads_all(&args.elf);
    files.reads_all(&args.from.log);
    let out = files.writes(&args.out);
    let outputs = files.check()?;
    let wanted = Wanted { run: args.run, duration: args.duration_s };
    let (summary, ended) = match (args.line(), &args.elf) {
        (Some(line), _) => record_over_link(&line, &wanted, outputs.growing(out)?, &Interrupt::watch()?)?,
        (None, Some(file)) => {
            let unreadable = |message: String| Error::input(file, None, "", message);
            let elf = std::fs::read(file).map_err(|error| unreadable(format!("cannot open: {error}")))?;
            let image = Image::parse(&elf).map_err(|error| unreadable(error.to_string()))?;
            let origin = args.origin(file, &elf)?;
            record(&image, &origin, &wanted, outputs.growing(out)?, &Interrupt::watch()?)?
        }
        (None, None) => {
            return Err(Error::Usage("--elf: what comes by RTT is read with the image's ELF file".to_owned()));
        }
    };
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
