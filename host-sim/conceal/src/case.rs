//! A case: what a seed draws, and the files it becomes.

use std::path::Path;

use er_servo::{Config, Counts};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use crate::Error;
use crate::catalogue::{self, for_recording};
use crate::closed_loop::{Row, Run};
use crate::machine_file::{self, Nominal};
use crate::physics::Physics;
use crate::plan::{Arm, Blueprint, Decoy};
use crate::recording::{Resolution, csv};
use crate::reference::{Family, RICH, from_csv};
use crate::seal::{Concealed, Truth};

/// Length of each recording, s.
const DURATION_S: f64 = 8.0;
/// Of one with a single step, s.
const STEP_DURATION_S: f64 = 2.0;
/// Largest deviation of a control period where it is uneven, s.
const JITTER_S: f64 = 20e-6;
/// The machine file.
pub const MACHINE: &str = "machine.toml";
/// Recordings to fit.
pub const FITTED: [&str; 2] = ["a.csv", "b.csv"];
/// The same where they are single steps: three, as the paper has them.
pub const FITTED_STEPS: [&str; 3] = ["a.csv", "b.csv", "third.csv"];
/// The recording held out.
pub const HELD_OUT: &str = "c.csv";
/// The proposed experiment played twice: to fit, and to hold out.
pub const EXPERIMENT: [&str; 2] = ["d.csv", "e.csv"];

/// Everything a seed decides.
#[derive(Debug, Clone)]
pub struct Case {
    /// The seed.
    pub seed: u64,
    /// Its place in the plan.
    pub blueprint: Blueprint,
    /// What is concealed.
    pub truth: Truth,
    physics: Physics,
    config: Config,
    nominal: Nominal,
    random: StdRng,
}

impl Case {
    /// Draws the case of a seed.
    pub fn draw(seed: u64) -> Self {
        Self::of(seed, Blueprint::of(seed))
    }

    /// Draws a case of any blueprint.
    pub fn of(seed: u64, blueprint: Blueprint) -> Self {
        let mut random = StdRng::seed_from_u64(seed);
        let mut physics = Physics::nominal();
        physics.torque_noise_nm = 0.01 * 5.0_f64.powf(random.random());
        physics.sensor.noise_rad = 0.5 * Resolution::Counts.step_rad() * random.random::<f64>();
        let sizes = blueprint.sizes;
        let size = sizes.high * (sizes.low / sizes.high).powf(random.random());
        let mut nominal = if blueprint.arm == Arm::Steps { Nominal::at_once() } else { Nominal::default() };
        let effects: Vec<Concealed> = match (blueprint.decoy, blueprint.effects.first()) {
            _ if blueprint.arm == Arm::Steps => delayed(&blueprint.effects, size, &mut physics, &mut random),
            (Some(Decoy::Nominal), Some(id)) => vec![nominal.mislead(id, random.random_bool(0.5))],
            _ => {
                let entries = blueprint.effects.iter().filter_map(|id| catalogue::find(id));
                entries.map(|entry| entry.conceal(size, &mut physics, &mut random)).collect()
            }
        };
        let mut config = Config::default();
        if blueprint.arm == Arm::Controller {
            config.kp_nm_rad *= if random.random_bool(0.5) { 0.95 } else { 1.05 };
        }
        let truth = Truth {
            seed,
            arm: blueprint.arm,
            decoy: blueprint.decoy,
            effects,
            torque_noise_nm: physics.torque_noise_nm,
            sensor_noise_rad: physics.sensor.noise_rad,
            machine: None,
            salt: format!("{:032x}", random.random::<u128>()),
        };
        Self { seed, blueprint, truth, physics, config, nominal, random }
    }

    /// Simulates the recordings and writes them with the machine file into a folder that is there.
    ///
    /// # Errors
    /// A drive that trips, a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let mut random = self.random.clone();
        let resolution = self.resolution();
        // A log too coarse to replay the law comes without a controller to check, and so does a field that no law commands.
        let controller = resolution == Resolution::Counts && self.blueprint.held_kv_mm.is_none();
        put(&folder.join(MACHINE), machine_file::text(&self.nominal, resolution, controller).as_bytes())?;
        let families = self.families(&mut random);
        let names = self.fitted().iter().chain([&HELD_OUT]);
        for (index, (family, name)) in families.into_iter().zip(names).enumerate() {
            let duration_s = if family == Family::SingleStep { STEP_DURATION_S } else { DURATION_S };
            let reference = family.draw(duration_s, f64::from(self.config.period_s), &mut random);
            let rows = self.play(&reference, index, self.blueprint.held_kv_mm, &mut random)?;
            put(&folder.join(name), &csv(&rows, resolution)?)?;
        }
        Ok(())
    }

    /// Plays an experiment's reference (the text of a CSV file) on the same machine under the law, twice.
    ///
    /// # Errors
    /// A reference that is none, a drive that trips, a file that cannot be written.
    pub fn write_experiment(&self, reference: &str, folder: &Path) -> Result<(), Error> {
        let mut random = StdRng::seed_from_u64(self.seed ^ 0x5eed);
        let reference = from_csv(reference, f64::from(self.config.period_s))?;
        for (index, name) in EXPERIMENT.into_iter().enumerate() {
            let rows = self.play(&reference, 1 + index, None, &mut random)?;
            put(&folder.join(name), &csv(&rows, self.resolution())?)?;
        }
        Ok(())
    }

    /// Names of the recordings to fit.
    pub fn fitted(&self) -> &'static [&'static str] {
        if self.blueprint.arm == Arm::Steps { &FITTED_STEPS } else { &FITTED }
    }

    fn resolution(&self) -> Resolution {
        match self.blueprint.decoy {
            Some(Decoy::TwelveBits) => Resolution::Bits(12),
            _ => Resolution::Counts,
        }
    }

    /// Of the recordings to fit and the one held out.
    fn families(&self, random: &mut StdRng) -> Vec<Family> {
        match self.blueprint.arm {
            Arm::Poor => return vec![Family::SlowSine; 3],
            Arm::Steps => return vec![Family::SingleStep; 4],
            _ => {}
        }
        // Steps excite everything that is fast; what else there is differs.
        let others: Vec<Family> = RICH.into_iter().filter(|family| *family != Family::Steps).collect();
        let second = others[random.random_range(0..others.len())];
        let third = RICH[random.random_range(0..RICH.len())];
        vec![Family::Steps, second, third]
    }

    fn play(
        &self,
        reference: &[Counts],
        index: usize,
        held_kv_mm: Option<f32>,
        random: &mut StdRng,
    ) -> Result<Vec<Row>, Error> {
        let physics = for_recording(&self.physics, index, random);
        let jitter_s = if self.blueprint.decoy == Some(Decoy::Jitter) { JITTER_S } else { 0.0 };
        let asked_viscosity = self.blueprint.arm == Arm::Steps;
        let seed = random.random();
        let run = Run { physics: &physics, config: &self.config, jitter_s, held_kv_mm, asked_viscosity, seed };
        let mut rows = run.follow(reference)?;
        if self.blueprint.decoy == Some(Decoy::Gaps) {
            lose(&mut rows, random);
        }
        Ok(rows)
    }
}

/// The paper's delay, s.
const PAPERS_DELAY_S: f64 = 0.005;
/// Of that, the dead time beside a lag: the paper's 2 and 3 ms.
const DEAD_OF_BOTH: f64 = 0.4;

/// A fluid that acts at once but for these delays, `size` times the paper's in all, each a little more or less.
fn delayed(effects: &[&'static str], size: f64, physics: &mut Physics, random: &mut StdRng) -> Vec<Concealed> {
    let fluid = &mut physics.fluid;
    (fluid.dead_time_s, fluid.rise_s, fluid.fall_s) = (0.0, 0.0, 0.0);
    let shares: &[f64] = if effects.len() == 2 { &[DEAD_OF_BOTH, 1.0 - DEAD_OF_BOTH] } else { &[1.0] };
    let entries = effects.iter().filter_map(|id| catalogue::find(id));
    let mut one = |(entry, share): (&'static catalogue::Entry, &f64)| {
        let delay_s = PAPERS_DELAY_S * size * share * random.random_range(0.85..1.15);
        entry.put(physics, &[delay_s]);
        let parameters = entry.parameters().iter().map(|id| ((*id).to_owned(), delay_s)).collect();
        Concealed { id: entry.id.to_owned(), in_vocabulary: true, size, strength: delay_s, parameters }
    };
    entries.zip(shares).map(&mut one).collect()
}

/// Loses a few runs of rows, as a full buffer does.
pub(crate) fn lose<T>(rows: &mut Vec<T>, random: &mut StdRng) {
    for _ in 0..4 {
        let from = random.random_range(1..rows.len().max(200) - 100);
        let many = random.random_range(1..60);
        rows.drain(from.min(rows.len())..(from + many).min(rows.len()));
    }
}

pub(crate) fn put(file: &Path, bytes: &[u8]) -> Result<(), Error> {
    std::fs::write(file, bytes).map_err(|error| Error::Write(format!("{}: {error}", file.display())))
}
