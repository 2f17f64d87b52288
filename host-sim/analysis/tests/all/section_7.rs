//! What the closed loop must show: every figure of control.md section 7, from the law that is flashed.

use crate::common::{PERIOD_S, field, paper, pushed, q_dead, q_lag, shared, step_response, true_speed};
use analysis::simulate::{Row, StepFigures, Summary};
use er_servo::Config;
use plant::FluidResponse;

const STEP_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// The error at which the motor balances Coulomb friction, c/K_P, rad.
const U_RAD: f64 = 0.763 / 240.0;
/// Ticks of one second, as long as the references.
const TICKS: usize = 2000;

struct Case {
    name: &'static str,
    reference: &'static str,
    response: FluidResponse,
    er_enabled: bool,
    settle_ms: f64,
    residual_u: f64,
    dips: usize,
}

fn case(
    name: &'static str,
    reference: &'static str,
    response: FluidResponse,
    settle_ms: f64,
    residual_u: f64,
    dips: usize,
) -> Case {
    Case { name, reference, response, er_enabled: name != "ER off", settle_ms, residual_u, dips }
}

/// The eight rows of the table.
fn cases() -> Vec<Case> {
    vec![
        case("ER off", "loop_er_off.csv", field(0.0, 0.0), 89.0, 0.999, 0),
        case("none", "loop_none.csv", field(0.0, 0.0), 89.5, 1.036, 0),
        case("Q dead 5 ms", "loop_q_dead_5.csv", q_dead(0.005), 94.0, 1.023, 0),
        case("Q dead 50 ms", "loop_q_dead_50.csv", q_dead(0.05), 126.5, 1.005, 3),
        case("Q lag 5 ms", "loop_q_lag_5.csv", q_lag(0.005), 97.0, 1.027, 0),
        case("E dead 5 ms", "loop_e_dead_5.csv", field(0.005, 0.0), 89.0, 1.002, 9),
        case("E lag 5 ms", "loop_e_lag_5.csv", field(0.0, 0.005), 89.0, 1.032, 1),
        case("E dead 2 + lag 3 ms", "loop_e_dead2_lag3.csv", field(0.002, 0.003), 89.0, 1.014, 7),
    ]
}

fn response(case: &Case, hold: bool) -> Vec<Row> {
    let config = Config { er_enabled: case.er_enabled, hold, ..true_speed() };
    step_response(paper(case.response), config, STEP_RAD, TICKS)
}

fn figures(rows: &[Row]) -> StepFigures {
    let summary = Summary::of(rows, PERIOD_S);
    assert!(!summary.faulted);
    summary.step.unwrap()
}

#[test]
fn the_table_of_step_responses() {
    for case in cases() {
        let step = figures(&response(&case, false));
        let (settle_ms, residual_u) = (1e3 * step.settling_s.unwrap(), step.residual_rad / U_RAD);
        println!(
            "{:<20} overshoot {:.3} %  settle {settle_ms:.1} ({})  residual {residual_u:.4} u ({})  dips {} ({})",
            case.name,
            100.0 * step.overshoot,
            case.settle_ms,
            case.residual_u,
            step.speed_dips,
            case.dips
        );
        assert_eq!(step.overshoot, 0.0, "{}", case.name);
        assert!((settle_ms - case.settle_ms).abs() <= 2.0, "{}: settles in {settle_ms} ms", case.name);
        assert!((residual_u - case.residual_u).abs() <= 0.03, "{}: residual {residual_u} u", case.name);
        match case.name {
            "E dead 5 ms" => assert!(step.speed_dips >= 6, "{} dips", step.speed_dips),
            "none" | "Q dead 5 ms" => assert_eq!(step.speed_dips, 0, "{}", case.name),
            _ => {}
        }
    }
}

/// The rows with position and speed of the reference run in place of ours; its columns in the order they stand.
fn reference_rows(file: &std::path::Path, rows: &[Row]) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let header = reader.headers().unwrap().clone();
    assert_eq!(header.iter().take(3).collect::<Vec<_>>(), ["t_s", "position_rad", "velocity_rad_s"]);
    let truths = reader.records().map(|record| {
        let record = record.unwrap();
        let number = |column: usize| record[column].parse::<f64>().unwrap();
        plant::State::new(number(1), number(2))
    });
    rows.iter().zip(truths).map(|(row, truth)| Row { truth, ..*row }).collect()
}

#[test]
fn the_reference_runs() {
    let Some(folder) = shared("reference") else { return };
    for case in cases() {
        let ours = response(&case, false);
        let theirs = reference_rows(&folder.join(case.reference), &ours);
        assert_eq!(theirs.len(), TICKS);
        let (mine, other) = (figures(&ours), figures(&theirs));
        let distance = |value: fn(&Row) -> f64| {
            ours.iter().zip(&theirs).map(|(a, b)| (value(a) - value(b)).abs()).fold(0.0, f64::max)
        };
        let (position_rad, speed_rad_s) = (distance(|row| row.truth.position), distance(|row| row.truth.velocity));
        println!(
            "{:<20} position within {position_rad:.1e} rad, speed within {speed_rad_s:.1e} rad/s; dips {} ({})",
            case.name, mine.speed_dips, other.speed_dips
        );
        let settle_ms = 1e3 * (mine.settling_s.unwrap() - other.settling_s.unwrap());
        assert!(settle_ms.abs() <= 2.0, "{}: {settle_ms} ms", case.name);
        assert!((mine.residual_rad - other.residual_rad).abs() <= 0.03 * U_RAD, "{}", case.name);
        assert_eq!((mine.overshoot, mine.speed_dips), (other.overshoot, other.speed_dips), "{}", case.name);
    }
}

#[test]
fn hold_sticks_far_from_the_reference_where_the_field_is_delayed() {
    for case in cases().into_iter().filter(|case| case.er_enabled) {
        let residual_u = figures(&response(&case, true)).residual_rad / U_RAD;
        println!("hold, {:<20} residual {residual_u:.4} u", case.name);
        let bounds = match case.name {
            name if name.starts_with("E ") => 1.97..=2.03,
            // It stops as it does without `hold`, at the 1.005 u of the table, and so below what the text says of it.
            "Q dead 50 ms" => 1.0..=1.01,
            _ => 1.02..=1.04,
        };
        assert!(bounds.contains(&residual_u), "{}: {residual_u} u", case.name);
    }
}

/// Overshoot, %, of a step of 5.5 mrad with the gains for L = 2 ms on a plant that takes 4.4 ms.
///
/// The figures of the specification come from the integration that made the references, whose position is off by up to
/// 4e-6 rad with these fluids (`the_reference_runs` prints it); that is 0.07 % of this step.
const OVERSHOOT_TOLERANCE: f64 = 0.05;

#[test]
fn a_plant_slower_than_its_gains_overshoots() {
    let (gain_delay_s, inertia) = (0.002_f32, 0.075_f32);
    let config = Config {
        kp_nm_rad: 0.08 * inertia / gain_delay_s.powi(2),
        kd_nm_s_rad: 0.464 * inertia / gain_delay_s,
        ..true_speed()
    };
    let rows = [
        ("off", field(0.0, 0.0), 14.8),
        ("none", field(0.0, 0.0), 0.0),
        ("E dead 5 ms", field(0.005, 0.0), 1.47),
        ("E dead 2 + lag 3 ms", field(0.002, 0.003), 3.43),
        ("E lag 5 ms", field(0.0, 0.005), 4.23),
    ];
    for (name, response, expected) in rows {
        let model = plant::Model { torque_delay_s: 0.0044, ..paper(response) };
        let config = Config { er_enabled: name != "off", ..config };
        let overshoot = 100.0 * figures(&step_response(model, config, 0.0055, TICKS)).overshoot;
        println!("{name:<20} overshoot {overshoot:.3} % ({expected})");
        assert!((overshoot - expected).abs() <= OVERSHOOT_TOLERANCE, "{name}: {overshoot} %");
    }
}

#[test]
fn a_push_of_8_nm_for_50_ms() {
    let rows = [
        ("off", Config { er_enabled: false, ..true_speed() }, 28.54),
        ("damper only", Config { near_rad: 0.0, ..true_speed() }, 25.35),
        ("with brake", true_speed(), 20.46),
    ];
    for (name, config, expected_mrad) in rows {
        let rows = pushed(paper(field(0.0, 0.0)), config, 1000);
        let peak_mrad = rows.iter().map(|row| 1e3 * row.truth.position.abs()).fold(0.0, f64::max);
        println!("{name:<12} peak {peak_mrad:.3} mrad ({expected_mrad})");
        assert!((peak_mrad - expected_mrad).abs() <= 0.01, "{name}: {peak_mrad} mrad");
    }
}
