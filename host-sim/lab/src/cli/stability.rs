//! `servo-lab stability`: is the servo stable, by four methods, and how far is it from the edge.

mod page;
mod text;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use er_servo::Config;

use super::Overwrite;
use crate::output::{Provenance, formats};
use crate::read::{Machine, PlantNominal as Nominal};
use crate::stability::analysis::{Setting, analyse};
use crate::stability::figure::stable_regions;
use crate::stability::region::Window;
use crate::stability::{Fluid, Gains, Loop, LoopError, NormalisedGains, Plant};
use crate::{Error, output};

/// Delay model of the fluid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// The fluid follows at once.
    None,
    /// Equation (10).
    DeadTime,
    /// Equation (12).
    Lag,
}

/// Flags of `servo-lab stability`.
#[derive(Debug, Args)]
pub struct StabilityArgs {
    /// Delay L of the motor system, ms [default: 5, or the machine's]
    #[arg(long, alias = "delay-ms", value_name = "MS")]
    drive_delay_ms: Option<f64>,
    /// Delay the normalised gains are scaled with, ms [default: that of the motor system]
    #[arg(long, value_name = "MS")]
    gains_delay_ms: Option<f64>,
    /// Viscosity Q0 without delay, N m s/rad [default: 0.2; 0 of a machine that has no damper, or has it off]
    #[arg(long)]
    q0: Option<f64>,
    /// Viscosity Q1 behind the fluid's delay, N m s/rad [default: 10; 0 of a machine that has no damper, or has it off]
    #[arg(long)]
    q1: Option<f64>,
    /// Delay model of the fluid [default: dead-time, or the machine's: the longer of its dead time and lag decides]
    #[arg(long, alias = "model", value_enum)]
    fluid: Option<Model>,
    /// Dead time L_Q of the fluid, ms [default: 5, or the machine's dead time and lag together]
    #[arg(long, value_name = "MS", conflicts_with = "lag_ms")]
    dead_time_ms: Option<f64>,
    /// Time constant T_Q of the fluid, ms [default: as of --dead-time-ms]
    #[arg(long, value_name = "MS")]
    lag_ms: Option<f64>,
    /// Either of the two, by --fluid
    #[arg(long, value_name = "MS", hide = true, conflicts_with_all = ["dead_time_ms", "lag_ms"])]
    field_delay_ms: Option<f64>,
    /// Normalised gain K_p* = K_P L^2 / J [default: 0.08, or the machine's controller]
    #[arg(long, allow_hyphen_values = true)]
    kp: Option<f64>,
    /// Normalised gain K_d* = K_D L / J [default: 0.464, or the machine's controller]
    #[arg(long, allow_hyphen_values = true)]
    kd: Option<f64>,
    /// Inertia, kg m2 [default: 0.075, or the machine's]
    #[arg(long, value_name = "KG_M2")]
    inertia: Option<f64>,
    /// Take inertia, delay, friction, fluid and gains from this machine file; flags given go before it
    #[arg(long, value_name = "FILE")]
    machine: Option<PathBuf>,
    /// Write the whole answer as JSON; - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the stable regions, as Fig. 9 of the paper
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Writes the answer as one page that opens in a browser
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Usage`] for values the analysis is not defined for, [`Error::Output`] for a file that cannot be written.
pub fn run(args: &StabilityArgs) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads_all(&args.machine);
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    let json = args.json.as_ref().filter(|_| !to_stdout).map(|file| files.writes(file));
    let plot = args.plot.as_ref().map(|file| files.writes(file));
    let html = args.html.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let (closed, setting) = case(args)?;
    let (analysis, regions) = analyse(&closed, &setting).map_err(usage)?;
    let fluids = analysis.regions.iter().map(|known| known.fluid);
    let regions: Vec<_> = fluids.zip(regions).collect();
    let figure = || stable_regions(&analysis.plant, &regions, analysis.normalised_gains);
    plot.map_or(Ok(()), |plot| output::figure(&mut outputs, plot, &figure()))?;
    if let Some(html) = html {
        let page = page::page(&analysis, &figure(), &Provenance::of(&outputs, None)?)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    let document = || formats::json(&analysis, &Provenance::of(&outputs, None)?);
    if to_stdout {
        output::print(&document()?)?;
    } else if let Some(json) = json {
        let text = document()?;
        output::text(&mut outputs, json, &text)?;
    }
    outputs.finish()?;
    if to_stdout { Ok(()) } else { output::print(&text::summary(&analysis)) }
}

/// The loop and the setting the flags describe.
fn case(args: &StabilityArgs) -> Result<(Loop, Setting), Error> {
    let machine = args.machine.as_deref().map(Machine::read).transpose()?;
    let nominal = machine.as_ref().map(|machine| &machine.plant);
    if let Some(machine) = machine.as_ref().filter(|one| one.plant.er.as_ref().is_some_and(|er| er.fluid.is_some())) {
        let message = "is for `simulate` and `tune`; the linear loop has no such laws: leave the section out";
        return Err(Error::input(&machine.file, None, "plant.er.fluid", message));
    }
    let controller = machine.as_ref().and_then(|machine| machine.controller);
    let seconds = |ms: f64| ms * 1e-3;
    let torque_delay_s =
        args.drive_delay_ms.map_or_else(|| nominal.map_or(DELAY_S, Nominal::torque_delay_from_sample_s), seconds);
    let inertia_kg_m2 = args.inertia.unwrap_or_else(|| nominal.map_or(INERTIA_KG_M2, |p| p.inertia));
    let (model, fluid_s) = nominal.map_or((Model::DeadTime, FLUID_DELAY_S), fluid_of);
    let (asked, delay_ms) = asked(args)?;
    let field_delay_s = delay_ms.map_or(fluid_s, seconds);
    let fluid = match asked.unwrap_or(model) {
        Model::None => Fluid::None,
        Model::DeadTime => Fluid::DeadTime { l_q_s: field_delay_s },
        Model::Lag => Fluid::Lag { t_q_s: field_delay_s },
    };
    let is_damped = nominal.is_none_or(|plant| plant.er.is_some()) && controller.is_none_or(|one| one.er_enabled);
    let viscosity = |asked: Option<f64>, of_a_damper: f64| asked.unwrap_or(if is_damped { of_a_damper } else { 0.0 });
    let (q0_nm_s_rad, q1_nm_s_rad) = (viscosity(args.q0, Q0_NM_S_RAD), viscosity(args.q1, Q1_NM_S_RAD));
    let plant = Plant { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid };
    let closed = Loop::new(plant, gains(args, &plant, controller.as_ref())).map_err(usage)?;
    let control = controller.unwrap_or_default();
    let coulomb_nm = nominal.map_or(f64::from(control.er_c_nm), |p| p.coulomb);
    Ok((closed, Setting { window: Window::SPECIFIED, field_delay_s, coulomb_nm, control }))
}

/// Delay model and delay, ms, that the flags ask for.
fn asked(args: &StabilityArgs) -> Result<(Option<Model>, Option<f64>), Error> {
    let (model, delay_ms) = match (args.dead_time_ms, args.lag_ms) {
        (Some(delay_ms), _) => (Model::DeadTime, delay_ms),
        (None, Some(delay_ms)) => (Model::Lag, delay_ms),
        (None, None) => return Ok((args.fluid, args.field_delay_ms)),
    };
    if args.fluid.is_some_and(|fluid| fluid != model) {
        let message = "--dead-time-ms is the delay of --fluid dead-time, and --lag-ms that of --fluid lag";
        return Err(Error::Usage(message.to_owned()));
    }
    Ok((Some(model), Some(delay_ms)))
}

/// Delay model and delay, s, of a machine's fluid. (10) and (12) know a dead time or a lag: both together are taken as the
/// longer of the two with their sum, which has the same mean delay.
fn fluid_of(plant: &Nominal) -> (Model, f64) {
    match &plant.er {
        Some(er) if er.dead_time_s + er.lag_s > 0.0 => {
            let model = if er.lag_s > er.dead_time_s { Model::Lag } else { Model::DeadTime };
            (model, plant.sample_to_output_s + er.dead_time_s + er.lag_s)
        }
        _ => (Model::None, FLUID_DELAY_S),
    }
}

/// Gains in N m: a flag, else the machine's controller, else the paper's point; numbers are scaled with the plant.
fn gains(args: &StabilityArgs, plant: &Plant, controller: Option<&Config>) -> Gains {
    let delay_s = args.gains_delay_ms.map_or(plant.torque_delay_s, |ms| ms * 1e-3);
    let NormalisedGains { kp, kd } = NormalisedGains::PAPER;
    let flags = NormalisedGains { kp: args.kp.unwrap_or(kp), kd: args.kd.unwrap_or(kd) };
    let scaled = flags.physical(plant.inertia_kg_m2, delay_s);
    let Some(controller) = controller else { return scaled };
    Gains {
        k_p_nm_rad: if args.kp.is_some() { scaled.k_p_nm_rad } else { f64::from(controller.kp_nm_rad) },
        k_d_nm_s_rad: if args.kd.is_some() { scaled.k_d_nm_s_rad } else { f64::from(controller.kd_nm_s_rad) },
    }
}

/// Q0 and Q1 of the specification's point (control.md section 6), N m s/rad.
const Q0_NM_S_RAD: f64 = 0.2;
const Q1_NM_S_RAD: f64 = 10.0;
/// Delay of the fluid in section V, s.
const FLUID_DELAY_S: f64 = 5e-3;
/// L of the specification, s.
const DELAY_S: f64 = 5e-3;
/// J of the specification, kg m2.
const INERTIA_KG_M2: f64 = 0.075;

fn usage(error: LoopError) -> Error {
    Error::Usage(error.to_string())
}
