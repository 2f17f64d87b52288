//! Cases of machines that are drawn whole: the machine, its log, its controller, its noise, and effects in sizes of what the motion
//! can tell.
//!
//! `setting` draws the machine, `motion` runs it, `information` weighs what an effect adds to that motion, `sizes` puts
//! effects in at multiples of what can be told, `shown` weighs them again on the motion that they make, `files` writes what the drive
//! would have logged.

mod controller;
mod files;
mod information;
mod motion;
mod setting;
mod shown;
mod sizes;
mod vocabulary;

use std::path::Path;

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

use self::files::Kept;
use self::information::{Deviations, Motion};
use self::motion::{Loop, Sample};
use self::setting::{Law, Setting};
use self::shown::AtWork;
use self::sizes::Chosen;
use crate::Error;
use crate::case::{EXPERIMENT, FITTED, HELD_OUT, MACHINE, lose, put};
use crate::catalogue::for_recording;
use crate::outside::Scales;
use crate::physics::Physics;
use crate::plan::{Arm, Decoy, Drawn};
use crate::reference::{Family, RICH, from_csv_rad};
use crate::rotor::STEP_S;
use crate::seal::{Concealed, MachineTruth, Truth};

/// Machines drawn for a seed before it is given up: most are taken at the first or second.
const ATTEMPTS: u64 = 200;
/// Smallest torque and way of a motion that can tell anything, over the noise and the step of the sensor.
const LEAST_TRAVEL_STEPS: f64 = 100.0;

/// A case of the drawn plan.
#[derive(Debug, Clone)]
pub struct Case {
    /// The seed.
    pub seed: u64,
    /// Its place in the plan.
    pub blueprint: Drawn,
    /// What is concealed.
    pub truth: Truth,
    setting: Setting,
    /// With noise and effects.
    physics: Physics,
    coloured: Option<(f64, f64)>,
    gain_error: f64,
    kept: Kept,
    families: [Family; 3],
    /// Of the recordings' references and noise.
    recorded: u64,
    random: StdRng,
}

impl Case {
    /// Draws the case of a seed.
    ///
    /// # Errors
    /// No machine of many that can be run with such an effect; no family left that was never used.
    pub fn draw(seed: u64) -> Result<Self, Error> {
        Self::of(seed, Drawn::of(seed)?)
    }

    /// Draws a case of any blueprint of the drawn plan.
    ///
    /// # Errors
    /// As [`Self::draw`].
    pub fn of(seed: u64, blueprint: Drawn) -> Result<Self, Error> {
        let attempt = |attempt: u64| {
            let mut random = StdRng::seed_from_u64(seed ^ attempt.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            Self::attempt(seed, &blueprint, &mut random)
        };
        (0..ATTEMPTS).find_map(attempt).ok_or(Error::NoMachine { seed })
    }

    fn attempt(seed: u64, blueprint: &Drawn, random: &mut StdRng) -> Option<Self> {
        let setting = Setting::draw(blueprint.arm == Arm::Controller, random);
        let families = families(blueprint, random);
        let quiet = Base::run(&setting, &setting.physics, None, &families, random.random())?;
        let scales = quiet.scales(&setting)?;
        let (physics, coloured) = with_noise(&setting, &scales);
        let base = Base::run(&setting, &physics, coloured, &families, random.random())?;
        let measured = setting.measured.map_or(0.0, |law| law.noise_share);
        let noise = Deviations {
            white: physics.torque_noise_nm * (1.0 + measured * measured).sqrt(),
            coloured,
            sensor: physics.sensor.noise_rad.hypot(kept_step(&setting, blueprint) / 12.0_f64.sqrt()),
        };
        let motions: Vec<Motion<'_>> =
            base.rows.iter().map(|rows| Motion::new(&setting, &physics, rows, noise)).collect();
        let chosen = sizes::choose(blueprint, &setting, &scales, &motions, random)?;
        let concealed = chosen.conceal(&physics);
        // The machine must still run with them: a motion that is lost is no recording.
        let recorded = random.random();
        let base = Base::run(&setting, &concealed, coloured, &families, recorded)?;
        let noise_left = motions.last()?.noise_left(random.random());
        let at_work = AtWork { setting: &setting, physics: &physics, noise, base: &base, noise_left };
        let chosen = at_work.shown(chosen)?;
        let mut case = Self {
            seed,
            blueprint: blueprint.clone(),
            truth: truth(seed, blueprint, &setting, &scales, &chosen, &physics),
            kept: kept(&setting, blueprint, measured * physics.torque_noise_nm),
            gain_error: match blueprint.arm {
                Arm::Controller => {
                    if random.random_bool(0.5) {
                        0.95
                    } else {
                        1.05
                    }
                }
                _ => 1.0,
            },
            setting,
            physics: concealed,
            coloured,
            families,
            recorded,
            random: random.clone(),
        };
        case.truth.salt = format!("{:032x}", case.random.random::<u128>());
        Some(case)
    }

    /// Simulates the recordings and writes them with the machine file into a folder that is there.
    ///
    /// # Errors
    /// A motion that is lost, a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let mut random = self.random.clone();
        put(&folder.join(MACHINE), files::machine(&self.setting, self.kept).as_bytes())?;
        for (index, name) in FITTED.into_iter().chain([HELD_OUT]).enumerate() {
            let draws = Draws::of(self.recorded, index);
            let reference = reference(&self.setting, self.families[index], &mut draws.reference());
            self.record(&folder.join(name), &reference, index, &draws, &mut random)?;
        }
        Ok(())
    }

    /// Plays an experiment's reference (the text of a CSV file) on the same machine, twice.
    ///
    /// # Errors
    /// A reference that is none, a motion that is lost, a file that cannot be written.
    pub fn write_experiment(&self, reference: &str, folder: &Path) -> Result<(), Error> {
        let mut random = StdRng::seed_from_u64(self.seed ^ 0x5eed);
        let reference = from_csv_rad(reference, self.setting.period_s)?;
        for (index, name) in EXPERIMENT.into_iter().enumerate() {
            let draws = Draws::of(random.random(), index);
            self.record(&folder.join(name), &reference, 1 + index, &draws, &mut random)?;
        }
        Ok(())
    }

    fn record(
        &self,
        file: &Path,
        reference: &[f64],
        index: usize,
        draws: &Draws,
        random: &mut StdRng,
    ) -> Result<(), Error> {
        let physics = for_recording(&self.physics, index, &mut draws.physics());
        let (coloured, gain_error) = (self.coloured, self.gain_error);
        let seed = draws.noise();
        let run = Loop { setting: &self.setting, physics: &physics, coloured, gain_error, step_s: STEP_S, seed };
        let mut rows = run.follow(reference)?;
        if self.blueprint.decoy == Some(Decoy::Gaps) {
            lose(&mut rows, random);
        }
        put(file, &files::csv(&rows, &self.setting, self.kept, random)?)
    }
}

/// What is drawn for one recording, each part by itself: the same at any step of the integrator, for any machine.
struct Draws(u64);

impl Draws {
    fn of(seed: u64, index: usize) -> Self {
        Self(StdRng::seed_from_u64(seed.wrapping_add(index as u64)).random())
    }

    /// The reference's.
    fn reference(&self) -> StdRng {
        StdRng::seed_from_u64(self.0)
    }

    /// Of what differs from recording to recording in the machine.
    fn physics(&self) -> StdRng {
        StdRng::seed_from_u64(self.0.wrapping_add(1))
    }

    /// Seed of every noise.
    fn noise(&self) -> u64 {
        self.0.wrapping_add(2)
    }
}

/// The three recordings of a machine at the coarse step.
struct Base {
    seed: u64,
    rows: Vec<Vec<Sample>>,
}

impl Base {
    fn run(
        setting: &Setting,
        physics: &Physics,
        coloured: Option<(f64, f64)>,
        families: &[Family; 3],
        seed: u64,
    ) -> Option<Self> {
        let mut base = Self { seed, rows: Vec::new() };
        for (index, family) in families.iter().enumerate() {
            let draws = Draws::of(seed, index);
            let reference = reference(setting, *family, &mut draws.reference());
            let (physics, seed, step_s) = (base.physics(physics, index), draws.noise(), information::STEP_S);
            let run = Loop { setting, physics: &physics, coloured, gain_error: 1.0, step_s, seed };
            base.rows.push(run.follow(&reference).ok()?);
        }
        Some(base)
    }

    /// A machine as it is in one of these recordings.
    fn physics(&self, physics: &Physics, index: usize) -> Physics {
        for_recording(physics, index, &mut Draws::of(self.seed, index).physics())
    }

    /// Typical values; none where the axis hardly moves.
    fn scales(&self, setting: &Setting) -> Option<Scales> {
        let all = || self.rows.iter().flatten();
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
            (sum / f64::from(count.max(1))).sqrt()
        };
        let fastest = all().fold(0.0_f64, |most, row| most.max(row.speed.abs()));
        let ends = all().fold([0.0_f64, 0.0], |[low, high], row| [low.min(row.position), high.max(row.position)]);
        let scales = Scales {
            torque: rms(&mut all().map(|row| row.drive)),
            speed: rms(&mut all().map(|row| row.speed).filter(|speed| speed.abs() > 0.02 * fastest)),
            travel: 0.5 * (ends[1] - ends[0]),
            duration_s: setting.duration_s,
            period_s: setting.period_s,
            inertia: setting.physics.inertia_kg_m2,
            coulomb: setting.physics.friction.coulomb_nm,
            field_kv_mm: all().fold(0.0, |most, row| most.max(row.command.field_kv_mm)),
        };
        let moves = scales.travel > LEAST_TRAVEL_STEPS * setting.step && scales.torque > 0.0;
        // A controller that rattles is no machine in use: most of the torque is not of the reference's time scale.
        let turns = all().zip(all().skip(1)).filter(|(a, b)| a.command.torque_nm * b.command.torque_nm < 0.0).count();
        (moves && turns * 20 < all().count()).then_some(scales)
    }
}

/// The machine's noise in its units.
fn with_noise(setting: &Setting, scales: &Scales) -> (Physics, Option<(f64, f64)>) {
    let noise = &setting.noise;
    let mut physics = setting.physics.clone();
    physics.torque_noise_nm = noise.white * scales.torque;
    physics.sensor.noise_rad = noise.sensor_steps * setting.step;
    physics.ripple = noise.ripple.map(|mut wave| {
        wave.amplitude *= scales.torque;
        wave
    });
    (physics, noise.coloured.map(|(share, memory_s)| (share * scales.torque, memory_s)))
}

/// What the log keeps, with noise on a measured torque.
fn kept(setting: &Setting, blueprint: &Drawn, torque_noise: f64) -> Kept {
    // A log too coarse to replay the law comes without a controller to check.
    let controller = matches!(setting.law, Law::Servo(_)) && blueprint.decoy != Some(Decoy::TwelveBits);
    Kept { step: kept_step(setting, blueprint), controller, torque_noise }
}

/// Step of the position in the log: where that is to mislead, twelve bits of a turn or of three times the travel.
fn kept_step(setting: &Setting, blueprint: &Drawn) -> f64 {
    let range = if setting.linear { 1.5 * setting.travel } else { std::f64::consts::TAU };
    if blueprint.decoy == Some(Decoy::TwelveBits) { setting.step.max(range / 4096.0) } else { setting.step }
}

/// Of the recordings to fit and the one held out.
fn families(blueprint: &Drawn, random: &mut StdRng) -> [Family; 3] {
    if blueprint.arm == Arm::Poor {
        return [Family::SlowSine; 3];
    }
    let mut rich = || RICH[random.random_range(0..RICH.len())];
    // Steps excite everything that is fast; what else there is differs.
    let second = loop {
        let family = rich();
        if family != Family::Steps {
            break family;
        }
    };
    [Family::Steps, second, rich()]
}

/// A reference in rad or m: the family's, in this machine's way and time.
fn reference(setting: &Setting, family: Family, random: &mut StdRng) -> Vec<f64> {
    let (slower, travel) = (setting.slower, setting.travel);
    let rows = family.draw_rad(setting.duration_s / slower, setting.period_s / slower, random);
    rows.into_iter().map(|at| travel * at).collect()
}

fn truth(
    seed: u64,
    blueprint: &Drawn,
    setting: &Setting,
    scales: &Scales,
    chosen: &Chosen,
    physics: &Physics,
) -> Truth {
    let effects: Vec<Concealed> = chosen.effects.iter().map(|one| one.sealed(setting.linear)).collect();
    Truth {
        seed,
        arm: blueprint.arm,
        decoy: blueprint.decoy,
        effects,
        torque_noise_nm: physics.torque_noise_nm,
        sensor_noise_rad: physics.sensor.noise_rad,
        salt: String::new(),
        machine: Some(MachineTruth {
            linear: setting.linear,
            period_s: setting.period_s,
            inertia: scales.inertia,
            torque_rms: scales.torque,
            speed_rms: scales.speed,
            travel: scales.travel,
            step: setting.step,
            fluid: setting.has_fluid(),
            flashed_law: matches!(setting.law, Law::Servo(_)),
            measured_torque: setting.measured.is_some(),
            skew_s: setting.measured.map_or(0.0, |law| law.skew_s),
            families: chosen.effects.iter().filter_map(|one| one.family()).map(str::to_owned).collect(),
            beside: beside(setting),
            ripple_order: setting.noise.ripple.map(|wave| wave.order_per_rev),
        }),
    }
}

/// Effects that stand for what belongs to the log or the noise.
fn beside(setting: &Setting) -> Vec<String> {
    let mut beside = Vec::new();
    if setting.measured.is_some() {
        // The torque of the instant stands where a command that is held would: half a row, and what was drawn.
        beside.extend(["channel_skew", "sensor_latency", "torque_delay", "torque_lag"].map(str::to_owned));
    }
    if setting.noise.ripple.is_some() {
        beside.push("cogging".to_owned());
    }
    beside
}
