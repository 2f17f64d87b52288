//! The closed loop of a drawn machine.

use er_servo::{Counts, InputFlags, Inputs, Mode, MonitorCode, Params, ResolverCode, ResolverSample, Supervisor};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::controller;
use super::setting::{Law, Setting};
use crate::Error;
use crate::physics::Physics;
use crate::rotor::{Command, Rotor};
use crate::sensor::{Measured, unit_normal};

/// A motion is lost where it leaves this many times its references.
const LOST: f64 = 20.0;

/// One row, with what no log has beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) seq: usize,
    pub(crate) t_s: f64,
    pub(crate) reference: f64,
    /// As the sensor has it, rounded to its step.
    pub(crate) reading: f64,
    /// What was commanded from here on, the noise beside it.
    pub(crate) command: Command,
    pub(crate) mode: Mode,
    /// Mean torque of the drive until the next row.
    pub(crate) drive: f64,
    /// In the machine.
    pub(crate) position: f64,
    pub(crate) speed: f64,
}

/// One recording to be made.
pub(crate) struct Loop<'a> {
    pub(crate) setting: &'a Setting,
    pub(crate) physics: &'a Physics,
    /// Standard deviation and memory, s, of the coloured torque noise.
    pub(crate) coloured: Option<(f64, f64)>,
    /// Of the law that runs, over that of the machine file, 1.
    pub(crate) gain_error: f64,
    /// Longest step of the integrator, s.
    pub(crate) step_s: f64,
    pub(crate) seed: u64,
}

/// A controller at work.
enum Running<'a> {
    Servo(Box<(Params, er_servo::State)>),
    Own(&'a controller::Controller, controller::State),
}

/// What a controller says: torque, field, mode, speed; the reading as it has it.
struct Said {
    torque: f64,
    field: f64,
    mode: Mode,
    speed: f64,
    reading: f64,
}

impl Loop<'_> {
    /// Follows a reference from rest at zero.
    ///
    /// # Errors
    /// A drive that trips, a motion that is lost.
    // Over 40 lines: what goes into one row and what comes out of it.
    pub(crate) fn follow(&self, reference: &[f64]) -> Result<Vec<Sample>, Error> {
        let setting = self.setting;
        let mut random = StdRng::seed_from_u64(self.seed);
        let mut running = self.begin()?;
        let whole = (setting.period_s / self.step_s).ceil();
        let step_s = setting.period_s / whole;
        let mut rotor = Rotor::new(self.physics, step_s);
        let mut sensor = Measured::new(self.physics, step_s);
        let mut slow = 0.0;
        let mut field = 0.0;
        let farthest = LOST * reference.iter().fold(0.0_f64, |most, at| most.max(at.abs())).max(1e-6);
        let mut rows = Vec::with_capacity(reference.len());
        for &wanted in reference {
            let t_s = rotor.now_s();
            if rotor.position_rad().is_nan() || rotor.position_rad().abs() >= farthest {
                return Err(Error::Tripped { t_s, faults: "the motion is lost".to_owned() });
            }
            sensor.feel(rotor.drive_nm());
            let angle = sensor.sample(rotor.position_rad(), &mut random);
            let shown = (angle / setting.step).round() * setting.step;
            let said = running.step(setting, [t_s, wanted, shown, field, rotor.speed_rad_s()])?;
            field = said.field;
            if let Some((deviation, memory_s)) = self.coloured {
                let keep = (-setting.period_s / memory_s).exp();
                slow = keep * slow + deviation * (1.0 - keep * keep).sqrt() * unit_normal(&mut random);
            }
            let command = Command {
                torque_nm: said.torque,
                field_kv_mm: said.field,
                braking: said.mode == Mode::Brake,
                speed_rad_s: said.speed,
                viscosity_nm_s_rad: None,
                external_nm: slow + self.physics.torque_noise_nm * unit_normal(&mut random),
            };
            let (position, speed) = (rotor.position_rad(), rotor.speed_rad_s());
            let jitter = if setting.jitter_s > 0.0 { random.random_range(-1.0..1.0) * setting.jitter_s } else { 0.0 };
            let steps = ((setting.period_s + jitter) / step_s).round().max(1.0);
            let mut drive = 0.0;
            for _ in 0..steps as u64 {
                sensor.watch(rotor.position_rad());
                rotor.step(&command);
                drive += rotor.drive_nm() / steps;
            }
            let (seq, mode) = (rows.len(), said.mode);
            rows.push(Sample {
                seq,
                t_s,
                reference: wanted,
                reading: said.reading,
                command,
                mode,
                drive,
                position,
                speed,
            });
        }
        Ok(rows)
    }

    fn begin(&self) -> Result<Running<'_>, Error> {
        match &self.setting.law {
            Law::Own(law) => Ok(Running::Own(law, controller::State::default())),
            Law::Servo(config) => {
                let mut config = config.clone();
                config.kp_nm_rad *= self.gain_error as f32;
                let params = Params::new(&config).map_err(Error::Config)?;
                let shown = self.physics.sensor.eccentricity.map_or(0.0, |wave| wave.at(0.0));
                let state = er_servo::State::running_at(Counts::from_rad(shown));
                Ok(Running::Servo(Box::new((params, state))))
            }
        }
    }
}

impl Running<'_> {
    /// Time, reference, reading, last field and the speed that the converter would give.
    fn step(&mut self, setting: &Setting, [t_s, wanted, shown, field, speed]: [f64; 5]) -> Result<Said, Error> {
        match self {
            Self::Own(law, state) => {
                let (torque, field) = law.step(state, t_s, setting.period_s, wanted, shown);
                let mode = if field > 0.0 { Mode::Damper } else { Mode::Off };
                Ok(Said { torque, field, mode, speed: state.speed, reading: shown })
            }
            Self::Servo(parts) => {
                let (params, state) = &mut **parts;
                let code = ResolverCode((Counts::from_rad(shown).0 & 0x0fff) as u16);
                let inputs = Inputs {
                    resolver: ResolverSample { code, fault_byte: 0, speed_rad_s: speed as f32 },
                    flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE,
                    reference: Counts::from_rad(wanted),
                    field_monitor: MonitorCode::from_kv_mm(field as f32),
                    ..Inputs::default()
                };
                let outputs = er_servo::step(params, state, &inputs);
                if outputs.supervisor != Supervisor::Running {
                    return Err(Error::Tripped { t_s, faults: format!("{:?}", outputs.supervisor) });
                }
                Ok(Said {
                    torque: f64::from(outputs.torque_nm),
                    field: f64::from(outputs.field_kv_mm),
                    mode: outputs.mode,
                    speed: f64::from(outputs.speed_rad_s),
                    reading: outputs.position.to_rad(),
                })
            }
        }
    }
}
