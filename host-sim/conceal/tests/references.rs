//! The generator against responses computed by a separate implementation in another language, and against itself at a
//! finer step.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::PathBuf;

use conceal::physics::{FluidDelay, Physics};
use conceal::rotor::{Command, Rotor, STEP_S};

const STEPS: usize = 200;

/// Columns by name.
fn read(name: &str, columns: &[&str]) -> Option<Vec<Vec<f64>>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let places = ["../../../shared/reference", "../../../../shared/reference"].map(|up| folder.join(up).join(name));
    let Some(path) = places.iter().find(|path| path.exists()) else {
        println!("skipped: no reference {name} beside the repository");
        return None;
    };
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let at: Vec<usize> = columns.iter().map(|name| header.iter().position(|cell| cell == *name).unwrap()).collect();
    let rows = reader.records().map(Result::unwrap);
    Some(rows.map(|row| at.iter().map(|i| row[*i].parse().unwrap()).collect()).collect())
}

fn physics(delay_s: f64, dead_time_s: f64, lag_s: f64, delay: FluidDelay) -> Physics {
    let mut physics = Physics::nominal();
    physics.drive.delay_s = delay_s;
    (physics.fluid.dead_time_s, physics.fluid.rise_s, physics.fluid.fall_s) = (dead_time_s, lag_s, lag_s);
    physics.fluid.delay = delay;
    // The references of the viscosity models have no bound.
    physics.fluid.viscous_limit_kv_mm = f64::INFINITY;
    physics
}

#[test]
fn open_loop_follows_the_references_and_converges() {
    let cases = [
        ("plant_none.csv", 0.005, 0.0, 0.0),
        ("plant_field_dead_5.csv", 0.005, 0.005, 0.0),
        ("plant_field_lag_5.csv", 0.005, 0.0, 0.005),
        ("plant_field_dead_2_lag_3.csv", 0.005, 0.002, 0.003),
        ("plant_no_drive_delay.csv", 0.0, 0.002, 0.003),
    ];
    for (name, delay_s, dead_s, lag_s) in cases {
        let columns = ["torque_cmd_nm", "field_cmd_kv_mm", "position_rad", "velocity_rad_s"];
        let Some(rows) = read(name, &columns) else { continue };
        let worst = [1, 5].map(|finer| {
            let step_s = STEP_S / finer as f64;
            let mut rotor = Rotor::new(&physics(delay_s, dead_s, lag_s, FluidDelay::Field), step_s);
            let (mut position, mut speed) = (0.0_f64, 0.0_f64);
            for row in &rows {
                position = position.max((rotor.position_rad() - row[2]).abs());
                speed = speed.max((rotor.speed_rad_s() - row[3]).abs());
                let command = Command { torque_nm: row[0], field_kv_mm: row[1], ..Command::default() };
                (0..STEPS * finer).for_each(|_| rotor.step(&command));
            }
            (position, speed)
        });
        println!("{name}: {worst:?} rad and rad/s at {STEP_S} s and a fifth of it");
        // One count is 12.8e-6 rad.
        assert!(worst[0].0 < 2e-5 && worst[0].1 < 3e-4, "{name}: {worst:?}");
        assert!(worst[1].0 < 6e-6 && worst[1].1 < 2e-4, "{name}: {worst:?}");
    }
}

/// The law of the references, with the true speed (control specification, sections 2 to 4).
fn law(position: f64, w: f64) -> Command {
    let e = 30.0_f64.to_radians() - position;
    let speed = w.abs();
    let braking = e.abs() < 0.02 && e * w < 0.0;
    let (a, b) = (0.0704, 0.470);
    let q = (3.675 * speed * speed - 9.277 * speed + 4.010).exp();
    let damping = -b / (2.0 * a) + ((b * b / (4.0 * a) + q * speed) / a).sqrt();
    let field: f64 = if speed > 1.5 {
        0.0
    } else if braking {
        3.0
    } else {
        damping
    };
    let braking = braking && speed <= 1.5;
    let viscosity_nm_s_rad = Some(if speed > 1.5 { 0.0 } else { q });
    let torque_nm = (240.0 * e - 6.96 * w).clamp(-30.0, 30.0);
    Command {
        torque_nm,
        field_kv_mm: field.clamp(0.0, 3.5),
        braking,
        speed_rad_s: w,
        viscosity_nm_s_rad,
        external_nm: 0.0,
    }
}

#[test]
fn closed_loop_follows_the_references() {
    let field = FluidDelay::Field;
    let cases = [
        ("loop_none.csv", 0.0, 0.0, field),
        ("loop_e_dead_5.csv", 0.005, 0.0, field),
        ("loop_e_lag_5.csv", 0.0, 0.005, field),
        ("loop_e_dead2_lag3.csv", 0.002, 0.003, field),
        ("loop_q_dead_5.csv", 0.0, 0.0, FluidDelay::ViscosityDeadTime(0.005)),
        ("loop_q_dead_50.csv", 0.0, 0.0, FluidDelay::ViscosityDeadTime(0.05)),
        ("loop_q_lag_5.csv", 0.0, 0.0, FluidDelay::ViscosityLag(0.005)),
    ];
    for (name, dead_s, lag_s, delay) in cases {
        let Some(rows) = read(name, &["position_rad", "velocity_rad_s"]) else { continue };
        let mut rotor = Rotor::new(&physics(0.005, dead_s, lag_s, delay), STEP_S);
        let (mut position, mut speed) = (0.0_f64, 0.0_f64);
        for row in &rows {
            position = position.max((rotor.position_rad() - row[0]).abs());
            speed = speed.max((rotor.speed_rad_s() - row[1]).abs());
            let command = law(rotor.position_rad(), rotor.speed_rad_s());
            (0..STEPS).for_each(|_| rotor.step(&command));
        }
        println!("{name}: position within {position:.1e} rad, speed within {speed:.1e} rad/s");
        // The step of these references is 25 us: twice the top speed of 5 rad/s times a step.
        assert!(position < 2.5e-4 && speed < 5e-2, "{name}: {position:e} rad, {speed:e} rad/s");
    }
}

/// Commands of a third of a second with reversals, rests and fields that rise and fall.
fn commands() -> Vec<Command> {
    let torque = |k: usize| 6.0 * (std::f64::consts::TAU * k as f64 / 200.0).sin() * if k > 400 { 0.3 } else { 1.0 };
    let field = |k: usize| if k / 60 % 2 == 1 { 2.0 } else { 0.3 };
    (0..660).map(|k| Command { torque_nm: torque(k), field_kv_mm: field(k), ..Command::default() }).collect()
}

#[test]
fn every_effect_converges_as_the_step_becomes_finer() {
    use rand::SeedableRng as _;
    for (index, entry) in conceal::catalogue::ENTRIES.iter().enumerate() {
        let mut physics = Physics::nominal();
        entry.conceal(1.0, &mut physics, &mut rand::rngs::StdRng::seed_from_u64(index as u64));
        let run = |finer: usize| {
            let mut rotor = Rotor::new(&physics, STEP_S / finer as f64);
            let each = |command: Command| {
                (0..STEPS * finer).for_each(|_| rotor.step(&command));
                rotor.position_rad()
            };
            commands().into_iter().map(each).collect::<Vec<f64>>()
        };
        let (coarse, fine) = (run(1), run(4));
        let way = fine.iter().fold(0.0_f64, |most, position| most.max(position.abs()));
        let error = coarse.iter().zip(&fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{:24} {error:.1e} rad of {way:.2} rad", entry.id);
        // Two counts: nothing in an open loop takes an error back.
        assert!(error < 2.6e-5, "{}: {error:e} rad", entry.id);
    }
}
