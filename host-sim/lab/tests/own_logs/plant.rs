//! Machines that nobody has described, simulated.

use plant::effects::{Gravity, Pulse};
use plant::{Command as Effort, Model, Plant, State};
use rand::SeedableRng as _;
use rand::rngs::StdRng;
use rand_distr::{Distribution as _, Normal};

/// A pendulum that somebody pushes once: 1.5 N m hold it level, -1 N m for 0.2 s push it at 5 s.
pub fn pushed_pendulum() -> Vec<[f64; 3]> {
    let gravity = Some(Gravity { amplitude: 1.5, phase_rad: 0.3 });
    let pulses = vec![Pulse { start_s: 5.0, duration_s: 0.2, amplitude: -1.0 }];
    let model = Model { coulomb: 0.1, viscous: 0.02, gravity, pulses, ..Model::new(0.05) };
    run(&model, [9.0, 0.8, 1.2], 0.002, 1.0_f64.to_radians() / 20.0)
}

/// Time, position and effort of a machine under a spring and a damper that follow two sines. The effort is read with a noise of
/// 0.2 % of its largest.
pub fn run(model: &Model, [stiffness, damping, amplitude]: [f64; 3], period_s: f64, step: f64) -> Vec<[f64; 3]> {
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let mut rows = Vec::new();
    for tick in 0..(8.0 / period_s) as u32 {
        let t_s = f64::from(tick) * period_s;
        let reference = amplitude * ((3.1 * t_s).sin() + 0.4 * (14.0 * t_s).sin());
        let state = plant.state();
        let position = (state.position / step).round() * step;
        let effort = stiffness * (reference - state.position) - damping * state.velocity;
        rows.push([t_s, position, effort]);
        plant.advance(&Effort::new(effort, 0.0), t_s + period_s).unwrap();
    }
    let largest = rows.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    let noise = Normal::new(0.0, 0.002 * largest).unwrap();
    let mut random = StdRng::seed_from_u64(7);
    rows.iter_mut().for_each(|row| row[2] += noise.sample(&mut random));
    rows
}
