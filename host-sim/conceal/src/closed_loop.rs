//! The flashed law on the concealed machine.

use er_servo::{
    Config, Counts, InputFlags, Inputs, Mode, MonitorCode, Params, ResolverCode, ResolverSample, State, Supervisor,
    step,
};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use crate::Error;
use crate::physics::Physics;
use crate::rotor::{Command, Rotor, STEP_S};
use crate::sensor::{Measured, unit_normal};

/// One control period as the drive logs it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Number of the control period since the start.
    pub seq: usize,
    /// s.
    pub t_s: f64,
    /// Reference.
    pub reference: Counts,
    /// Position as measured.
    pub position: Counts,
    /// Commanded torque, N m.
    pub torque_nm: f32,
    /// Commanded field, kV/mm.
    pub field_kv_mm: f32,
    /// Use of the damper.
    pub mode: Mode,
    /// The law's speed, rad/s.
    pub speed_rad_s: f32,
}

/// How the loop runs.
#[derive(Debug, Clone)]
pub struct Run<'a> {
    /// Machine.
    pub physics: &'a Physics,
    /// The law's configuration.
    pub config: &'a Config,
    /// Largest deviation of a control period, s; the stamps tell it.
    pub jitter_s: f64,
    /// Field that a bench supply holds in place of the law's, kV/mm.
    pub held_kv_mm: Option<f32>,
    /// The coefficient of viscosity that the law asks for acts, at rest too, and not what field and speed tell of it.
    pub asked_viscosity: bool,
    /// Of every noise.
    pub seed: u64,
}

impl Run<'_> {
    /// Follows a reference from rest at zero.
    ///
    /// # Errors
    /// A configuration the law refuses, a drive that trips.
    // Over 40 lines: what goes into one tick and what comes out of it.
    pub fn follow(&self, reference: &[Counts]) -> Result<Vec<Row>, Error> {
        let params = Params::new(self.config).map_err(Error::Config)?;
        // The drive was enabled where its sensor says that the axis stands.
        let shown_rad = self.physics.sensor.eccentricity.map_or(0.0, |wave| wave.at(0.0));
        let mut state = State::running_at(Counts::from_rad(shown_rad));
        let mut random = StdRng::seed_from_u64(self.seed);
        let mut rotor = Rotor::new(self.physics, STEP_S);
        let mut sensor = Measured::new(self.physics, STEP_S);
        let mut field_kv_mm = 0.0;
        let mut rows = Vec::with_capacity(reference.len());
        for &reference in reference {
            sensor.feel(rotor.drive_nm());
            let position = Counts::from_rad(sensor.sample(rotor.position_rad(), &mut random));
            let inputs = Inputs {
                resolver: ResolverSample {
                    code: ResolverCode((position.0 & 0x0fff) as u16),
                    fault_byte: 0,
                    speed_rad_s: rotor.speed_rad_s() as f32,
                },
                flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE,
                reference,
                field_monitor: MonitorCode::from_kv_mm(field_kv_mm),
                ..Inputs::default()
            };
            let outputs = step(&params, &mut state, &inputs);
            if outputs.supervisor != Supervisor::Running {
                let faults = format!("{:?}", outputs.supervisor);
                return Err(Error::Tripped { t_s: rotor.now_s(), faults });
            }
            // The law watches its own supply, which goes on as it says; the fluid may be on another.
            field_kv_mm = outputs.field_kv_mm;
            let (acting_kv_mm, mode) = self.held_kv_mm.map_or((field_kv_mm, outputs.mode), |held| (held, Mode::Brake));
            rows.push(Row {
                seq: rows.len(),
                t_s: rotor.now_s(),
                reference,
                position: outputs.position,
                torque_nm: outputs.torque_nm,
                field_kv_mm: acting_kv_mm,
                mode,
                speed_rad_s: outputs.speed_rad_s,
            });
            let command = Command {
                torque_nm: f64::from(outputs.torque_nm),
                field_kv_mm: f64::from(acting_kv_mm),
                braking: mode == Mode::Brake,
                speed_rad_s: f64::from(outputs.speed_rad_s),
                viscosity_nm_s_rad: (self.asked_viscosity && mode == Mode::Damper)
                    .then(|| f64::from(params.viscosity_nm_s_rad(outputs.speed_rad_s))),
                external_nm: self.physics.torque_noise_nm * unit_normal(&mut random),
            };
            for _ in 0..self.steps(&mut random) {
                sensor.watch(rotor.position_rad());
                rotor.step(&command);
            }
        }
        Ok(rows)
    }

    /// Steps of the next control period.
    fn steps(&self, random: &mut StdRng) -> u64 {
        let period_s = f64::from(self.config.period_s);
        let jitter_s = if self.jitter_s > 0.0 { random.random_range(-self.jitter_s..self.jitter_s) } else { 0.0 };
        ((period_s + jitter_s) / STEP_S).round().max(1.0) as u64
    }
}
