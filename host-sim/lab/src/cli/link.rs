//! `servo-lab link`.

mod drive;
mod experiment;
pub(super) mod identify;
mod set;
mod status;

use std::path::PathBuf;
use std::time::Duration;

use er_servo::Counts;
use er_servo::link::{self, BAUD, Command, Pace};
use wire::connection::{Connection, Persistence};
use wire::parameter::find;

use super::examples::link as examples;
use super::record::csv_name;
use crate::Error;
use crate::line::{Line, Stream};
use crate::output::{Files, Growing};

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
    /// Address on this machine of a tunnel that passes bytes on to the drive's port.
    #[arg(long, value_name = "HOST:PORT")]
    tcp: Option<String>,
}

#[derive(Debug, clap::Args)]
pub(super) struct LineArgs {
    #[command(flatten)]
    place: Place,
    /// Baud rate of the serial port, 8N1.
    #[arg(long, default_value_t = BAUD, conflicts_with = "tcp")]
    baud: u32,
    /// Time to wait for an answer before the packet is sent again, up to 6 times. More for a simulated drive that is slower than
    /// the clock; one that runs takes 0.25 s without a word for a lost link.
    #[arg(long, value_name = "S", default_value = "0.1", value_parser = patience)]
    patience_s: Duration,
}

/// Less than the turnaround of a USB adapter finds no drive; more than a minute, six times, is a hung one.
fn patience(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if (0.02..=60.0).contains(&seconds) {
        Ok(Duration::from_secs_f64(seconds))
    } else {
        Err("0.02 to 60 is allowed".to_owned())
    }
}

impl LineArgs {
    pub(super) fn persistence(&self) -> Persistence {
        Persistence { patience: self.patience_s, ..Persistence::default() }
    }

    pub(super) fn line(&self) -> Line {
        match (&self.place.port, &self.place.tcp) {
            (Some(port), _) => Line::Serial { port: port.clone(), baud: self.baud },
            (None, address) => Line::Tcp(address.clone().unwrap_or_default()),
        }
    }
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// State, faults with how to clear them, position, commands, counters of the link.
    #[command(after_help = examples::STATUS)]
    Status {
        /// As JSON.
        #[arg(long)]
        json: bool,
    },
    /// Print the last faults that the drive has kept in its flash, the newest first.
    #[command(after_help = examples::EVENTS)]
    Events,
    /// Start the drive, and keep the link alive until Ctrl-C or --duration-s; then stop it.
    #[command(after_help = examples::ENABLE)]
    Enable(Stay),
    /// Stop the drive: brake the axis to rest, then everything off.
    #[command(after_help = examples::DISABLE)]
    Disable,
    /// Leave the fault state, once its cause is gone.
    #[command(after_help = examples::CLEAR)]
    Clear,
    /// Call the place where the axis stands 0.
    #[command(after_help = examples::HOME)]
    Home,
    /// Call the place where the axis stands by another position.
    #[command(after_help = examples::SET_POSITION)]
    SetPosition(Target),
    /// Send the reference there, and keep the link alive until Ctrl-C or --duration-s; then stop the drive.
    #[command(after_help = examples::REFERENCE)]
    Reference {
        #[command(flatten)]
        target: Target,
        /// Count from where the reference was going, not from 0; needs no homed axis.
        #[arg(long)]
        relative: bool,
        /// Highest speed, rad/s; without it, and at most, speed_limit_rad_s.
        #[arg(long, alias = "speed", value_name = "RAD_S", default_value_t = 0.0)]
        speed_rad_s: f32,
        /// Acceleration, rad/s2; without it, and at most, acceleration_limit_rad_s2.
        #[arg(long, alias = "accel", value_name = "RAD_S2", default_value_t = 0.0)]
        acceleration_rad_s2: f32,
        /// Greatest torque, whole N m; without it, torque_limit_nm.
        #[arg(long, value_name = "NM", default_value_t = 0)]
        max_torque_nm: u8,
        #[command(flatten)]
        stay: Stay,
    },
    /// Let the reference slow down and stay; ends an experiment.
    #[command(after_help = examples::HOLD)]
    Hold(Stay),
    /// Run an experiment of the image from where the reference is.
    #[command(after_help = examples::RUN)]
    Run(Run),
    /// Find the machine by experiments: friction, law and times of the fluid, inertia, delays; the axis moves.
    #[command(after_help = examples::IDENTIFY)]
    Identify(identify::Args),
    /// Print parameters of the law, as `[controller]` of a machine file has them; without names, all.
    #[command(after_help = examples::GET)]
    Get {
        /// Names.
        names: Vec<String>,
    },
    /// Set parameters of the law, all or none, until the next reset; `save` keeps them.
    #[command(after_help = examples::SET)]
    Set(set::Args),
    /// Make the parameters the image was built with those of the law.
    #[command(after_help = examples::DEFAULTS)]
    Defaults,
    /// Make the parameters in flash those of the law.
    #[command(after_help = examples::LOAD)]
    Load,
    /// Write the parameters of the law to flash.
    #[command(after_help = examples::SAVE)]
    Save,
    /// Start a recording.
    #[command(after_help = examples::START_RECORDING)]
    StartRecording {
        /// Number that is told in the recording.
        #[arg(default_value_t = 1)]
        run: u32,
    },
    /// End the recording.
    #[command(after_help = examples::STOP_RECORDING)]
    StopRecording,
}

/// What keeps the drive running.
#[derive(Debug, clap::Args)]
struct Stay {
    /// Leave the drive running alone, without a link.
    #[arg(long, conflicts_with = "duration_s")]
    autonomous: bool,
    /// For how long to keep the link alive, s.
    #[arg(long, alias = "for-s", value_name = "SECONDS", value_parser = seconds)]
    duration_s: Option<Duration>,
}

#[derive(Debug, clap::Args)]
struct Run {
    /// Enable the drive before and stop it after.
    #[arg(long, global = true, conflicts_with = "autonomous")]
    enable: bool,
    /// Leave it running alone, without a link.
    #[arg(long, global = true)]
    autonomous: bool,
    /// Greatest torque, whole N m; without it, torque_limit_nm.
    #[arg(long, global = true, value_name = "NM", default_value_t = 0)]
    max_torque_nm: u8,
    /// Record it over the link, .csv.
    #[arg(long, global = true, value_name = "FILE", value_parser = csv_name, conflicts_with = "autonomous")]
    record: Option<PathBuf>,
    /// Replaces a recording that is there though servo-lab did not write it.
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    shape: experiment::Shape,
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

/// Carries the action out in a session of its own.
///
/// # Errors
/// No connection, a drive that refuses, flags or values that cannot be.
pub fn run(args: &Args) -> Result<(), Error> {
    args.action.check()?;
    let (record, values) = (args.action.record()?, args.action.values()?);
    let (line, persistence) = (args.line.line(), args.line.persistence());
    if let Action::Identify(args) = &args.action {
        return identify::run(args, line, persistence);
    }
    let mut drive = Drive { connection: line.connect_with(persistence)?, line };
    let outcome = match (&args.action, record) {
        (Action::Run(run), Some(out)) => drive.run_recorded(run, out),
        (Action::Set(set), _) => drive.set(&values, set.force),
        (action, _) => drive.carry_out(action),
    };
    drive.connection.close();
    outcome
}

impl Drive {
    fn carry_out(&mut self, action: &Action) -> Result<(), Error> {
        let drive = self;
        match action {
            Action::Status { json } => drive.print_status(*json),
            Action::Events => drive.print_events(),
            Action::Enable(stay) => drive.enable(stay.autonomous).and_then(|()| drive.stay(stay)),
            Action::Disable => drive.disable(),
            Action::Clear => drive.clear(),
            Action::Home => drive.tell(Command::SetPosition { counts: 0 }),
            Action::SetPosition(target) => drive.tell(Command::SetPosition { counts: target.counts()? }),
            Action::Reference { target, relative, speed_rad_s, acceleration_rad_s2, max_torque_nm, stay } => {
                let counts = target.counts()?;
                let target = if *relative { link::Target::Relative(counts) } else { link::Target::Absolute(counts) };
                let pace = Pace { speed_rad_s: *speed_rad_s, acceleration_rad_s2: *acceleration_rad_s2 };
                drive.reference(Command::Reference { target, pace, torque_bound_nm: *max_torque_nm }, stay)
            }
            Action::Hold(stay) => {
                drive.tell(Command::Hold { autonomous: stay.autonomous }).and_then(|()| drive.stay(stay))
            }
            Action::Run(run) => drive.run(run),
            // One has a session of its own, the other values that were read before.
            Action::Identify(_) | Action::Set(_) => Ok(()),
            Action::Get { names } => drive.get(names),
            Action::Defaults => drive.tell(Command::Defaults).and_then(|()| drive.tell(APPLY)),
            Action::Load => drive.tell(Command::Load).and_then(|()| drive.tell(APPLY)),
            Action::Save => drive.tell(Command::Save),
            Action::StartRecording { run } => drive.tell(Command::StartRecording { run: *run, over_link: false }),
            Action::StopRecording => drive.tell(Command::StopRecording),
        }
    }
}

impl Action {
    /// The recording that is to be written.
    fn record(&self) -> Result<Option<Growing>, Error> {
        let Self::Run(Run { record: Some(file), force, .. }) = self else { return Ok(None) };
        let mut files = Files::new(*force);
        let out = files.writes(file);
        files.check()?.growing(out).map(Some)
    }

    /// The parameters that are to be set.
    fn values(&self) -> Result<Vec<set::Assignment>, Error> {
        if let Self::Set(args) = self { args.values() } else { Ok(Vec::new()) }
    }

    /// What can be known to be wrong without a drive.
    fn check(&self) -> Result<(), Error> {
        let outcome = match self {
            Self::Get { names } => names.iter().try_for_each(|name| find(name).map(drop)),
            Self::Reference { target, .. } | Self::SetPosition(target) => return target.counts().map(drop),
            _ => Ok(()),
        };
        outcome.map_err(|error| Error::Usage(error.to_string()))
    }
}

/// State, as [`link::Status::state`] has it, of a drive that runs.
const RUNNING: u8 = 2;
/// State of a drive that brings its axis to rest.
const STOPPING: u8 = 4;
/// State of a drive with a latched fault.
const FAULT: u8 = 3;

/// A request acts in the next tick, a stop takes up to a second by default; after this it has been refused by the law.
const TAKES_EFFECT: Duration = Duration::from_millis(1000);
/// Parameters are checked against the stability margins.
const APPLY: Command = Command::Apply { force: false };
/// Time between two words that keep the link alive; the drive takes 250 ms of silence for a fault.
const BEAT: Duration = Duration::from_millis(50);

struct Drive {
    line: Line,
    connection: Connection<Box<dyn Stream>>,
}
