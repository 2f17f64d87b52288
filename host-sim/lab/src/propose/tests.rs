//! Proposals against the plant.
#![allow(clippy::unwrap_used)]

use diagnosis::effects::find;
use diagnosis::hypothesis::{Hypothesis, refit};
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use er_servo::Config;

use super::*;
use crate::read::{Axis, ErNominal, PlantNominal};
use crate::simulate::{Reference, Setup, record, run};

const COUNT_RAD: f64 = std::f64::consts::TAU / 491_520.0;
const TORQUE_NOISE_NM: f64 = 0.05;
const PERIOD_S: f64 = 5e-4;

fn machine() -> Machine {
    Machine {
        file: "machine.toml".into(),
        name: "er-dd-servo".to_owned(),
        axis: Axis { kind: AxisKind::Rotary, sample_period_s: PERIOD_S, resolution: COUNT_RAD },
        plant: PlantNominal {
            inertia: 0.075,
            coulomb: 0.763,
            viscous: 0.0,
            torque_gain: 1.0,
            torque_offset: 0.0,
            torque_limit: Some(30.0),
            sample_to_output_s: 0.0,
            torque_delay_s: 0.005,
            er: Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003, fluid: None }),
        },
        controller: Some(Config::default()),
        columns: Default::default(),
        effects: Vec::new(),
    }
}

fn rival(id: &str, value: f64) -> Hypothesis {
    Hypothesis::default().with(find(id).unwrap(), vec![value])
}

fn request<'a>(machine: &'a Machine, rivals: &'a [Hypothesis]) -> Request<'a> {
    let noise = Noise::white(COUNT_RAD / 12.0_f64.sqrt(), TORQUE_NOISE_NM * TORQUE_NOISE_NM * PERIOD_S);
    Request { machine, rivals, limits: Limits::of(machine, &[]), noise, as_commands: false }
}

/// Whether the log-likelihood of the proposed recording, made on the first rival with noise, excludes the second, both refitted.
fn told_apart(request: &Request<'_>, proposal: &Proposal, seed: u64) -> bool {
    let nominal = Physics::nominal(request.machine, &[]);
    let setup = Setup {
        model: request.rivals[0].physics(&nominal).model_of(0),
        config: Config::default(),
        disturbances: Vec::new(),
        sensor_noise_rad: 0.0,
        torque_noise_nm: TORQUE_NOISE_NM,
        seed,
    };
    let (t_s, reference_rad) = proposal.reference.iter().copied().unzip();
    let reference = Reference::Samples { t_s, reference_rad };
    let recording = record("next.csv", &run(&setup, reference.positions(PERIOD_S).unwrap()).unwrap());
    let problem = Problem::new(nominal, vec![Recorded::new(&recording)], 1, COUNT_RAD, false);
    let fitted = |rival: &Hypothesis| refit(&problem, rival, &[request.noise], 6).unwrap().log_likelihood;
    // A difference of log-likelihoods of standard deviation d and mean d^2 / 2, at the level of the set.
    let predicted = proposal.pairs[0].separation.distance;
    fitted(&request.rivals[0]) - fitted(&request.rivals[1]) > 1.645 * predicted.min(20.0)
}

#[test]
fn gain_and_inertia_and_lag_and_dead_time_are_told_apart_as_predicted() {
    let machine = machine();
    let pairs = [
        ([("torque_gain", 0.93), ("inertia", 0.0806)], true),
        ([("field_lag", 0.008), ("field_dead_time", 0.007)], true),
        // Five microseconds: below what this noise lets anything see.
        ([("field_lag", 0.003_005), ("field_dead_time", 0.002_005)], false),
    ];
    for (pair, seen) in pairs {
        let rivals = pair.map(|(id, value)| rival(id, value));
        let request = request(&machine, &rivals);
        let proposal = best(&request).unwrap();
        println!("{} {:?}", proposal.text, proposal.pairs);
        assert_eq!(proposal.pairs[0].separation.power() > 0.9, seen, "{}", proposal.text);
        if seen {
            let found = (1..=2).filter(|seed| told_apart(&request, &proposal, *seed)).count();
            assert_eq!(found, 2, "{}", proposal.text);
        }
        assert_eq!(best(&request).unwrap(), proposal, "the same request gives the same proposal");
    }
}

#[test]
fn where_no_motion_tells_another_measurement_is_named() {
    let machine = machine();
    let rivals = [rival("torque_gain", 1.0 - 1e-7), rival("inertia", 0.075 * (1.0 + 1e-7))];
    let proposal = best(&request(&machine, &rivals)).unwrap();
    assert!(proposal.reference.is_empty() && proposal.text.contains("weigh"), "{}", proposal.text);
}

#[test]
fn the_file_is_the_reference_that_was_predicted_with() {
    let machine = machine();
    let rivals = [rival("inertia", 0.08), rival("viscous_friction", 0.1)];
    let proposal = best(&request(&machine, &rivals)).unwrap();
    let text = reference_csv(AxisKind::Rotary, &proposal.reference);
    let read = Reference::from_csv_bytes("next.csv".as_ref(), text.as_bytes()).unwrap();
    let (t_s, reference_rad) = proposal.reference.iter().copied().unzip();
    assert_eq!(read, Reference::Samples { t_s, reference_rad }, "to the bit");
    let built_in: Vec<_> =
        Reference::Experiment(proposal.menu[0].item.experiment).positions(PERIOD_S).unwrap().collect();
    let sampled: Vec<_> = read.positions(PERIOD_S).unwrap().collect();
    assert_eq!(sampled[..built_in.len()], built_in, "`simulate` follows the experiment of the firmware");
}

#[test]
fn limits_hold_and_a_linear_axis_without_controller_is_proposed_for() {
    let machine = Machine {
        axis: Axis { kind: AxisKind::Linear, sample_period_s: 1e-3, resolution: 1e-6 },
        plant: PlantNominal { inertia: 95.0, coulomb: 20.0, viscous: 200.0, er: None, ..machine().plant },
        controller: None,
        ..machine()
    };
    let rivals = [rival("inertia", 99.0), rival("viscous_friction", 220.0)];
    let limits = Limits { speed: 0.3, torque: 120.0, travel: 0.2 };
    let noise = Noise::white(3e-7, 1e-3);
    let request = Request { machine: &machine, rivals: &rivals, limits, noise, as_commands: false };
    let proposal = best(&request).unwrap();
    println!("{} {:?}", proposal.text, proposal.pairs);
    let (low, high) = proposal.reference.iter().fold((0.0_f64, 0.0_f64), |(l, h), row| (l.min(row.1), h.max(row.1)));
    assert!(high > low && high - low <= 0.2, "{low} to {high} m");
    let drive = Loop::of(&machine, &limits);
    let right = rivals[0].physics(&Physics::nominal(&machine, &[]));
    for offer in &proposal.menu {
        let motion = drive.motion(&right, &offer.item).unwrap();
        assert!(limits.allow(&motion.asked), "{}: {:?}", offer.item.name, motion.asked);
        let name = offer.item.name;
        assert!(!name.contains("brake") && !name.contains("field"), "the axis has neither: {name}");
    }
    assert!(best(&Request { rivals: &rivals[..1], ..request }).is_none(), "one model has no rival");
    // Eight seconds of such a period would be eight trillion rows.
    let hasty = Machine { axis: Axis { sample_period_s: 1e-12, ..machine.axis.clone() }, ..machine.clone() };
    assert_eq!(Loop::of(&hasty, &limits).period_s(), 1e-4);
}
