//! What must hold whatever the numbers: energy, stiction, order of events, answers known in closed form.

use crate::common::{self, TICK_S, energy, every_effect, nominal};
use plant::effects::{Gravity, Shaft, Stribeck};
use plant::{Command, Er, FluidResponse, Model, Plant, State};
use proptest::prelude::*;

/// Effects that take energy or store it; excitations from outside are left out.
fn passive_effects() -> Vec<(&'static str, Model)> {
    let whole_ticks = |(name, model): (&'static str, Model)| (name, Model { torque_delay_s: 0.002, ..model });
    // The ripple's work is not that of the torque before it, which the test counts.
    let outside = ["vibration", "disturbance_pulse", "torque_lag", "load_dependent_friction", "torque_ripple"];
    every_effect().into_iter().filter(|(name, _)| !outside.contains(name)).map(whole_ticks).collect()
}

fn commands() -> impl Strategy<Value = Vec<(f64, f64, bool, f64)>> {
    prop::collection::vec((-4.0..4.0_f64, 0.0..3.5_f64, any::<bool>(), -2.0..2.0_f64), 20..60)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn energy_is_never_created(commands in commands(), speed in -3.0..3.0_f64) {
        for (name, model) in passive_effects() {
            let mut plant = Plant::new(&model, State::new(0.1, speed), 0.0).unwrap();
            let mut before = (*plant.state(), energy(&model, plant.state()));
            for (tick, &(torque, field, braking, speed_estimate)) in (1..).zip(&commands) {
                let command = Command { braking, speed_estimate, ..Command::new(torque, field) };
                plant.advance(&command, f64::from(tick) * TICK_S).unwrap();
                // The torque is constant over a tick: no lag, delay of whole ticks.
                let acting = plant.last_segment().unwrap().torque.base;
                let work = acting * (plant.state().position - before.0.position);
                let now = energy(&model, plant.state());
                prop_assert!(now - before.1 <= work + 1e-11, "{name}: tick {tick} gains {:e} J", now - before.1 - work);
                before = (*plant.state(), now);
            }
        }
    }

    #[test]
    fn a_free_rotor_never_speeds_up(commands in commands(), speed in -10.0..10.0_f64) {
        let stores = ["cogging", "gravity", "spring", "compliance", "backlash", "presliding", "er_preyield"];
        for (name, model) in passive_effects().into_iter().filter(|(name, _)| !stores.contains(name)) {
            let mut plant = Plant::new(&model, State::new(0.0, speed), 0.0).unwrap();
            let mut last = speed;
            for (tick, &(_, field, braking, speed_estimate)) in (1..).zip(&commands) {
                let command = Command { braking, speed_estimate, ..Command::new(0.0, field) };
                plant.advance(&command, f64::from(tick) * TICK_S).unwrap();
                let now = plant.state().velocity;
                prop_assert!(now.abs() <= last.abs() && now * speed >= 0.0, "{name}: {last} to {now} rad/s");
                last = now;
            }
        }
    }

    #[test]
    fn torque_below_the_drag_never_moves_the_rotor(commands in commands(), share in 0.0..1.0_f64) {
        let slides = ["presliding", "cogging", "vibration", "disturbance_pulse", "torque_ripple"];
        for (name, model) in every_effect().into_iter().filter(|(name, _)| !slides.contains(name)) {
            let gravity = model.gravity.map_or(0.0, |gravity| gravity.amplitude * gravity.phase_rad.sin());
            let weakest = model.coulomb - 0.5 * model.asymmetry.coulomb.abs() - gravity.abs();
            let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
            for (tick, &(torque, field, braking, speed_estimate)) in (1..).zip(&commands) {
                let held = share * weakest * torque / 4.0;
                let command = Command { braking, speed_estimate, ..Command::new(held, field) };
                plant.advance(&command, f64::from(tick) * TICK_S).unwrap();
                prop_assert!(plant.state().position == 0.0 && plant.state().velocity == 0.0, "{name} moved");
            }
        }
    }

    #[test]
    fn any_model_and_command_stay_finite(torque in -1e6..1e6_f64, field in 0.0..1e3_f64, speed in -1e4..1e4_f64) {
        for (name, model) in every_effect() {
            let mut plant = Plant::new(&Model { torque_limit: None, ..model }, State::new(0.0, speed), 0.0).unwrap();
            plant.advance(&Command::new(torque, field), 0.0007).unwrap();
            plant.advance(&Command::new(-torque, 0.0), 0.0031).unwrap();
            prop_assert!(plant.state().position.is_finite() && plant.state().velocity.is_finite(), "{name}");
        }
    }
}

/// Runs a constant command for a time and gives the state.
fn after(model: &Model, start: State, command: Command, time_s: f64) -> State {
    let mut plant = Plant::new(model, start, 0.0).unwrap();
    plant.advance(&command, time_s).unwrap();
    *plant.state()
}

#[test]
fn stuck_rotor_counts_torques_of_position() {
    let gravity = |amplitude| Model { gravity: Some(Gravity { amplitude, phase_rad: 0.0 }), ..nominal() };
    let sideways = State::new(std::f64::consts::FRAC_PI_2, 0.0);
    assert_eq!(after(&gravity(0.76), sideways, Command::default(), 1.0).position, sideways.position);
    assert!(after(&gravity(0.77), sideways, Command::default(), 1.0).position < sideways.position);
    // The motor carries part of the weight.
    let model = Model { torque_delay_s: 0.0, ..gravity(1.2) };
    assert_eq!(after(&model, sideways, Command::new(0.5, 0.0), 1.0).position, sideways.position);
}

#[test]
fn break_away_happens_at_the_moment_the_falling_field_lets_go() {
    let model = Model { torque_delay_s: 0.0, er: Some(Er::new(0.0704, 0.470, 0.0, 0.003)), ..Model::paper() };
    let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
    plant.advance(&Command::new(0.0, 2.0), 1.0).unwrap();
    plant.advance(&Command::new(1.2, 0.0), 1.02).unwrap();
    // a E^2 + b E = 1.2 - 0.763 with E = 2 exp(-t / 3 ms).
    let (a, b) = (0.0704, 0.470);
    let field = (-b + f64::sqrt(b * b + 4.0 * a * 0.437)) / (2.0 * a);
    let start_s = 0.003 * (2.0 / field).ln();
    // From there J w' = 0.437 - a E^2 - b E in closed form.
    let (time_s, lag_s) = (0.02 - start_s, 0.003);
    let gone = |rate: f64| (1.0 - (-time_s / rate).exp()) * rate;
    let speed = (0.437 * time_s - b * field * gone(lag_s) - a * field * field * gone(0.5 * lag_s)) / 0.075;
    assert!((plant.state().velocity - speed).abs() < 1e-13, "{} {speed}", plant.state().velocity);
}

#[test]
fn a_dip_to_zero_within_one_tick_is_not_missed() {
    // The field peaks for 2 ms while the rotor creeps; one long tick sees it stop and start again.
    let model = Model { torque_delay_s: 0.0, er: Some(Er::new(0.0704, 0.470, 0.0, 0.004)), ..Model::paper() };
    let start = State::new(0.0, 0.002);
    let mut plant = Plant::new(&model, start, 0.0).unwrap();
    plant.advance(&Command::new(1.0, 3.0), 0.0015).unwrap();
    let mut fine = plant.clone();
    plant.advance(&Command::new(1.0, 0.0), 0.0415).unwrap();
    let mut stopped = false;
    for part in 1..=4000 {
        fine.advance(&Command::new(1.0, 0.0), 0.0015 + f64::from(part) * 1e-5).unwrap();
        stopped |= fine.state().velocity == 0.0;
    }
    assert!(stopped && fine.state().velocity > 0.0);
    assert!((plant.state().position - fine.state().position).abs() < 1e-13);
}

#[test]
fn closed_forms_of_single_effects() {
    let free = Model::new(0.075);
    let spring = Model { spring_stiffness: 5.0, ..free.clone() };
    let omega = (5.0_f64 / 0.075).sqrt();
    let x = after(&spring, State::new(0.2, 0.0), Command::default(), 1.0);
    assert!((x.position - 0.2 * omega.cos()).abs() < 1e-11, "{x:?}");

    let drag = Model { quadratic_drag: 0.05, ..free.clone() };
    let x = after(&drag, State::new(0.0, 4.0), Command::default(), 1.0);
    assert!((x.velocity - 4.0 / (1.0 + 0.05 * 4.0 / 0.075)).abs() < 1e-12, "{x:?}");

    let lag = Model { torque_lag_s: 0.02, ..free.clone() };
    let x = after(&lag, State::default(), Command::new(1.0, 0.0), 0.1);
    let speed = (0.1 - 0.02 * (1.0 - f64::exp(-5.0))) / 0.075;
    assert!((x.velocity - speed).abs() < 1e-13, "{x:?}");

    // Below yield the fluid is a spring about the rest position.
    let er = Er { preyield_stiffness: Some(200.0), ..Er::new(0.0704, 0.470, 0.0, 0.0) };
    let preyield = Model { er: Some(er), ..free.clone() };
    let omega = (200.0_f64 / 0.075).sqrt();
    let x = after(&preyield, State::default(), Command::new(0.3, 1.5), 0.1);
    assert!((x.position - 0.3 / 200.0 * (1.0 - (0.1 * omega).cos())).abs() < 1e-12, "{x:?}");
    // At yield it slides against the torque of the field, 0.8634 N m at 1.5 kV/mm.
    let x = after(&preyield, State::new(0.0, 5.0), Command::new(0.0, 1.5), 0.3);
    let travel: f64 = 0.8634 / 200.0;
    let at_yield = (25.0 - 200.0 / 0.075 * travel * travel).sqrt();
    let reach_s = (travel * omega / 5.0).asin() / omega;
    assert!((x.velocity - (at_yield - 0.8634 / 0.075 * (0.3 - reach_s))).abs() < 1e-11, "{x:?}");
}

#[test]
fn shaft_rings_at_its_resonance_with_its_damping() {
    let shaft = Shaft { resonance_hz: 40.0, damping_ratio: 0.05, inertia_ratio: 0.5, gap: 0.0 };
    let model = Model { shaft: Some(shaft), ..Model::new(0.075) };
    let mut start = State::default();
    start.twist = 0.01;
    let x = after(&model, start, Command::default(), 0.2);
    let omega = std::f64::consts::TAU * 40.0;
    let (decay, damped) = (0.05 * omega, omega * f64::sqrt(1.0 - 0.05 * 0.05));
    let phase = damped * 0.2;
    let twist = 0.01 * (-decay * 0.2).exp() * (phase.cos() + decay / damped * phase.sin());
    assert!((x.twist - twist).abs() < 1e-11, "{} {twist}", x.twist);
    // Nobody pushes from outside: the centre of mass stays.
    assert!((x.position + x.twist / 3.0 - 0.01 / 3.0).abs() < 1e-13);
}

#[test]
fn stribeck_breaks_away_at_its_full_level() {
    let stribeck = Some(Stribeck { excess: 0.4, velocity: 0.05 });
    let model = Model { stribeck, torque_delay_s: 0.0, ..nominal() };
    assert_eq!(after(&model, State::default(), Command::new(1.1629, 0.0), 1.0).position, 0.0);
    let x = after(&model, State::default(), Command::new(1.17, 0.0), 1.5);
    assert!(x.velocity > 4.0, "once loose it runs away: {x:?}");
}

#[test]
fn presliding_returns_below_its_level_and_slides_above() {
    let model = Model { coulomb: 0.8, presliding_stiffness: Some(400.0), torque_delay_s: 0.0, ..Model::new(0.075) };
    let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
    for tick in 1..=2000 {
        let ramp = (f64::from(tick) / 2000.0).min(1.0) * 0.4;
        plant.advance(&Command::new(ramp, 0.0), f64::from(tick) * TICK_S).unwrap();
    }
    // Half the level, reached slowly: x = -level / stiffness ln(1 - 1/2).
    let expected = 0.8 / 400.0 * std::f64::consts::LN_2;
    assert!((plant.state().position - expected).abs() < 0.05 * expected, "{} {expected}", plant.state().position);
    let x = after(&model, State::default(), Command::new(1.0, 0.0), 1.0);
    // Work of 1 N m less that of the bristle, level x - level^2 / stiffness once it has given way.
    let speed = (2.0 / 0.075 * (0.2 * x.position + 0.8 * 0.8 / 400.0)).sqrt();
    assert!((x.velocity - speed).abs() < 1e-10, "{} {speed}", x.velocity);
}

/// The falling field cuts the spring of the fluid down to nothing while the rotor turns round: it enters its range over
/// one edge and leaves over the other within the same step.
#[test]
fn a_loaded_fluid_that_the_field_lets_go_of_in_a_reversal_does_not_stall() {
    let model = common::fluid(|er| er.preyield_stiffness = Some(300.0));
    let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
    let (mut segments, mut reversals, mut last) = (0, 0, 0.0);
    for tick in 1..=8000_u32 {
        let torque = if (tick / 40) % 2 == 0 { 10.0 } else { -11.0 };
        let field = if (tick / 37) % 2 == 0 { 2.0 } else { 0.0 };
        plant.advance(&Command::new(torque, field), f64::from(tick) * TICK_S).unwrap();
        segments += 1;
        reversals += u32::from(plant.state().velocity * last < 0.0);
        last = plant.state().velocity;
    }
    assert!(segments == 8000 && reversals > 100, "{reversals}");
}

#[test]
fn a_brake_beside_a_delayed_viscosity_is_one_fluid_with_one_limit() {
    // Q = 40 N m s/rad at 20 rad/s is far beyond the limit, and the brake comes while it is still there: the drag stays at what
    // 3.5 kV/mm gives, and the rotor slows by it alone.
    let torque_limit = Er::largest_torque(0.0704, 0.470);
    for response in [
        FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit },
        FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit },
    ] {
        let model = Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::new(0.075) };
        let mut plant = Plant::new(&model, State::new(0.0, 20.0), 0.0).unwrap();
        let damping = Command { viscosity: Some(40.0), ..Command::new(0.0, 3.5) };
        plant.advance(&damping, 0.05).unwrap();
        let before = plant.state().velocity;
        let brake = Command { braking: true, ..Command::new(0.0, 3.5) };
        for tick in 1..=400 {
            plant.advance(&brake, 0.05 + f64::from(tick) * 5e-4).unwrap();
            let torque = plant.er_torque();
            assert!(torque <= torque_limit * (1.0 + 1e-12), "{response:?} {tick}: {torque}");
        }
        let slowed = before - plant.state().velocity;
        assert!((slowed - torque_limit * 0.2 / 0.075).abs() < 1e-6, "{response:?}: {slowed}");
    }
}
