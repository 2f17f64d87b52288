//! `servo-lab link identify`.

use std::path::{Path, PathBuf};

use wire::connection::Persistence;

use crate::identify::{Event, Identified, Plan, applied, commented, identify, machine, text};
use crate::interrupt::Interrupt;
use crate::line::Line;
use crate::output::{Files, Output, Outputs, formats};
use crate::read::Machine;
use crate::session::Session;
use crate::{Error, output};

/// Flags of `link identify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub(in crate::cli) travel: Travel,
    /// Folder for the machine file and the recordings; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/identify")]
    out: PathBuf,
    /// Make what was found parameters of the drive, and write them to its flash.
    #[arg(long)]
    apply: bool,
    /// Replaces outputs that are there though servo-lab did not write them.
    #[arg(long)]
    force: bool,
}

/// How far and how hard the axis may move.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(in crate::cli) struct Travel {
    /// Travel in the positive direction from where the axis stands, degrees; the other way it moves by a third of that.
    #[arg(long, default_value_t = 60.0)]
    travel_deg: f32,
    /// Greatest torque, whole N m; without it, torque_limit_nm.
    #[arg(long, value_name = "NM", default_value_t = 0)]
    pub(in crate::cli) max_torque_nm: u8,
}

impl Travel {
    /// How far up the axis moves, degrees.
    pub(in crate::cli) fn up_deg(&self) -> f32 {
        self.travel_deg
    }

    /// The plan.
    ///
    /// # Errors
    /// A travel in which no speed can be held.
    pub(in crate::cli) fn plan(&self) -> Result<Plan, Error> {
        // Below, passes at constant speed are shorter than the loop settles; above, ramps pass the speed the fluid is a damper at.
        if !(10.0..=85.0).contains(&self.travel_deg) {
            return Err(Error::Usage(format!("--travel-deg: {} is not allowed, 10 to 85 is", self.travel_deg)));
        }
        Ok(Plan { travel_rad: self.travel_deg.to_radians(), max_torque_nm: self.max_torque_nm })
    }
}

/// Runs the experiments, prints what they tell, and writes it.
///
/// # Errors
/// No connection, a drive that refuses or trips, recordings that do not determine the machine, outputs that cannot be written.
pub fn run(args: &Args, line: Line, persistence: Persistence) -> Result<(), Error> {
    let plan = args.travel.plan()?;
    let mut session = Session::open(line, persistence, Interrupt::watch()?)?;
    let outcome = carried_out(args, &plan, &mut session);
    session.close();
    outcome
}

fn carried_out(args: &Args, plan: &Plan, session: &mut Session) -> Result<(), Error> {
    let before = session.config()?;
    let runs = plan.runs(&before)?;
    let mut keeper = Keeper::new(Files::new(args.force), &args.out, runs.iter().map(|run| run.name.as_str()))?;
    let (up_deg, time_s) = (args.travel.up_deg(), Plan::duration_s(&runs));
    eprintln!(
        "the axis will move for {time_s:.0} s, by up to {up_deg:.0} degrees up and {:.0} down from where it stands: Ctrl-C stops it",
        up_deg / 3.0
    );
    let found = identify(session, plan, &mut |event| keeper.keep(event))?;
    let out = args.out.display();
    output::print(&format!("{}wrote machine.toml and the recordings to {out}\n", text(&found)))?;
    if args.apply {
        session.set_all(&applied(&before, &found))?;
        session.save()?;
        output::print("the drive has them, in flash too\n")?;
    }
    Ok(())
}

/// Writes what has come as soon as it has: what follows may fail, and the axis need not move again for it.
pub(in crate::cli) struct Keeper {
    pub(in crate::cli) outputs: Outputs,
    model: Output,
    recordings: Vec<(String, Output)>,
}

impl Keeper {
    /// Of the recordings with these names, and a machine file, in a folder.
    ///
    /// # Errors
    /// As [`Files::check`].
    pub(in crate::cli) fn new<'a>(
        mut files: Files,
        out: &Path,
        names: impl Iterator<Item = &'a str>,
    ) -> Result<Self, Error> {
        let model = files.writes(&out.join("machine.toml"));
        let recordings = names.map(|name| (name.to_owned(), files.writes(&out.join(name)))).collect();
        Ok(Self { outputs: files.check()?, model, recordings })
    }

    /// Tells what begins, writes what has come.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub(in crate::cli) fn keep(&mut self, event: Event<'_>) -> Result<(), Error> {
        match event {
            Event::Stage(what) => eprintln!("{what}"),
            Event::Recorded(recording) => {
                if let Some((_, output)) = self.recordings.iter().find(|(name, _)| *name == recording.name) {
                    self.outputs.recording(*output, recording)?;
                    self.outputs.finish()?;
                }
            }
            Event::Found(before, found) => {
                self.model(found, &machine(before, found))?;
                self.outputs.finish()?;
            }
        }
        Ok(())
    }

    /// Writes the machine file; it appears with [`Outputs::finish`].
    ///
    /// # Errors
    /// It cannot be written.
    pub(in crate::cli) fn model(&mut self, found: &Identified, machine: &Machine) -> Result<(), Error> {
        let file = self.outputs.file(self.model).to_path_buf();
        let toml = machine.to_toml().map_err(|error| Error::Output { file, reason: error.to_string() })?;
        output::text(&mut self.outputs, self.model, &formats::toml(&commented(found, &toml)))
    }
}
