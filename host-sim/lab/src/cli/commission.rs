//! `servo-lab commission`.

use std::path::PathBuf;

use super::Overwrite;
use super::link::LineArgs;
use super::link::identify::{Keeper, Travel};
use crate::commission::{AFTER, BEFORE, Wanted, commission, text};
use crate::interrupt::Interrupt;
use crate::output::formats;
use crate::session::Session;
use crate::{Error, output};

/// Flags of `commission`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    line: LineArgs,
    #[command(flatten)]
    travel: Travel,
    /// The step by which the loop is judged before and after, degrees; each goes up, and the axis stays there.
    #[arg(long, default_value_t = 20.0)]
    step_deg: f32,
    /// Write the tuned parameters to the drive's flash if the step is good; without, they are gone with the next reset.
    #[arg(long)]
    save: bool,
    /// Folder for the report, the machine file and the recordings; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/commission")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Commissions a drive, prints the report, writes everything.
///
/// # Errors
/// No connection, a drive that refuses or trips, recordings that do not determine the machine, demands that no gains keep,
/// outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let plan = args.travel.plan()?;
    // A reference that jumps further than that trips following_error_rad.
    if !(2.0..=25.0).contains(&args.step_deg) {
        return Err(Error::Usage(format!("--step-deg: {} is not allowed, 2 to 25 is", args.step_deg)));
    }
    let wanted = Wanted { plan, step_rad: args.step_deg.to_radians(), save: args.save };
    let mut session = Session::open(args.line.line(), args.line.persistence(), Interrupt::watch()?)?;
    let outcome = carried_out(args, &wanted, &mut session);
    session.close();
    outcome
}

fn carried_out(args: &Args, wanted: &Wanted, session: &mut Session) -> Result<(), Error> {
    let runs = wanted.plan.runs(&session.config()?)?;
    let mut files = args.overwrite.files();
    let report = files.writes(&args.out.join("report.md"));
    let names = runs.iter().map(|run| run.name.as_str()).chain([BEFORE, AFTER]);
    let mut keeper = Keeper::new(files, &args.out, names)?;
    let up_deg = args.travel.up_deg() + 2.0 * args.step_deg;
    eprintln!("the axis will move by up to {up_deg:.0} degrees up, from where it stands: Ctrl-C stops it");
    let done = commission(session, wanted, &mut |event| keeper.keep(event))?;
    keeper.model(&done.identified, &done.machine)?;
    output::text(&mut keeper.outputs, report, &formats::markdown(&text(&done)))?;
    keeper.outputs.finish()?;
    output::print(&format!(
        "{}\nwrote report.md, machine.toml and the recordings to {}\n",
        text(&done),
        args.out.display()
    ))
}
