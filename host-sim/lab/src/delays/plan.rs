//! Which experiment would tell delay models apart: the flashed law and the plant under each of them, and what the likelihood
//! would say of the recording.

use diagnosis::likelihood::Noise;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::ranking::{Contender, rank};
use er_servo::experiment::{Experiment, Shape};
use rayon::prelude::*;
use serde::Serialize;

use super::contenders::special_cases;
use super::standing::Standing;
use crate::Error;
use crate::asked::recorded;
use crate::progress::Course;
use crate::read::Machine;
use crate::simulate::{Reference, Row, Setup, period_s, record, run};

/// An experiment and what it would bring.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// In words.
    pub name: String,
    /// Flags of `servo-lab simulate`, the scenario first.
    pub flags: String,
    /// Expected log-likelihood difference of the two models that it tells apart least.
    pub difference: f64,
    /// These two: the one that were true, the one that is nearest to it.
    pub pair: (&'static str, &'static str),
    /// Whether only the true one would be left, whichever that is.
    pub separates: bool,
    /// What the flags say, for the drive.
    #[serde(skip)]
    pub experiment: Experiment,
}

/// Seed of the noises of every simulated recording.
const SEED: u32 = 1;

/// The experiments that are weighed: single steps as the paper's, steps to random levels, a sweep, and a dither, each within
/// the 60 degrees of the paper's largest step.
fn experiments() -> Vec<(String, String, Experiment)> {
    let degrees = |degrees: f32| degrees.to_radians();
    let mut all: Vec<(String, String, Experiment)> = [5.0_f32, 10.0, 20.0, 40.0, 60.0]
        .iter()
        .map(|&high| {
            let shape = Shape::Step { amplitude_rad: degrees(high) };
            let flags = format!("step --amplitude-deg {high} --duration-s 2");
            (format!("step of {high} degrees"), flags, Experiment { shape, duration_s: 2.0 })
        })
        .collect();
    for (high, dwell_s) in [(30.0_f32, 0.2_f32), (60.0, 0.1)] {
        let shape = Shape::Steps { amplitude_rad: degrees(high), dwell_s, seed: SEED };
        let flags = format!("steps --amplitude-deg {high} --dwell-s {dwell_s} --duration-s 4 --seed {SEED}");
        let name = format!("steps to random levels within {high} degrees each {dwell_s} s");
        all.push((name, flags, Experiment { shape, duration_s: 4.0 }));
    }
    let sweep = Shape::Chirp { amplitude_rad: degrees(10.0), from_hz: 0.5, to_hz: 8.0 };
    let flags = "chirp --amplitude-deg 10 --low-hz 0.5 --high-hz 8 --duration-s 4".to_owned();
    all.push(("sweep of 10 degrees from 0.5 to 8 Hz".to_owned(), flags, Experiment { shape: sweep, duration_s: 4.0 }));
    let dither = Shape::Multisine { amplitude_rad: degrees(1.0), low_hz: 2.0, high_hz: 20.0, tones: 16 };
    let flags = "multisine --amplitude-deg 1 --low-hz 2 --high-hz 20 --duration-s 4".to_owned();
    all.push(("dither of 1 degree from 2 to 20 Hz".to_owned(), flags, Experiment { shape: dither, duration_s: 4.0 }));
    all
}

/// The models that are left, each ready to be the truth of a simulated recording.
#[derive(Debug)]
pub struct Simulated<'a> {
    machine: &'a Machine,
    nominal: &'a Physics,
    noise: Noise,
    left: Vec<Contender>,
}

/// A name with the points (t, y) of its curve, s and the unit of the axis.
pub type Curve = (&'static str, Vec<(f64, f64)>);

impl<'a> Simulated<'a> {
    /// `noise` is what each recording has; each contender begins at its fitted values.
    pub fn new(machine: &'a Machine, problem: &'a Problem, noise: &[Noise], left: Vec<Contender>) -> Self {
        // The noisiest recording's; what is less than the least that the likelihood counts with is none.
        let sensor = noise.iter().map(|one| one.sensor_sd).fold(0.0, f64::max);
        let density = noise.iter().map(|one| one.torque_density).fold(0.0, f64::max);
        let least = problem.least_sensor_sd;
        let sensor_sd = (sensor * sensor - least * least).max(0.0).sqrt();
        Self { machine, nominal: &problem.nominal, noise: Noise::white(sensor_sd, density), left }
    }

    /// Every experiment with what it would bring, best first: those that separate, then by the difference. It shows how far it is.
    ///
    /// # Errors
    /// A law or a plant that does not take the machine's values.
    pub fn plans(&self, course: &Course) -> Result<Vec<Plan>, Error> {
        let experiments = experiments();
        let count = course.count("what to record next", experiments.len() as u64);
        let weigh = |(name, flags, experiment)| {
            let plan = self.plan(name, flags, experiment);
            count.advance();
            plan
        };
        let mut plans: Vec<Plan> = experiments.into_par_iter().map(weigh).collect::<Result<_, _>>()?;
        plans.sort_by(|a, b| b.separates.cmp(&a.separates).then(b.difference.total_cmp(&a.difference)));
        Ok(plans)
    }

    fn plan(&self, name: String, flags: String, experiment: Experiment) -> Result<Plan, Error> {
        let mut plan = Plan { name, flags, difference: f64::INFINITY, pair: ("", ""), separates: true, experiment };
        for (at, truth) in self.left.iter().enumerate() {
            let problem = self.problem(&self.rows(at, &experiment)?);
            let ranked = rank(&problem, &self.left, || ());
            let total = |name: &str| ranked.iter().find(|one| one.name == name).map(|one| one.step.assessed.total());
            let own = total(truth.name).unwrap_or(f64::NEG_INFINITY);
            // A model that the truth is a special case of is as likely, and simply has more than is needed.
            let another = |name: &str| name != truth.name && !special_cases(name).contains(&truth.name);
            for other in self.left.iter().filter(|other| another(other.name)) {
                let difference = own - total(other.name).unwrap_or(f64::NEG_INFINITY);
                if difference < plan.difference {
                    (plan.difference, plan.pair) = (difference, (truth.name, other.name));
                }
            }
            plan.separates &= ranked.iter().all(|one| Standing::of(&ranked, one).needed == (one.name == truth.name));
        }
        Ok(plan)
    }

    /// The flashed law on the plant under the model at `at`, with the noise of the recordings.
    fn rows(&self, at: usize, experiment: &Experiment) -> Result<Vec<Row>, Error> {
        let config = self.machine.controller.unwrap_or_default();
        let model = self.left[at]
            .starts
            .first()
            .map_or_else(|| self.nominal.model.clone(), |hypothesis| hypothesis.physics(self.nominal).model);
        let period_s = period_s(&config);
        let setup = Setup {
            model,
            config,
            disturbances: Vec::new(),
            // Beside its steps, which the simulation makes itself.
            sensor_noise_rad: self.noise.sensor_sd,
            torque_noise_nm: (self.noise.torque_density / period_s).sqrt(),
            seed: u64::from(SEED),
        };
        run(&setup, Reference::Experiment(*experiment).positions(period_s)?)
    }

    /// The recording of such a run, its positions in the steps of the machine's own sensor where those are coarser.
    fn problem(&self, rows: &[Row]) -> Problem {
        let step = self.machine.axis.resolution;
        let mut recorded = recorded(self.machine, &record("planned", rows));
        if step > f64::from(er_servo::RAD_PER_COUNT) * 1.01 {
            recorded.position.iter_mut().for_each(|position| *position = (*position / step).round() * step);
        }
        Problem::new(self.nominal.clone(), vec![recorded], 1, step, false)
    }

    /// For each model the position in an experiment less that of the first, rad, without noise.
    ///
    /// # Errors
    /// As [`Simulated::plans`].
    pub fn apart(&self, plan: &Plan) -> Result<Vec<Curve>, Error> {
        let quiet = Self { noise: Noise::white(0.0, 0.0), left: self.left.clone(), ..*self };
        let all: Vec<Vec<Row>> =
            (0..self.left.len()).map(|at| quiet.rows(at, &plan.experiment)).collect::<Result<_, _>>()?;
        let curve = |(contender, rows): (&Contender, &Vec<Row>)| {
            let points =
                rows.iter().zip(&all[0]).map(|(own, first)| (own.t_s, own.truth.position - first.truth.position));
            (contender.name, points.collect())
        };
        Ok(self.left.iter().zip(&all).map(curve).collect())
    }
}
