//! Machines that nobody has described, simulated.

use plant::effects::{Gravity, Harmonic, Pulse};
use plant::{Command as Effort, Model, Plant, State};
use rand::SeedableRng as _;
use rand::rngs::StdRng;
use rand_distr::{Distribution as _, Normal};

/// A pendulum that somebody pushes once: 1.5 N m hold it level, -1 N m for 0.2 s push it at 5 s. Its encoder has this many steps
/// a degree.
pub fn pushed_pendulum(steps_per_deg: f64) -> Vec<[f64; 3]> {
    let gravity = Some(Gravity { amplitude: 1.5, phase_rad: 0.3 });
    let pulses = vec![Pulse { start_s: 5.0, duration_s: 0.2, amplitude: -1.0 }];
    let model = Model { coulomb: 0.1, viscous: 0.02, gravity, pulses, ..Model::new(0.05) };
    run(&model, [9.0, 0.8, 1.2], 0.002, 1.0_f64.to_radians() / steps_per_deg)
}

/// A joint that cogs ten times a turn by 0.2 N m, logged every `period_s`.
pub fn cogging_joint(period_s: f64) -> Vec<[f64; 3]> {
    let cogging = vec![Harmonic { amplitude: 0.2, order: 10.0, phase_rad: 0.5 }];
    let model = Model { coulomb: 0.3, viscous: 0.05, cogging, ..Model::new(0.02) };
    run(&model, [8.0, 0.3, 0.6], period_s, 1e-4)
}

/// A linear axis that a spring of 150 N/m pulls back, on a screw of 8 mm that cogs by 3 N once a turn, logged every `period_s`.
pub fn sprung_axis(period_s: f64) -> Vec<[f64; 3]> {
    let cogging = vec![Harmonic { amplitude: 3.0, order: 125.0, phase_rad: 0.5 }];
    let model = Model { coulomb: 9.0, viscous: 40.0, spring_stiffness: 150.0, cogging, ..Model::new(12.0) };
    run(&model, [9000.0, 250.0, 0.05], period_s, 1e-6)
}

/// Rounds of the drive's loop for each row of the log.
pub const ROUNDS: u32 = 20;

/// The log of a machine whose drive's loop runs faster than the log, so that the effort is a sample of what acts; it is read with a
/// noise of 0.2 % of its largest.
fn run(model: &Model, gains: [f64; 3], period_s: f64, step: f64) -> Vec<[f64; 3]> {
    let mut rows = follow(model, gains, period_s, step, 1);
    let largest = rows.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    let noise = Normal::new(0.0, 0.002 * largest).unwrap();
    let mut random = StdRng::seed_from_u64(7);
    rows.iter_mut().for_each(|row| row[2] += noise.sample(&mut random));
    rows
}

/// Time, position and effort of a machine under a spring and a damper that follow two sines; the effort is held for so many rounds.
pub fn follow(
    model: &Model,
    [stiffness, damping, amplitude]: [f64; 3],
    period_s: f64,
    step: f64,
    held: u32,
) -> Vec<[f64; 3]> {
    let mut plant = Plant::new(model, State::default(), 0.0).unwrap();
    let (mut rows, mut effort) = (Vec::new(), 0.0);
    for round in 0..ROUNDS * (8.0 / period_s) as u32 {
        let t_s = f64::from(round) * period_s / f64::from(ROUNDS);
        let state = plant.state();
        if round % held == 0 {
            let reference = amplitude * ((3.1 * t_s).sin() + 0.4 * (14.0 * t_s).sin());
            effort = stiffness * (reference - state.position) - damping * state.velocity;
        }
        if round % ROUNDS == 0 {
            rows.push([t_s, (state.position / step).round() * step, effort]);
        }
        plant.advance(&Effort::new(effort, 0.0), t_s + period_s / f64::from(ROUNDS)).unwrap();
    }
    rows
}
