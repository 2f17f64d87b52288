//! The likelihood and the judge on recordings of the plant, where the truth is known.

use std::f64::consts::TAU;

use crate::common::{Making, PLAIN, STEP_RAD, recording, three};
use diagnosis::confidence_set::{Step, assess, intervals};
use diagnosis::effects::{VOCABULARY, find};
use diagnosis::hypothesis::{Hypothesis, Refitted, evaluate, refit};
use diagnosis::physics::Physics;
use diagnosis::pipeline::{diagnose, diagnose_as_read};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::{first_noise, nominal};
use diagnosis::verdict::Verdict;
use diagnosis::windows::WindowFit;
use plant::effects::{Asymmetry, Gravity, Harmonic, Shaft, Vibration};
use plant::sensor::{Sampler, SamplerConfig};
use plant::{Command, Model, Plant, State};

const SECONDS: f64 = 4.0;
/// Of 16 bits, rad.
const ENCODER_RAD: f64 = TAU / 65536.0;

/// Open-loop torques that move either way, rest and reverse.
fn torque(t_s: f64, phase: f64) -> f64 {
    2.5 * (3.1 * t_s + phase).sin()
        + 1.5 * (11.0 * t_s + 2.0 * phase).sin()
        + if (t_s * 1.3) % 1.0 < 0.2 { 0.0 } else { 0.4 }
}

fn machine() -> Model {
    Model { coulomb: 0.5, torque_delay_s: 0.002, ..Model::new(0.05) }
}

fn problem(nominal: Model, actual: &Model, noise_nm: f64) -> Problem {
    seen_by(STEP_RAD, nominal, actual, noise_nm)
}

fn seen_by(step_rad: f64, nominal: Model, actual: &Model, noise_nm: f64) -> Problem {
    made(Making { torque, seconds: SECONDS, noise_nm, step_rad, ..PLAIN }, nominal, actual)
}

fn made(making: Making, nominal: Model, actual: &Model) -> Problem {
    let step_rad = making.step_rad;
    let recordings = three(actual, making);
    Problem::new(Physics::new(nominal), recordings, 2, step_rad, false)
}

#[test]
fn the_belief_follows_the_plant_within_half_a_sensor_step_for_50_ms() {
    // A sensor a thousand times finer, so that the start of a window is known.
    let quiet = seen_by(1e-3 * STEP_RAD, machine(), &machine(), 0.0);
    let found = nominal(&quiet).unwrap();
    let windows = WindowFit::new(&quiet, &found).unwrap();
    let rms = windows.rms(0..3, 0);
    println!("{rms:.2e} rad in windows of 50 ms");
    assert!(rms < 0.5 * STEP_RAD, "{rms} rad");
}

#[test]
fn a_clean_recording_misses_nothing() {
    let found = diagnose(&problem(machine(), &machine(), 0.02), &VOCABULARY).unwrap();
    assert_eq!(found.verdict, Verdict::None, "{:?}", found.effects);
}

#[test]
fn what_is_missing_is_named_with_its_value() {
    let actual = Model { viscous: 0.03, torque_offset: 0.05, ..machine() };
    let found = diagnose(&problem(machine(), &actual, 0.02), &VOCABULARY).unwrap();
    let mut ids: Vec<&str> = found.effects.iter().map(|effect| effect.effect.id).collect();
    ids.sort_unstable();
    assert_eq!(ids, ["torque_offset", "viscous_friction"], "{:?}", found.effects);
    for (id, truth) in [("torque_offset", 0.05), ("viscous_friction", 0.03)] {
        let value = found.effects.iter().find(|effect| effect.effect.id == id).unwrap().intervals[0];
        // Four standard deviations: one seed is no coverage.
        assert!((value.value - truth).abs() < 2.0 * (value.high - value.low), "{id} {value:?}");
        assert!((value.high - value.low) < 0.2 * truth, "{id} {value:?}");
    }
}

#[test]
fn the_same_recordings_give_the_same_answer_on_one_thread_and_many() {
    let problem = problem(machine(), &Model { viscous: 0.03, ..machine() }, 0.02);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| refit(&problem, &Hypothesis::default(), &first_noise(&problem), 3).unwrap())
    };
    let (one, many) = (run(1), run(4));
    assert_eq!(one.noise, many.noise);
    assert_eq!(one.evaluation.blocks, many.evaluation.blocks);
}

#[test]
fn a_machine_that_is_wrong_is_less_likely() {
    let problem = problem(machine(), &machine(), 0.02);
    let noise = nominal(&problem).unwrap().noise;
    let right = evaluate(&problem, &Physics::new(machine()), &noise, 0..2).unwrap().fitted(&problem);
    for wrong in [Model { coulomb: 0.55, ..machine() }, Model { inertia: 0.052, ..machine() }] {
        assert!(evaluate(&problem, &Physics::new(wrong), &noise, 0..2).unwrap().fitted(&problem) < right - 10.0);
    }
}

/// A value is named only where its interval leaves out what it is without the effect.
#[test]
fn an_interval_that_holds_the_nominal_value_is_not_away_from_it() {
    for (viscous, away) in [(0.0, false), (0.03, true)] {
        let problem = problem(machine(), &Model { viscous, ..machine() }, 0.02);
        let start = Hypothesis::default().with(find("viscous_friction").unwrap(), vec![0.01]);
        let fitted = refit(&problem, &start, &first_noise(&problem), 10).unwrap().over_all(&problem).unwrap();
        let assessed = assess(&problem, fitted).unwrap();
        assert_eq!(assessed.away_from_neutral(&problem, 0), away, "{viscous}: {:?}", assessed.refitted.hypothesis);
    }
}

/// A column of torques that are all zero: what is left has no torque to be told by, and no figure of it may be no number.
#[test]
fn without_a_torque_every_figure_of_the_answer_is_a_number() {
    let pushed = Model { torque_offset: 0.8, ..machine() };
    let recordings = problem(machine(), &pushed, 0.02).recordings.to_vec().into_iter().map(|mut recorded| {
        recorded.commands.iter_mut().for_each(|command| command.torque = 0.0);
        recorded
    });
    let problem = Problem::new(Physics::new(machine()), recordings.collect(), 2, STEP_RAD, false);
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    if let Some(left) = &found.remainder {
        assert!(left.torque_rms.is_finite());
        let finite = |rms: Option<f64>| rms.is_none_or(f64::is_finite);
        assert!(left.predictors.iter().all(|one| finite(one.torque_rms)), "{:?}", left.predictors);
    }
}

/// However sure it is: an amplitude has the size of the sine and cosine that it is fitted by.
#[test]
fn what_is_smaller_than_relevant_is_not_away_from_the_nominal_value() {
    for (amplitude, away) in [(1e-3, false), (2e-2, true)] {
        let cogging = vec![Harmonic { amplitude, order: 7.0, phase_rad: 0.4 }];
        let making = Making { torque, noise_nm: 1e-3, step_rad: 1e-7, ..PLAIN };
        let problem = made(making, machine(), &Model { cogging, ..machine() });
        let start = Hypothesis::default().with(find("cogging").unwrap(), vec![7.0, 0.0, 0.0]);
        let found = assess(&problem, refit(&problem, &start, &first_noise(&problem), 10).unwrap()).unwrap();
        let found_amplitude = intervals(&found, 0)[0];
        assert!((found_amplitude.value - amplitude).abs() < 0.1 * amplitude, "{found_amplitude:?}");
        // A fiftieth of a typical change is the least that is known of it.
        let half = 0.5 * (found_amplitude.high - found_amplitude.low);
        assert!((1.9e-3..2.3e-3).contains(&half), "{found_amplitude:?}");
        assert_eq!(found.away_from_neutral(&problem, 0), away, "{amplitude}");
    }
}

#[test]
fn commands_that_are_held_are_no_measurements_half_a_row_late() {
    // Without any delay the torque column may be a measurement; here each torque is held to the next row.
    let prompt = Model { torque_delay_s: 0.0, ..machine() };
    let found = diagnose(&problem(prompt.clone(), &prompt, 0.02), &VOCABULARY).unwrap();
    assert_eq!(found.verdict, Verdict::None, "{:?} {:?}", found.effects, found.remainder);
}

#[test]
fn torque_noise_with_a_memory_is_noise_and_no_physics() {
    let (sd, memory_s) = (0.05, 0.01);
    let making = Making { torque, noise_nm: 0.005, coloured: (sd, memory_s), ..PLAIN };
    let found = diagnose(&made(making, machine(), &machine()), &VOCABULARY).unwrap();
    assert_eq!(found.verdict, Verdict::None, "{:?} {:?}", found.effects, found.remainder);
    for noise in &found.best.assessed.refitted.noise {
        let colour = noise.colour.unwrap();
        // 4 s hold 400 memories: both numbers are known to some 5 to 10 %.
        assert!((colour.sd / sd - 1.0).abs() < 0.25 && (colour.memory_s / memory_s - 1.0).abs() < 0.35, "{colour:?}");
    }
}

/// White noise in its place takes each sample for new evidence: its intervals would hold the truth in half of the cases.
#[test]
fn intervals_know_of_the_memory_of_the_noise() {
    let actual = Model { viscous: 0.03, ..machine() };
    let making = Making { torque, noise_nm: 0.005, coloured: (0.1, 0.02), ..PLAIN };
    let found = diagnose(&made(making, machine(), &actual), &VOCABULARY).unwrap();
    assert_eq!(found.effects.first().unwrap().effect.id, "viscous_friction", "{:?}", found.effects);
    let value = found.effects[0].intervals[0];
    // Four standard deviations: one seed is no coverage.
    assert!((value.value - 0.03).abs() < 2.0 * (value.high - value.low), "{value:?}");
}

/// Every recording goes one way: half the difference of an asymmetry is an offset there, and its slopes are none.
#[test]
fn an_asymmetry_lists_the_offset_that_one_of_its_values_may_be() {
    fn one_way(t_s: f64, seed: f64) -> f64 {
        let way = if seed == 2.0 { -1.0 } else { 1.0 };
        way * (1.2 + 0.6 * (3.1 * t_s + seed).sin() + 0.2 * (17.0 * t_s).sin())
    }
    let asymmetry = Asymmetry { coulomb: 0.2, viscous: 0.02 };
    let nominal = Model { viscous: 0.04, ..machine() };
    let actual = Model { asymmetry, ..nominal.clone() };
    let found = diagnose(&made(Making { torque: one_way, ..PLAIN }, nominal, &actual), &VOCABULARY).unwrap();
    assert_eq!(found.effects.first().map(|named| named.effect.id), Some("friction_asymmetry"), "{:?}", found.effects);
    let equivalent: Vec<&str> = found.effects[0].equivalent.iter().map(|effect| effect.id).collect();
    assert!(equivalent.contains(&"torque_offset"), "{equivalent:?}");
}

/// Every 250th sample is off, by 6 mrad one way or the other.
#[test]
fn the_share_and_the_size_of_wrong_samples_have_intervals() {
    let making = Making { torque, ..PLAIN };
    let recordings = (1..=3).map(|seed| {
        let mut recorded = recording(&machine(), making, seed);
        let wrong = recorded.position.iter_mut().skip(100).step_by(250).enumerate();
        wrong.for_each(|(count, position)| *position += if count % 2 == 0 { 6e-3 } else { -6e-3 });
        recorded
    });
    let problem = Problem::new(Physics::new(machine()), recordings.collect(), 2, STEP_RAD, false);
    let found = diagnose(&problem, &VOCABULARY).unwrap();
    assert_eq!(found.effects.first().map(|named| named.effect.id), Some("sensor_glitch"), "{:?}", found.effects);
    for (interval, truth, most) in
        [(found.effects[0].intervals[0], 0.004, 0.9), (found.effects[0].intervals[1], 6e-3, 1e-3)]
    {
        assert!(interval.low < truth && truth < interval.high, "{interval:?}");
        // 16 wrong samples a recording tell their share to a fifth or so, and their size to the sensor's step.
        assert!(interval.high - interval.low < most * truth, "{interval:?}");
    }
}

/// Friction that falls with speed, by 0.1 N m over 0.4 rad/s, behind so much torque noise, and its refit.
fn falling_friction(noise_nm: f64) -> (Problem, Refitted) {
    let falling = plant::effects::Stribeck { excess: 0.1, velocity: 0.4 };
    let actual = Model { stribeck: Some(falling), ..machine() };
    let problem = problem(machine(), &actual, noise_nm);
    let start = Hypothesis::default().with(find("stribeck_friction").unwrap(), vec![0.1, 0.4]);
    let refitted = refit(&problem, &start, &first_noise(&problem), 10).unwrap();
    (problem, refitted)
}

/// The linearised pass alone, which does not know how friction changes what is known of a rotor that nearly sticks, ended 1.7 units below.
#[test]
fn a_refit_ends_where_the_likelihood_itself_is_flat() {
    let (problem, refitted) = falling_friction(0.2);
    let own = &refitted.hypothesis.entries[0].values;
    let rise = |excess: f64, speed: f64| {
        let moved = Hypothesis::default()
            .with(find("stribeck_friction").unwrap(), vec![excess * own[0], speed * own[1]])
            .physics(&problem.nominal);
        evaluate(&problem, &moved, &refitted.noise, 0..2).unwrap().fitted(&problem) - refitted.log_likelihood
    };
    for (excess, speed) in [(0.8, 1.0), (0.9, 1.0), (1.1, 1.0), (1.0, 0.8), (1.0, 1.2), (0.95, 1.1), (1.1, 0.8)] {
        assert!(rise(excess, speed) < 0.2, "{:.2} at {excess}, {speed}", rise(excess, speed));
    }
}

/// The speed over which friction falls can be larger by more than smaller: the likelihood's own profile falls by two units at 0.44 rad/s,
/// its quadratic at 0.35.
#[test]
fn intervals_end_where_the_likelihood_has_fallen_enough() {
    let (problem, refitted) = falling_friction(0.4);
    let step = Step::new(&problem, refitted).unwrap();
    let linear = intervals(&step.assessed, 0)[1];
    let profiled = intervals(&step.profiled(&problem).assessed, 0)[1];
    assert!(profiled.low < 0.4 && 0.4 < profiled.high, "{profiled:?}");
    assert!(profiled.high - profiled.value > 1.1 * (linear.high - linear.value), "{profiled:?} of {linear:?}");
}

#[test]
fn friction_that_runs_in_is_more_than_friction() {
    let runs_in = |t_s: f64, speed: f64| -0.1 * (-t_s / 1.5).exp() * (speed / 0.02).tanh();
    let found =
        diagnose(&made(Making { torque, beside: runs_in, ..PLAIN }, machine(), &machine()), &VOCABULARY).unwrap();
    assert!(matches!(found.verdict, Verdict::Partial | Verdict::Unknown | Verdict::Ambiguous), "{:?}", found.effects);
    let left = found.remainder.unwrap();
    let first = left.predictors.first().unwrap();
    assert_eq!(first.channel, "time_by_direction", "{:?}", left.predictors);
}

/// From starts with a bristle that is not bent, windows of the right machine were half as far off again as those without it.
#[test]
fn windows_along_a_motion_start_from_what_the_machine_remembers() {
    let prompt = Model { torque_delay_s: 0.0, coulomb: 2.5, ..machine() };
    let stiffness = 500.0;
    let problem = problem(prompt.clone(), &Model { presliding_stiffness: Some(stiffness), ..prompt }, 0.02);
    assert!(problem.band_hz().is_some());
    let noise = first_noise(&problem);
    let [without, with] =
        [Hypothesis::default(), Hypothesis::default().with(find("presliding").unwrap(), vec![stiffness])]
            .map(|hypothesis| WindowFit::new(&problem, &refit(&problem, &hypothesis, &noise, 0).unwrap()).unwrap());
    let gain = with.fall_from(&without, &problem);
    assert!(gain > 0.5, "{gain}");
}

/// Inverse dynamics under test functions of 0.1 s see nothing of it.
#[test]
fn what_rings_at_sixty_hertz_is_found_where_commands_are_held() {
    let prompt = Model { torque_delay_s: 0.0, ..machine() };
    let shaft = Shaft { resonance_hz: 60.0, damping_ratio: 0.05, inertia_ratio: 0.4, gap: 0.0 };
    let actual = Model { shaft: Some(shaft), ..prompt.clone() };
    let problem = problem(prompt, &actual, 0.02);
    assert!(problem.band_hz().unwrap() < 10.0);
    let (read, found) = diagnose_as_read(problem, &VOCABULARY).unwrap();
    assert_eq!(read.band_hz(), None);
    let named = &found.effects[0];
    assert_eq!(named.effect.id, "compliance", "{:?}", found.effects);
    assert!((named.intervals[0].value - 60.0).abs() < 0.6, "{:?}", named.intervals);
}

/// The swing's jerk runs against its speed, so the machine without that friction is likelier half a row early.
#[test]
fn a_missing_friction_does_not_make_samples_of_held_commands() {
    let weight = Gravity { amplitude: 0.6, phase_rad: 0.0 };
    let prompt = Model { coulomb: 0.15, gravity: Some(weight), torque_delay_s: 0.0, ..Model::new(0.02) };
    let recordings = vec![followed(&Model { viscous: 0.05, ..prompt.clone() }, 10_000)];
    let problem = Problem::new(Physics::new(prompt), recordings, 1, ENCODER_RAD, false);
    let (_, found) = diagnose_as_read(problem, &VOCABULARY).unwrap();
    assert_eq!(found.effects.len(), 1, "{:?}", found.effects);
    assert_eq!(found.effects[0].effect.id, "viscous_friction");
    let told = found.effects[0].intervals[0];
    assert!(told.low < 0.05 && 0.05 < told.high && told.high - told.low < 0.002, "{told:?}");
    assert!(found.remainder.is_none(), "{:?}", found.remainder);
}

/// A machine that a PD law makes follow a smooth reference, its torque held for 1 ms.
fn followed(actual: &Model, rows: usize) -> Recorded {
    let reference = |t_s: f64| -> f64 {
        [
            (0.2, 1.0, 3.38),
            (0.43, 0.6, 2.16),
            (0.77, 0.4, 2.32),
            (1.3, 0.25, 2.35),
            (2.1, 0.12, 6.20),
            (3.1, 0.07, 3.98),
        ]
        .map(|(hz, amplitude, phase_rad)| amplitude * (TAU * hz * t_s + phase_rad).sin())
        .iter()
        .sum()
    };
    let mut plant = Plant::new(actual, State::default(), 0.0).unwrap();
    let at_s: Vec<f64> = (0..rows).map(|row| row as f64 * 1e-3).collect();
    let sampler = SamplerConfig { resolution: ENCODER_RAD, noise_sd: 0.1 * ENCODER_RAD, ..SamplerConfig::default() };
    let mut sampler = Sampler::new(sampler, 1).unwrap();
    let (mut position, mut commands) = (Vec::new(), Vec::new());
    for t_s in &at_s {
        let State { position: is, velocity, .. } = *plant.state();
        let command = Command::new(15.0 * (reference(*t_s) - is) - 0.6 * velocity, 0.0);
        position.push(sampler.measure(is));
        commands.push(command);
        plant.advance(&command, t_s + 1e-3).unwrap();
    }
    Recorded {
        name: "1".to_owned(),
        t_s: at_s,
        position,
        commands,
        skipped: vec![false; rows],
        after_gap: vec![false; rows],
    }
}

/// Of what shakes at 17 Hz they see a thirtieth.
#[test]
fn what_shakes_at_seventeen_hertz_is_found_where_the_torque_is_samples() {
    let prompt = Model { torque_delay_s: 0.0, ..machine() };
    let shaking = Vibration { frequency_hz: 17.0, amplitude: 0.2, phase_rad: 0.3 };
    let actual = Model { vibration: Some(shaking), ..prompt.clone() };
    let making = Making { torque, seconds: 2.0, noise_nm: 0.02, ..PLAIN };
    let recordings = three(&actual, making).iter().map(every_other_row).collect();
    let problem = Problem::new(Physics::new(prompt), recordings, 2, STEP_RAD, false);
    assert!(problem.band_hz().unwrap() < 10.0);
    let (read, found) = diagnose_as_read(problem, &VOCABULARY).unwrap();
    assert_eq!(read.band_hz(), None, "{:?} {:?}", found.verdict, found.effects);
    let shaken = found.effects.iter().find(|one| one.effect.id == "vibration").unwrap();
    assert!((shaken.intervals[0].value - 17.0).abs() < 0.05, "{:?}", shaken.intervals);
}

/// What a slower recorder has of it: the torque that acts around its instants.
fn every_other_row(recorded: &Recorded) -> Recorded {
    let rows = || (0..recorded.rows()).step_by(2);
    let around = |row: usize| {
        let (before, behind) = (recorded.commands[row.saturating_sub(1)], recorded.commands[row]);
        Command { torque: 0.5 * (before.torque + behind.torque), ..behind }
    };
    Recorded {
        name: recorded.name.clone(),
        t_s: rows().map(|row| recorded.t_s[row]).collect(),
        position: rows().map(|row| recorded.position[row]).collect(),
        commands: rows().map(around).collect(),
        skipped: rows().map(|row| recorded.skipped[row]).collect(),
        after_gap: rows().map(|row| recorded.after_gap[row]).collect(),
    }
}
