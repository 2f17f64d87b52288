//! `servo-lab link`.

mod experiment;
mod status;

use std::time::{Duration, Instant};

use er_servo::Counts;
use er_servo::link::{BAUD, Command, Status};
use er_servo::parameters::{Parameter, TABLE};
use wire::connection::{Connection, LinkError};
use wire::parameter::{check, find};

use crate::decode::parameter_line;
use crate::interrupt::Interrupt;
use crate::line::{Line, Stream};
use crate::{Error, output};

/// Flags of `link`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    line: LineArgs,
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Place {
    /// Serial port of the drive, as the system names it.
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Address of something that passes bytes on to the drive's port.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
}

#[derive(Debug, clap::Args)]
struct LineArgs {
    #[command(flatten)]
    place: Place,
    /// Baud rate of the serial port, 8N1.
    #[arg(long, default_value_t = BAUD, conflicts_with = "tcp")]
    baud: u32,
}

impl LineArgs {
    fn line(&self) -> Line {
        match (&self.place.port, &self.place.tcp) {
            (Some(port), _) => Line::Serial { port: port.clone(), baud: self.baud },
            (None, address) => Line::Tcp(address.clone().unwrap_or_default()),
        }
    }
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// State, faults with how to clear them, position, commands, counters of the link.
    Status {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Start the drive.
    Enable,
    /// Stop the drive.
    Disable,
    /// Leave the fault state, once its cause is gone.
    Clear,
    /// Send the reference there, and keep the link alive until Ctrl-C or --for-s; then it stays there.
    Reference {
        #[command(flatten)]
        target: Target,
        /// For how long to keep the link alive, s.
        #[arg(long, value_name = "SECONDS", value_parser = seconds)]
        for_s: Option<Duration>,
    },
    /// Leave the reference where it is; ends an experiment.
    Hold,
    /// Run an experiment of the image from where the axis stands.
    #[command(subcommand)]
    Run(experiment::Shape),
    /// Print parameters of the law, as `[controller]` of a machine file has them; without names, all.
    Get {
        /// Names.
        names: Vec<String>,
    },
    /// Set parameters of the law, all or none, until the next reset; `save` keeps them.
    Set {
        /// Names and values.
        #[arg(required = true, value_name = "NAME=VALUE", value_parser = assignment)]
        values: Vec<(String, f32)>,
    },
    /// Make the parameters the image was built with those of the law.
    Defaults,
    /// Make the parameters in flash those of the law.
    Load,
    /// Write the parameters of the law to flash.
    Save,
    /// Start a recording.
    StartRecording {
        /// Number that is told in the recording.
        #[arg(default_value_t = 1)]
        run: u32,
    },
    /// End the recording.
    StopRecording,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Target {
    /// Reference, rad.
    #[arg(long, allow_negative_numbers = true)]
    rad: Option<f64>,
    /// Reference, degrees.
    #[arg(long, allow_negative_numbers = true)]
    deg: Option<f64>,
    /// Reference, resolver counts.
    #[arg(long, allow_negative_numbers = true)]
    counts: Option<i32>,
}

impl Target {
    fn counts(&self) -> Result<i32, Error> {
        let angle_rad = match *self {
            Self { counts: Some(counts), .. } => return Ok(counts),
            Self { rad, deg, .. } => rad.or(deg.map(f64::to_radians)).unwrap_or(f64::NAN),
        };
        let limit_rad = Counts(i32::MAX).to_rad();
        if angle_rad.abs() <= limit_rad {
            Ok(Counts::from_rad(angle_rad).0)
        } else {
            Err(Error::Usage(format!(
                "reference: {angle_rad} rad is not allowed, -{limit_rad:.0} to {limit_rad:.0} is"
            )))
        }
    }
}

/// A time from 0 to a year.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.0..=3.2e7).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "seconds, 0 to 3.2e7, are expected".to_owned())
}

fn assignment(text: &str) -> Result<(String, f32), String> {
    let (name, value) = text.split_once('=').ok_or("NAME=VALUE is expected")?;
    let value = match value.trim() {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| format!("`{number}` is not a number"))?,
    };
    Ok((name.trim().to_owned(), value))
}

/// Carries the action out in a session of its own.
///
/// # Errors
/// No connection, a drive that refuses, flags or values that cannot be.
pub fn run(args: &Args) -> Result<(), Error> {
    args.action.check()?;
    let line = args.line.line();
    let mut drive = Drive { connection: line.connect()?, line };
    match &args.action {
        Action::Status { json } => drive.print_status(*json),
        Action::Enable => drive.tell_until(Command::Enable, "running", |status| status.state == RUNNING),
        Action::Disable => drive.tell_until(Command::Disable, "stopped", |status| status.state != RUNNING),
        Action::Clear => drive.tell_until(Command::ClearFault, "cleared", |status| status.state != FAULT),
        Action::Reference { target, for_s } => drive.reference(target.counts()?, *for_s),
        Action::Hold => drive.tell(Command::Hold),
        Action::Run(shape) => drive.run(shape),
        Action::Get { names } => drive.get(names),
        Action::Set { values } => drive.set(values),
        Action::Defaults => drive.tell(Command::Defaults).and_then(|()| drive.tell(Command::Apply)),
        Action::Load => drive.tell(Command::Load).and_then(|()| drive.tell(Command::Apply)),
        Action::Save => drive.tell(Command::Save),
        Action::StartRecording { run } => drive.tell(Command::StartRecording { run: *run }),
        Action::StopRecording => drive.tell(Command::StopRecording),
    }
}

impl Action {
    /// What can be known to be wrong without a drive.
    fn check(&self) -> Result<(), Error> {
        let outcome = match self {
            Self::Get { names } => names.iter().try_for_each(|name| find(name).map(drop)),
            Self::Set { values } => values.iter().try_for_each(|(name, value)| check(find(name)?.1, *value)),
            Self::Reference { target, .. } => return target.counts().map(drop),
            _ => Ok(()),
        };
        outcome.map_err(|error| Error::Usage(error.to_string()))
    }
}

/// [`Status::state`] of a drive that runs.
const RUNNING: u8 = 2;
/// [`Status::state`] of a drive with a latched fault.
const FAULT: u8 = 3;

/// A request acts in the next tick; after this it has been refused by the law.
const TAKES_EFFECT: Duration = Duration::from_millis(200);
/// Time between two words that keep the link alive; the drive takes 250 ms of silence for a fault.
const BEAT: Duration = Duration::from_millis(50);

struct Drive {
    line: Line,
    connection: Connection<Box<dyn Stream>>,
}

impl Drive {
    fn known<T>(&self, outcome: Result<T, LinkError>) -> Result<T, Error> {
        outcome.map_err(|error| self.line.error(error))
    }

    fn tell(&mut self, command: Command) -> Result<(), Error> {
        let outcome = self.connection.tell(command);
        self.known(outcome)
    }

    fn status(&mut self) -> Result<Status, Error> {
        let outcome = self.connection.status();
        self.known(outcome)
    }

    fn refused(&self, what: &str, status: &Status) -> Error {
        let state = status::state(status).replace('\n', "; ");
        Error::Refused { place: self.line.to_string(), message: format!("{what}: the drive is in state {state}") }
    }

    /// Makes a request, and waits until it shows.
    fn tell_until(&mut self, command: Command, what: &str, shows: impl Fn(&Status) -> bool) -> Result<(), Error> {
        self.tell(command)?;
        let deadline = Instant::now() + TAKES_EFFECT;
        loop {
            let status = self.status()?;
            if shows(&status) {
                return output::print(&format!("{what}\n"));
            }
            if Instant::now() > deadline {
                return Err(self.refused(&format!("not {what}"), &status));
            }
        }
    }

    fn print_status(&mut self, json: bool) -> Result<(), Error> {
        let status = self.status()?;
        output::print(&if json { status::json(&status) } else { status::text(&status) })
    }

    fn reference(&mut self, counts: i32, for_s: Option<Duration>) -> Result<(), Error> {
        let interrupt = Interrupt::watch()?;
        self.tell(Command::Reference { counts })?;
        let start = Instant::now();
        let status = loop {
            let status = self.status()?;
            if status.state != RUNNING {
                return Err(self.refused("the reference is not followed", &status));
            }
            if interrupt.is_raised() || for_s.is_some_and(|for_s| start.elapsed() >= for_s) {
                break status;
            }
            std::thread::sleep(BEAT);
        };
        self.tell(Command::Hold)?;
        let (at, to) = (Counts(status.position).to_rad(), Counts(counts).to_rad());
        output::print(&format!("reference {to:.6} rad, position {at:.6} rad; it stays there\n"))
    }

    fn run(&mut self, shape: &experiment::Shape) -> Result<(), Error> {
        let outcome = self.connection.parameter("period_s");
        let experiment = shape.experiment(self.known(outcome)?)?;
        self.tell(Command::Run(experiment))?;
        output::print(&format!("runs for {} s\n", experiment.duration_s))
    }

    fn get(&mut self, names: &[String]) -> Result<(), Error> {
        let outcome = self.connection.config();
        let config = self.known(outcome)?;
        let is_asked = |parameter: &&Parameter| names.is_empty() || names.iter().any(|name| name == parameter.name);
        let line = |parameter: &Parameter| parameter_line(parameter, &config) + "\n";
        output::print(&TABLE.iter().filter(is_asked).map(line).collect::<String>())
    }

    fn set(&mut self, values: &[(String, f32)]) -> Result<(), Error> {
        let values: Vec<(&str, f32)> = values.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let outcome = self.connection.set_parameters(&values);
        self.known(outcome)
    }
}
