//! `servo-lab stability`: is the servo stable, by four methods, and how far is it from the edge.

mod figure;
mod text;

use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use er_servo::Config;

use crate::Error;
use crate::stability::analysis::{Setting, analyse};
use crate::stability::region::Window;
use crate::stability::{Fluid, Loop, LoopError, NormalisedGains, Plant};

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
    /// Delay L of the motor system, ms [default: 5]
    #[arg(long, value_name = "MS")]
    delay_ms: Option<f64>,
    /// Delay the normalised gains are scaled with, ms [default: that of the motor system]
    #[arg(long, value_name = "MS")]
    gains_delay_ms: Option<f64>,
    /// Viscosity Q0 without delay, N m s/rad
    #[arg(long, default_value_t = 0.2)]
    q0: f64,
    /// Viscosity Q1 behind the fluid's delay, N m s/rad
    #[arg(long, default_value_t = 10.0)]
    q1: f64,
    /// Delay model of the fluid
    #[arg(long, value_enum, default_value = "dead-time")]
    model: Model,
    /// Dead time L_Q or time constant T_Q of the fluid, ms
    #[arg(long, value_name = "MS", default_value_t = 5.0)]
    field_delay_ms: f64,
    /// Normalised gain K_p* = K_P L^2 / J [default: 0.08]
    #[arg(long)]
    kp: Option<f64>,
    /// Normalised gain K_d* = K_D L / J [default: 0.464]
    #[arg(long)]
    kd: Option<f64>,
    /// Inertia, kg m2 [default: 0.075]
    #[arg(long, value_name = "KG_M2")]
    inertia: Option<f64>,
    /// Write the whole answer as JSON; - for standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Draw the stable regions, as Fig. 9 of the paper
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Usage`] for values the analysis is not defined for, [`Error::Output`] for a file that cannot be written.
pub fn run(args: &StabilityArgs) -> Result<(), Error> {
    let (closed, setting) = case(args)?;
    let (analysis, regions) = analyse(&closed, &setting).map_err(usage)?;
    if let Some(file) = &args.plot {
        let figure = figure::draw(&analysis, &regions).map_err(|reason| cannot_write(file, reason))?;
        write(file, figure.as_bytes())?;
    }
    let json = args.json.as_deref().map(|file| (file, file == Path::new("-")));
    if let Some((file, to_stdout)) = json {
        let mut text = serde_json::to_string_pretty(&analysis).map_err(|reason| cannot_write(file, reason))?;
        text.push('\n');
        if to_stdout { print(&text)? } else { write(file, text.as_bytes())? }
    }
    if json.is_none_or(|(_, to_stdout)| !to_stdout) {
        print(&text::summary(&analysis))?;
    }
    Ok(())
}

/// The loop and the setting the flags describe.
fn case(args: &StabilityArgs) -> Result<(Loop, Setting), Error> {
    let control = Config::default();
    let seconds = |ms: f64| ms * 1e-3;
    let torque_delay_s = args.delay_ms.map_or(DELAY_S, seconds);
    let inertia_kg_m2 = args.inertia.unwrap_or(INERTIA_KG_M2);
    let field_delay_s = seconds(args.field_delay_ms);
    let fluid = match args.model {
        Model::None => Fluid::None,
        Model::DeadTime => Fluid::DeadTime { l_q_s: field_delay_s },
        Model::Lag => Fluid::Lag { t_q_s: field_delay_s },
    };
    let plant = Plant { inertia_kg_m2, torque_delay_s, q0_nm_s_rad: args.q0, q1_nm_s_rad: args.q1, fluid };
    let normalised = NormalisedGains {
        kp: args.kp.unwrap_or(NormalisedGains::PAPER.kp),
        kd: args.kd.unwrap_or(NormalisedGains::PAPER.kd),
    };
    let gains = normalised.physical(inertia_kg_m2, args.gains_delay_ms.map_or(torque_delay_s, seconds));
    let closed = Loop::new(plant, gains).map_err(usage)?;
    let coulomb_nm = f64::from(control.er_c_nm);
    Ok((closed, Setting { window: Window::SPECIFIED, field_delay_s, coulomb_nm, control }))
}

/// L of the specification, s.
const DELAY_S: f64 = 5e-3;
/// J of the specification, kg m2.
const INERTIA_KG_M2: f64 = 0.075;

fn usage(error: LoopError) -> Error {
    Error::Usage(error.to_string())
}

fn cannot_write(file: &Path, reason: impl Display) -> Error {
    Error::Output { file: file.to_path_buf(), reason: reason.to_string() }
}

/// Writes to standard output; a reader that has seen enough and closed it is no error.
fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(reason) if reason.kind() != ErrorKind::BrokenPipe => {
            Err(cannot_write(Path::new("standard output"), reason))
        }
        _ => Ok(()),
    }
}

/// Writes beside the file and renames, so that the file there before stays whole if anything fails.
fn write(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let written = tempfile::NamedTempFile::new_in(folder).and_then(|mut temporary| {
        temporary.write_all(bytes)?;
        temporary.persist(file).map_err(|failed| failed.error)
    });
    written.map(|_| ()).map_err(|reason| cannot_write(file, reason))
}
