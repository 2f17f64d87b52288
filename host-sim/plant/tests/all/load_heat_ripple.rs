//! Friction over the load, warming and ripple against their closed forms.

use plant::effects::{Harmonic, Warming};
use plant::{Command, Er, FieldResponse, FluidResponse, Model, Plant, State};

const TICK_S: f64 = 0.0005;

/// Holds a torque and a field for so many ticks.
fn held(model: &Model, start: State, torque: f64, field_kv_mm: f64, ticks: u32) -> Plant {
    let mut plant = Plant::new(model, start, 0.0).unwrap();
    for tick in 1..=ticks {
        plant.advance(&Command::new(torque, field_kv_mm), f64::from(tick) * TICK_S).unwrap();
    }
    plant
}

#[test]
fn friction_grows_with_the_torque_that_is_transmitted() {
    let (inertia, coulomb, k) = (0.05, 0.4, 0.2);
    let model = Model { coulomb, load_friction: k, ..Model::new(inertia) };
    // Breaks away where T (1 - k) = level.
    let edge = coulomb / (1.0 - k);
    assert_eq!(held(&model, State::default(), edge * (1.0 - 1e-9), 0.0, 400).state().position, 0.0);
    assert!(held(&model, State::default(), edge * (1.0 + 1e-6), 0.0, 400).state().position > 0.0);
    for (torque, speed) in [(2.0, 0.0), (2.0, 1.0), (-2.0, 5.0), (0.0, 5.0), (-1.0, -0.5)] {
        let found = held(&model, State::new(0.0, speed), torque, 0.0, 100).state().velocity;
        let sign = if speed == 0.0 { 1.0 } else { speed.signum() };
        let expected = speed + 0.05 * (torque - sign * (coulomb + k * torque.abs())) / inertia;
        assert!((found - expected).abs() < 1e-12, "{torque} N m from {speed} rad/s: {found} and not {expected}");
    }
    let refused = |model: Model| Plant::new(&model, State::default(), 0.0).unwrap_err().to_string();
    assert!(
        refused(Model { load_friction: 1.0, ..model.clone() }).starts_with("load_dependent_friction.coefficient = 1")
    );
    let carried_by_nothing = Model { coulomb: 0.0, presliding_stiffness: Some(100.0), ..model };
    assert!(refused(carried_by_nothing).contains("bristle"));
}

#[test]
fn a_ripple_does_the_work_of_its_integral() {
    let (inertia, torque) = (0.05, 1.5);
    let ripple = [(0.2, 6.0, 0.3), (0.05, 31.0, -1.0)].map(|(amplitude, order, phase_rad)| Harmonic {
        amplitude,
        order,
        phase_rad,
    });
    let model = Model { torque_ripple: ripple.to_vec(), ..Model::new(inertia) };
    let state = *held(&model, State::default(), torque, 0.0, 2000).state();
    let lifted: f64 = ripple
        .iter()
        .map(|h| h.amplitude / h.order * (h.phase_rad.cos() - (h.order * state.position + h.phase_rad).cos()))
        .sum();
    let work = torque * (state.position + lifted);
    assert!((0.5 * inertia * state.velocity * state.velocity / work - 1.0).abs() < 1e-12, "{state:?}");
    // At rest the place decides what holds: gain 1 - 0.2 there.
    let stiff = Model {
        coulomb: 1.3,
        torque_ripple: vec![Harmonic { amplitude: 0.2, order: 1.0, phase_rad: 0.0 }],
        ..Model::new(1.0)
    };
    let trough = State::new(-std::f64::consts::FRAC_PI_2, 0.0);
    assert_eq!(held(&stiff, trough, torque, 0.0, 100).state().position, trough.position);
    assert!(held(&stiff, State::default(), torque, 0.0, 100).state().position > 0.0);
    let deep = Model { torque_ripple: vec![Harmonic { amplitude: -1.0, order: 1.0, phase_rad: 0.0 }], ..stiff };
    assert!(
        Plant::new(&deep, State::default(), 0.0).unwrap_err().to_string().starts_with("torque_ripple.amplitude = 1")
    );
}

#[test]
fn what_friction_takes_from_the_rotor_is_the_heat_in_it() {
    let warming = Some(Warming { per_j: 0.15, cooling_per_s: 0.0 });
    let (inertia, speed) = (0.5, 6.0);
    let model = Model { coulomb: 0.2, viscous: 0.3, viscous_warming: warming, ..Model::new(inertia) };
    let state = *held(&model, State::new(0.0, speed), 0.0, 0.0, 1000).state();
    let lost = 0.5 * inertia * (speed * speed - state.velocity * state.velocity);
    assert!(state.velocity > 1.0 && (state.friction_heat_j / lost - 1.0).abs() < 1e-12, "{state:?}");
    // Without Coulomb friction J dw/dth = -b exp(-k J (w0^2 - w^2) / 2): the way is an integral over the speed.
    let model = Model { coulomb: 0.0, ..model };
    let state = *held(&model, State::new(0.0, speed), 0.0, 0.0, 1000).state();
    let way = |w: f64| inertia / 0.3 * (0.15 * 0.5 * inertia * (speed * speed - w * w)).exp();
    let (cells, width) = (2000_u32, (speed - state.velocity) / 2000.0);
    let simpson: f64 = (0..cells)
        .map(|cell| state.velocity + f64::from(cell) * width)
        .map(|w| width / 6.0 * (way(w) + 4.0 * way(w + 0.5 * width) + way(w + width)))
        .sum();
    assert!((state.position / simpson - 1.0).abs() < 1e-10, "{} rad and not {simpson}", state.position);
}

#[test]
fn a_warm_machine_settles_where_cooling_takes_the_power() {
    let (torque, k, cooling_per_s) = (1.0, 0.02, 2.0);
    let viscous_warming = Some(Warming { per_j: k, cooling_per_s });
    let model = Model { viscous: 0.2, viscous_warming, ..Model::new(0.05) };
    let state = *held(&model, State::default(), torque, 0.0, 40_000).state();
    // T = b exp(-k H) w with H = T w / r.
    let heat_j = torque * state.velocity / cooling_per_s;
    assert!((state.friction_heat_j / heat_j - 1.0).abs() < 1e-9, "{state:?}");
    assert!((0.2 * (-k * heat_j).exp() * state.velocity / torque - 1.0).abs() < 1e-9, "{state:?}");
    assert!(state.velocity > 5.2, "{state:?}");
    // At rest it cools.
    let mut stopped = state;
    stopped.velocity = 0.0;
    let cold = held(&Model { coulomb: 2.0, ..model }, stopped, 0.0, 0.0, 1000);
    assert!((cold.state().friction_heat_j / (heat_j * (-0.5 * cooling_per_s).exp()) - 1.0).abs() < 1e-9);
}

#[test]
fn a_warm_fluid_yields_sooner() {
    let (torque, field) = (1.5, 2.0);
    let warming = Some(Warming { per_j: 0.05, cooling_per_s: 0.0 });
    let er =
        Er { warming, response: FluidResponse::Field(FieldResponse::default()), ..Er::new(0.0704, 0.47, 0.0, 0.0) };
    let level = (0.0704 * field + 0.47) * field;
    let model = Model { er: Some(er), ..Model::new(0.05) };
    // Cold it slides, and stops the rotor by the heat Q with (1 - exp(-k Q)) level / k the work it has done on the way.
    let state = *held(&model, State::new(0.0, 3.0), torque, field, 200).state();
    let work = 0.5 * 0.05 * 9.0 + torque * state.position - 0.5 * 0.05 * state.velocity * state.velocity;
    assert!((state.fluid_heat_j / work - 1.0).abs() < 1e-12, "{state:?}");
    let way = ((0.05 * state.fluid_heat_j).exp() - 1.0) / (0.05 * level);
    assert!((state.position / way - 1.0).abs() < 1e-10, "{state:?} {way}");
}
