//! The viscosity models against the closed-loop references. The law is written out here in a few lines because the plant
//! knows none; its equations are those of the control specification, sections 2 to 4, with the true speed.

use std::path::PathBuf;

use plant::{Command, Er, FieldResponse, FluidResponse, Model, Plant, State};

/// Position, rad, and speed, rad/s. A viscosity of 55 N m s/rad takes 1.8 % of the speed in each 25 us step of the
/// references, whose own error is therefore larger than with the field models: twice the top speed times a step.
const STIFF_TOLERANCE: (f64, f64) = (2.5e-4, 5e-2);

const REFERENCE_RAD: f64 = 30.0 * std::f64::consts::PI / 180.0;

fn law(state: &State) -> Command {
    let (e, w) = (REFERENCE_RAD - state.position, state.velocity);
    let (k_p, k_d) = (0.08 * 0.075 / 0.005_f64.powi(2), 0.464 * 0.075 / 0.005);
    let torque = (k_p * e - k_d * w).clamp(-30.0, 30.0);
    let speed = w.abs();
    let braking = e.abs() < 0.02 && e * w < 0.0;
    let (a, b) = (0.0704, 0.470);
    let q = (3.675 * speed * speed - 9.277 * speed + 4.010).exp();
    let field_kv_mm = if speed > 1.5 {
        0.0
    } else if braking {
        3.0
    } else {
        -b / (2.0 * a) + ((b * b / (4.0 * a) + q * speed) / a).sqrt()
    };
    Command {
        torque,
        field_kv_mm: field_kv_mm.clamp(0.0, 3.5),
        braking,
        speed_estimate: w,
        viscosity: Some(if speed > 1.5 { 0.0 } else { q }),
        external_torque: 0.0,
    }
}

fn check(name: &str, response: FluidResponse, tolerance: (f64, f64)) {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let candidates = ["../../../shared/reference", "../../../../shared/reference"].map(|up| folder.join(up).join(name));
    let Some(path) = candidates.iter().find(|path| path.exists()) else {
        println!("skipped: no reference {name} beside the repository");
        return;
    };
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let (t, p, v) = (column("t_s"), column("position_rad"), column("velocity_rad_s"));
    let rows: Vec<[f64; 3]> =
        reader.records().map(|row| [t, p, v].map(|i| row.as_ref().unwrap()[i].parse().unwrap())).collect();
    let model = Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() };
    let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
    let (mut position, mut speed) = (0.0_f64, 0.0_f64);
    for (index, row) in rows.iter().enumerate() {
        position = position.max((plant.state().position - row[1]).abs());
        speed = speed.max((plant.state().velocity - row[2]).abs());
        if let Some(next) = rows.get(index + 1) {
            plant.advance(&law(plant.state()), next[0]).unwrap();
        }
    }
    println!("{name}: position within {position:.1e} rad, speed within {speed:.1e} rad/s, {} samples", rows.len());
    assert!(position < tolerance.0 && speed < tolerance.1, "{name}: {position:e} rad, {speed:e} rad/s");
}

#[test]
fn viscosity_models_follow_the_references() {
    let torque_limit = f64::INFINITY;
    for (name, dead_time_s) in [("loop_q_dead_5.csv", 0.005), ("loop_q_dead_50.csv", 0.05)] {
        check(name, FluidResponse::ViscosityDeadTime { dead_time_s, torque_limit }, STIFF_TOLERANCE);
    }
    check("loop_q_lag_5.csv", FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit }, STIFF_TOLERANCE);
}

#[test]
fn field_models_follow_the_references() {
    let field = |dead_s: f64, lag_s: f64| FluidResponse::Field(FieldResponse::new(dead_s, lag_s));
    for (name, dead_s, lag_s) in [
        ("loop_none.csv", 0.0, 0.0),
        ("loop_e_dead_5.csv", 0.005, 0.0),
        ("loop_e_lag_5.csv", 0.0, 0.005),
        ("loop_e_dead2_lag3.csv", 0.002, 0.003),
    ] {
        check(name, field(dead_s, lag_s), (1e-5, 2e-3));
    }
}
