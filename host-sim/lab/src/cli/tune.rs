//! `servo-lab tune`: gains that keep margins over the uncertainty of every delay, and settle fast.

mod page;

use std::path::PathBuf;

use super::Overwrite;
use super::machine::MachineArgs;
use crate::output::{Provenance, formats};
use crate::progress::Course;
use crate::read::Machine;
use crate::stability::NormalisedGains;
use crate::tune::beside::beside;
use crate::tune::search::SEED;
use crate::tune::{Demands, Steps, Task, Tuning, figure, machine, summary, tune};
use crate::{Error, output};

/// Flags of `tune`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,
    /// Phase margin to keep, degrees.
    #[arg(long, default_value_t = 30.0)]
    phase_margin_deg: f64,
    /// Gain margin to keep, a factor above 1.
    #[arg(long, default_value_t = 1.5)]
    gain_margin: f64,
    /// Delay margin to keep, as a share of L.
    #[arg(long, default_value_t = 0.2)]
    delay_margin: f64,
    /// How far each delay may be off, percent.
    #[arg(long, default_value_t = 50.0)]
    uncertainty_percent: f64,
    /// Largest viscosity the margins are kept for, N m s/rad [default: the peak of (5), or as near as gains do]
    #[arg(long, value_name = "Q1")]
    q1: Option<f64>,
    /// Large step, degrees.
    #[arg(long, default_value_t = 30.0)]
    step_deg: f64,
    /// Small step, mrad.
    #[arg(long, default_value_t = 50.0)]
    small_mrad: f64,
    /// Settled within this, or 2 % of the step where that is more, mrad [default: 2 % of the large step, or twice what
    /// friction holds against the paper's gains]
    #[arg(long)]
    tolerance_mrad: Option<f64>,
    /// Largest overshoot, percent of the step.
    #[arg(long, default_value_t = 2.0)]
    overshoot_percent: f64,
    /// Folder for the picture and the machine file; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/tune")]
    out: PathBuf,
    /// Writes what was found as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Tunes, writes picture and machine file, prints what was found.
///
/// # Errors
/// Flags or a machine that cannot be followed, demands that no gains keep, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads_all(&args.machine.machine);
    let (picture, file) = (files.writes(&args.out.join("tune.svg")), files.writes(&args.out.join("tuned.toml")));
    let html = args.html.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let tuned = args.tune()?;
    output::figure(&mut outputs, picture, &figure(&tuned.tuning))?;
    let machine = tuned.machine.to_toml();
    let machine =
        machine.map_err(|error| Error::Output { file: outputs.file(file).to_path_buf(), reason: error.to_string() })?;
    output::text(&mut outputs, file, &formats::toml(&machine))?;
    if let Some(html) = html {
        let named = outputs.file(file).display().to_string();
        let page = page::page(&args.task()?, &tuned, &named, &Provenance::of(&outputs, Some(SEED))?)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    outputs.finish()?;
    let (picture, file) = (outputs.file(picture).display(), outputs.file(file).display());
    output::print(&format!("{}\nwrote {picture} and {file}\n", tuned.summary))
}

/// What tuning gave.
#[derive(Debug)]
pub struct Tuned {
    /// The gains and all that was judged on the way.
    pub tuning: Tuning,
    /// The machine with these gains.
    pub machine: Machine,
    /// What was found, in words.
    pub summary: String,
}

impl Args {
    /// Tunes; writes nothing.
    ///
    /// # Errors
    /// Flags or a machine that cannot be followed, demands that no gains keep.
    pub fn tune(&self) -> Result<Tuned, Error> {
        let task = self.task()?;
        // How long all of it takes is known of no stage alone.
        let course = Course::begin("tune");
        course.enter("gains");
        let tuning = tune(&task)?;
        let read = self.machine.machine.as_deref().map(Machine::read).transpose()?;
        let machine = machine(&task, &tuning, read);
        course.enter("the control beyond them");
        let beyond = beside(&task)?.map_or_else(String::new, |beside| format!("\n{}", beside.text(&task, &tuning)));
        let summary = summary(&task, &tuning) + &beyond;
        Ok(Tuned { tuning, machine, summary })
    }

    /// Refuses a flag outside its range.
    fn check(&self) -> Result<(), Error> {
        let checks = [
            ("--phase-margin-deg", self.phase_margin_deg, 1.0, 90.0),
            ("--gain-margin", self.gain_margin, 1.01, 10.0),
            ("--delay-margin", self.delay_margin, 0.01, 100.0),
            ("--uncertainty-percent", self.uncertainty_percent, 0.0, 90.0),
            ("--q1", self.q1.unwrap_or(0.0), 0.0, 1000.0),
            ("--step-deg", self.step_deg, 0.1, 360.0),
            ("--small-mrad", self.small_mrad, 1.0, 6000.0),
            ("--tolerance-mrad", self.tolerance_mrad.unwrap_or(1.0), 0.05, 1000.0),
            ("--overshoot-percent", self.overshoot_percent, 0.0, 100.0),
        ];
        for (flag, value, least, most) in checks {
            // Negated so that NaN is refused.
            if !(value >= least && value <= most) {
                return Err(Error::Usage(format!("{flag}: {value} is not allowed, {least} to {most} is")));
            }
        }
        Ok(())
    }

    fn task(&self) -> Result<Task, Error> {
        self.check()?;
        let (model, config) = self.machine.build()?;
        let large_rad = self.step_deg.to_radians();
        let paper = NormalisedGains::PAPER.physical(model.inertia, model.torque_delay_s.max(1e-3));
        let held_rad = model.coulomb / paper.k_p_nm_rad;
        let tolerance_rad = self.tolerance_mrad.map_or((0.02 * large_rad).max(2.0 * held_rad), |mrad| 1e-3 * mrad);
        Ok(Task {
            model,
            config,
            demands: Demands {
                phase_deg: self.phase_margin_deg,
                gain: self.gain_margin,
                delay_share: self.delay_margin,
            },
            uncertainty: 0.01 * self.uncertainty_percent,
            q1_nm_s_rad: self.q1,
            steps: Steps {
                large_rad,
                small_rad: 1e-3 * self.small_mrad,
                tolerance_rad,
                overshoot: 0.01 * self.overshoot_percent,
            },
        })
    }
}
