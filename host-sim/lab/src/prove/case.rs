//! A case: what a seed draws, and its files.

use std::path::{Path, PathBuf};

use conceal::catalogue;
use conceal::closed_loop::Run;
use conceal::physics::Physics;
use conceal::recording::{Resolution, csv};
use conceal::reference::{Family, positions};
use conceal::seal::Truth;
use er_servo::Config;
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use super::Arm;
use super::plan::{Blueprint, Decoy};
use crate::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal};
use crate::{Error, output};

/// Length of each recording, s.
const DURATION_S: f32 = 8.0;
/// Largest deviation of a control period where it is uneven, s.
const JITTER_S: f64 = 20e-6;
/// Recordings to fit, then the one held out.
const NAMES: [&str; 3] = ["a.csv", "b.csv", "c.csv"];

/// Everything a seed decides.
#[derive(Debug)]
pub struct Case {
    /// The seed.
    pub seed: u64,
    /// Its place in the plan.
    pub blueprint: Blueprint,
    /// What is concealed.
    pub truth: Truth,
    physics: Physics,
    config: Config,
    random: StdRng,
}

/// The files the diagnosis is given.
#[derive(Debug)]
pub struct Files {
    /// Nominal model.
    pub machine: PathBuf,
    /// To be fitted.
    pub recordings: Vec<PathBuf>,
    /// Held out.
    pub holdout: PathBuf,
}

impl Case {
    /// Draws the case of a seed.
    pub fn draw(seed: u64) -> Self {
        let blueprint = Blueprint::of(seed);
        let mut random = StdRng::seed_from_u64(seed);
        let mut physics = Physics::nominal();
        physics.torque_noise_nm = 0.01 * 5.0_f64.powf(random.random());
        physics.sensor.noise_rad = 0.5 * Resolution::Counts.step_rad() * random.random::<f64>();
        let entries = blueprint.effects.iter().filter_map(|id| catalogue::find(id));
        let effects = entries.map(|entry| entry.conceal(blueprint.size, &mut physics, &mut random)).collect();
        let mut config = Config::default();
        if blueprint.arm == Arm::Controller {
            config.kp_nm_rad *= if random.random_bool(0.5) { 0.95 } else { 1.05 };
        }
        let truth = Truth {
            seed,
            effects,
            torque_noise_nm: physics.torque_noise_nm,
            sensor_noise_rad: physics.sensor.noise_rad,
            salt: format!("{:032x}", random.random::<u128>()),
        };
        Self { seed, blueprint, truth, physics, config, random }
    }

    /// Simulates the recordings and writes them with the machine file into a folder.
    ///
    /// # Errors
    /// A drive that trips, a file that cannot be written.
    pub fn write(mut self, folder: &Path) -> Result<Files, Error> {
        output::folder(folder)?;
        let resolution = match self.blueprint.decoy {
            Some(Decoy::TwelveBits) => Resolution::Bits(12),
            _ => Resolution::Counts,
        };
        let machine = folder.join("machine.toml");
        nominal(&machine, resolution).write(&machine)?;
        let second = [Family::Multisine, Family::Chirp][usize::from(self.random.random_bool(0.5))];
        let third = [Family::Steps, Family::Multisine][usize::from(self.random.random_bool(0.5))];
        let families = [Family::Steps, second, third];
        let mut recordings = Vec::new();
        for (index, (family, name)) in families.into_iter().zip(NAMES).enumerate() {
            let file = folder.join(name);
            let text = self.recording(index, family, resolution);
            let text = text.map_err(|error| Error::Usage(format!("seed {}: {error}", self.seed)))?;
            output::write(&file, |to| std::io::Write::write_all(to, &text))?;
            recordings.push(file);
        }
        let holdout = recordings.pop().unwrap_or_default();
        Ok(Files { machine, recordings, holdout })
    }

    fn recording(&mut self, index: usize, family: Family, resolution: Resolution) -> Result<Vec<u8>, conceal::Error> {
        let physics = catalogue::for_recording(&self.physics, index, &mut self.random);
        let reference = positions(family.draw(&mut self.random), DURATION_S, self.config.period_s)?;
        let jitter_s = if self.blueprint.decoy == Some(Decoy::Jitter) { JITTER_S } else { 0.0 };
        let run = Run { physics: &physics, config: &self.config, jitter_s, seed: self.random.random() };
        csv(&run.follow(&reference)?, resolution)
    }
}

/// The nominal machine. A log too coarse to replay the law comes without a controller to check.
fn nominal(file: &Path, resolution: Resolution) -> Machine {
    Machine {
        file: file.to_path_buf(),
        name: "er-dd-servo".to_owned(),
        axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution: resolution.step_rad() },
        plant: PlantNominal {
            inertia: 0.075,
            coulomb: 0.763,
            viscous: 0.0,
            torque_gain: 1.0,
            torque_offset: 0.0,
            torque_limit: Some(30.0),
            torque_delay_s: 0.005,
            er: Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003 }),
        },
        controller: (resolution == Resolution::Counts).then(Config::default),
        effects: Vec::new(),
    }
}
