//! Flags that choose the machine and its fluid, shared by the commands that simulate.

use std::path::{Path, PathBuf};

use diagnosis::physics::Physics;
use plant::er_fluid::{Electrode, FlowCurve, Kinetics, Temperature};
use plant::{Er, FieldResponse, FluidResponse, Model};

use crate::Error;
use crate::read::{AxisKind, ErElectrode, ErFluid, Machine};

/// Longest delay a flag may ask for, ms; that of machine files.
const LONGEST_DELAY_MS: f64 = 1000.0;

/// How the fluid follows its command (control.md section 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Fluid {
    /// At once.
    None,
    /// The field waits, lags, or both: `--dead-time-ms`, `--lag-ms`.
    E,
    /// The coefficient of viscosity waits (`--dead-time-ms`) or lags (`--lag-ms`).
    Q,
}

/// Which machine is simulated.
#[derive(Debug, Clone, clap::Args)]
pub struct MachineArgs {
    /// Machine file; without one, the servo of the paper (fluid 2 ms dead time and 3 ms lag).
    #[arg(long, value_name = "FILE")]
    pub machine: Option<PathBuf>,
    /// Delay model of the fluid, in place of the machine's own.
    #[arg(long, value_enum)]
    pub fluid: Option<Fluid>,
    /// Dead time of the fluid, ms.
    #[arg(long, requires = "fluid", default_value_t = 0.0)]
    pub dead_time_ms: f64,
    /// First-order lag of the fluid, ms.
    #[arg(long, requires = "fluid", default_value_t = 0.0)]
    pub lag_ms: f64,
    /// A delayed viscosity without a bound, as the paper's equations (6) and (7) print it: up to 571 N m where 3.5 kV/mm
    /// gives 2.5.
    #[arg(long, requires = "fluid")]
    pub as_printed: bool,
    /// Delay of the drive, ms, in place of the machine's own.
    #[arg(long)]
    pub drive_delay_ms: Option<f64>,
}

impl MachineArgs {
    /// Physics and control law the flags ask for.
    ///
    /// # Errors
    /// A machine file that cannot be read, a linear axis, or delays that do not fit the delay model.
    pub fn build(&self) -> Result<(Model, er_servo::Config), Error> {
        self.check_delays()?;
        let mut fluid = None;
        let (mut model, config) = match &self.machine {
            None => (paper(), er_servo::Config::default()),
            Some(file) => {
                let machine = Machine::read(file)?;
                if machine.axis.kind != AxisKind::Rotary {
                    let message =
                        "the control law drives a rotary axis; a linear machine can be compared, not simulated";
                    return Err(Error::input(file, None, "axis.kind", message));
                }
                fluid = machine.plant.er.as_ref().and_then(|er| er.fluid.clone());
                (Physics::nominal(&machine, &[]).model_of(0), machine.controller.unwrap_or_default())
            }
        };
        if let Some(fluid) = self.fluid {
            let Some((a, b)) = model.er.as_ref().map(|er| (er.a, er.b)) else {
                let message =
                    "--fluid takes the place of the machine's own, and it has none: state plant.er.a and plant.er.b";
                return Err(Error::Usage(message.to_owned()));
            };
            let torque_limit = if self.as_printed { f64::INFINITY } else { Er::largest_torque(a, b) };
            model.er = Some(Er { response: self.response(fluid, torque_limit)?, ..Er::new(a, b, 0.0, 0.0) });
        }
        if let Some(fluid) = fluid
            && let Some(er) = model.er.take()
        {
            model.er = Some(with_fluid(er, &fluid).map_err(|message| {
                let file = self.machine.as_deref().unwrap_or(Path::new(""));
                Error::input(file, None, "plant.er.fluid", message)
            })?);
        }
        if let Some(delay_ms) = self.drive_delay_ms {
            model.torque_delay_s = delay_ms * 1e-3;
        }
        Ok((model, config))
    }

    fn check_delays(&self) -> Result<(), Error> {
        let delays = [
            ("--dead-time-ms", self.dead_time_ms),
            ("--lag-ms", self.lag_ms),
            ("--drive-delay-ms", self.drive_delay_ms.unwrap_or(0.0)),
        ];
        for (flag, delay_ms) in delays {
            if !(0.0..=LONGEST_DELAY_MS).contains(&delay_ms) {
                return Err(Error::Usage(format!("{flag}: {delay_ms} ms is not allowed, 0 to {LONGEST_DELAY_MS} is")));
            }
        }
        Ok(())
    }

    /// `torque_limit` is the largest torque of a delayed viscosity, N m.
    fn response(&self, fluid: Fluid, torque_limit: f64) -> Result<FluidResponse, Error> {
        let (dead_time_s, lag_s) = (self.dead_time_ms * 1e-3, self.lag_ms * 1e-3);
        match fluid {
            Fluid::None | Fluid::E if self.as_printed => Err(Error::Usage(
                "--as-printed is a reading of --fluid q; a field is bounded by its own limit".to_owned(),
            )),
            Fluid::None if dead_time_s != 0.0 || lag_s != 0.0 => {
                Err(Error::Usage("--fluid none has no delay; choose e or q for --dead-time-ms and --lag-ms".to_owned()))
            }
            Fluid::None | Fluid::E => Ok(FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s))),
            Fluid::Q if lag_s == 0.0 => Ok(FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit }),
            Fluid::Q if dead_time_s == 0.0 => Ok(FluidResponse::ViscosityLag { lag_s, torque_limit }),
            Fluid::Q => Err(Error::Usage("--fluid q takes --dead-time-ms or --lag-ms, not both".to_owned())),
        }
    }
}

/// The damper with the physics of `[plant.er.fluid]`; an error in words where the plant does not take it.
fn with_fluid(mut er: Er, fluid: &ErFluid) -> Result<Er, String> {
    let FluidResponse::Field(field) = &mut er.response else {
        return Err("follows a field; it does not go with --fluid q, which delays a viscosity".to_owned());
    };
    let kinetics = Kinetics { rise_exponent: fluid.rise_exponent, fall_exponent: fluid.fall_exponent };
    // An effect `field_kinetics` stands where the section says nothing of it.
    if kinetics != Kinetics::default() {
        field.kinetics = kinetics;
    }
    if fluid.consistency > 0.0 || fluid.consistency_per_kv_mm > 0.0 {
        field.flow = Some(FlowCurve {
            consistency: fluid.consistency,
            consistency_per_kv_mm: fluid.consistency_per_kv_mm,
            exponent: fluid.flow_exponent,
        });
    }
    if let Some(ErElectrode { capacitance_f, current_a, gap_m }) = fluid.electrode {
        let slew = Electrode { capacitance_f, current_a, gap_m }.slew_kv_mm_s().map_err(|error| error.to_string())?;
        // The slower of it and of an effect `field_slew_limit`.
        field.slew_kv_mm_s = Some(field.slew_kv_mm_s.map_or(slew, |other| other.min(slew)));
    }
    er.at_temperature(&Temperature {
        above_reference_k: fluid.above_reference_k,
        yield_per_k: fluid.yield_per_k,
        viscosity_per_k: fluid.viscosity_per_k,
    })
    .map_err(|error| error.to_string())
}

/// The paper's servo with the delay model it ends on.
fn paper() -> Model {
    Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() }
}
