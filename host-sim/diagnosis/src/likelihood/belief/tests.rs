//! Steps of the mean against closed forms.

use plant::Model;
use plant::effects::Shaft;

use super::super::along::CERTAIN;
use super::{BASE, Laws, POSITION, SPEED, Substep};

const DT_S: f64 = 5e-4;

fn step(torque: f64) -> Substep {
    Substep { dt_s: DT_S, torque, drive: torque, level: 0.0, viscosity: 0.0, consistency: 0.0 }
}

#[test]
fn a_shaft_swings_at_its_resonance_with_a_step_of_a_fortieth_of_the_period() {
    let shaft = Shaft { resonance_hz: 50.0, damping_ratio: 0.02, inertia_ratio: 0.5, gap: 0.0 };
    let laws = Laws::new(&Model { shaft: Some(shaft), ..Model::new(0.1) });
    let mut x = [0.0; BASE + 2];
    x[BASE] = 0.01;
    let mut crossings = Vec::new();
    for index in 0..2000 {
        let next = laws.mean(&x, &step(0.0), CERTAIN, CERTAIN);
        if x[BASE] < 0.0 && next[BASE] >= 0.0 {
            crossings.push((f64::from(index) + x[BASE] / (x[BASE] - next[BASE])) * DT_S);
        }
        x = next;
    }
    let frequency_hz = (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0]);
    // The resonance is that of the undamped shaft.
    let expected_hz = 50.0 * (1.0_f64 - 0.02 * 0.02).sqrt();
    assert!((frequency_hz / expected_hz - 1.0).abs() < 1e-4, "{frequency_hz} Hz");
}

#[test]
fn a_rotor_that_stops_or_turns_within_a_step_travels_as_far_as_it_does() {
    let laws = Laws::new(&Model { coulomb: 1.0, ..Model::new(0.1) });
    // Stops: 0.002 rad/s against 10 rad/s2.
    let mut x = [0.0; BASE];
    x[SPEED] = 0.002;
    let stopped = laws.mean(&x, &step(0.0), CERTAIN, CERTAIN);
    assert!(stopped[SPEED].abs() < 1e-9, "{stopped:?}");
    assert!((stopped[POSITION] - 0.002_f64.powi(2) / 20.0).abs() < 1e-12, "{stopped:?}");
    // Turns: slowed with 40 rad/s2 to rest in 0.05 ms, driven back with 20 rad/s2 for the rest.
    let turned = laws.mean(&x, &step(-3.0), CERTAIN, CERTAIN);
    let back_s = DT_S - 0.002 / 40.0;
    assert!((turned[SPEED] + 20.0 * back_s).abs() < 1e-9, "{turned:?}");
    let travel = 0.002_f64.powi(2) / 80.0 - 10.0 * back_s * back_s;
    assert!((turned[POSITION] - travel).abs() < 1e-12, "{turned:?} {travel}");
}
