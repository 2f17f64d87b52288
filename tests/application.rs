//! The firmware's application loop on the simulated plant, drivers and SPI bytes included.
#![allow(clippy::unwrap_used)]

use er_servo::app::Orders;
use er_servo::host_sim::Bench;
use er_servo::{Config, Counts, Faults, Frame, Mode, Params, RAD_PER_COUNT, Request, Supervisor};
use plant::chips::BusFault;
use plant::{Er, Model};

fn model() -> Model {
    Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() }
}

fn running_with(config: &Config) -> Bench {
    let mut bench = Bench::new(&model(), Params::new(config).unwrap(), 0.0005).unwrap();
    bench.init().unwrap();
    assert_eq!(bench.enable().unwrap().outputs.supervisor, Supervisor::Running);
    bench
}

fn running() -> Bench {
    running_with(&Config::default())
}

fn to(angle_rad: f64) -> Orders {
    Orders { reference: Counts::from_rad(angle_rad), ..Orders::default() }
}

fn run(bench: &mut Bench, orders: &Orders, ticks: usize) -> Vec<Frame> {
    (0..ticks).map(|_| bench.tick(orders).unwrap()).collect()
}

/// Nothing acts, and the drive knows why.
fn assert_safe(bench: &Bench, frame: &Frame, fault: Faults, why: &str) {
    assert_eq!(frame.outputs.supervisor, Supervisor::Fault { faults: fault }, "{why}");
    assert_eq!(bench.acting(), (0.0, 0.0), "{why}");
    assert!(!bench.hv_enable.level() && bench.fault_lamp.level(), "{why}");
}

/// The step of the paper, 30 degrees.
const STEP_RAD: f64 = core::f64::consts::FRAC_PI_6;
/// The error friction can hold, c/K_P, with 10 % for the flicker of the estimate.
const HELD_RAD: f64 = 1.1 * 0.763 / 240.0;

#[test]
fn steps_and_reversals_settle_within_what_friction_holds() {
    let mut bench = running();
    for angle_rad in [STEP_RAD, 0.0, -1.2, 1.5, 0.01] {
        // The last of the way is a creep through the damper, with a time constant of Q(0)/K_P = 0.23 s.
        let frames = run(&mut bench, &to(angle_rad), 3000);
        let error = angle_rad - bench.truth().position;
        assert!(error.abs() < HELD_RAD + f64::from(RAD_PER_COUNT), "{angle_rad}: {error}");
        assert!(frames.iter().all(|frame| frame.outputs.supervisor == Supervisor::Running), "{angle_rad}");
    }
}

#[test]
fn every_tick_of_a_step_follows_the_angle_to_the_count() {
    let mut bench = running();
    for _ in 0..600 {
        let truth = bench.truth().position;
        let frame = bench.tick(&to(STEP_RAD)).unwrap();
        let counts = f64::from(frame.outputs.position.0);
        assert!((counts - truth / f64::from(RAD_PER_COUNT)).abs() <= 1.0, "{counts} counts at {truth} rad");
    }
}

#[test]
fn the_brake_halves_what_a_push_does() {
    let peak = |config: &Config| {
        let mut bench = running_with(config);
        bench.external_torque_nm = 8.0;
        let mut peak: f64 = 0.0;
        for tick in 0..400 {
            if tick == 100 {
                bench.external_torque_nm = 0.0;
            }
            bench.tick(&to(0.0)).unwrap();
            peak = peak.max(bench.truth().position.abs());
        }
        peak
    };
    let off = peak(&Config { er_enabled: false, ..Config::default() });
    let damper = peak(&Config { near_rad: 0.0, ..Config::default() });
    let brake = peak(&Config::default());
    // Control.md section 7 has 28.54, 25.35 and 20.46 mrad for the true speed; here the speed is estimated from counts.
    assert!((off - 0.02854).abs() < 0.001 && brake < damper && damper < off, "{off} {damper} {brake}");
}

#[test]
fn every_mode_is_entered_and_left() {
    let mut bench = running();
    bench.tick(&to(0.0)).unwrap();
    let mut seen = run(&mut bench, &to(STEP_RAD), 800);
    bench.external_torque_nm = 8.0;
    seen.extend(run(&mut bench, &to(STEP_RAD), 100));
    bench.external_torque_nm = 0.0;
    seen.extend(run(&mut bench, &to(STEP_RAD), 300));
    let changes: Vec<(Mode, Mode)> =
        seen.windows(2).map(|pair| (pair[0].outputs.mode, pair[1].outputs.mode)).filter(|(a, b)| a != b).collect();
    let (off, damper, brake) = (Mode::Off, Mode::Damper, Mode::Brake);
    for change in [(damper, off), (off, damper), (damper, brake), (brake, damper)] {
        assert!(changes.contains(&change), "{change:?} missing in {changes:?}");
    }
    // A reversal through the reference at speed brakes the overshoot directly.
    assert!(seen.iter().all(|frame| frame.outputs.field_kv_mm <= 3.5));
}

#[test]
fn every_fault_of_the_resolver_is_safe_in_the_tick_it_shows() {
    let bus = Faults::RESOLVER_BUS;
    type Injection = fn(&mut Bench);
    let cases: [(&str, Injection, Faults); 4] = [
        ("all ones", |b| b.resolver.with(|chip| chip.set_bus_fault(BusFault::AllOnes, 1)), Faults::RESOLVER_CHIP),
        ("garbage", |b| b.resolver.with(|chip| chip.set_bus_fault(BusFault::Garbage, 1)), Faults::RESOLVER_CHIP),
        ("jump", |b| b.resolver.with(|chip| chip.jump(400)), Faults::RESOLVER_JUMP),
        ("SPI", |b| b.resolver.fail_spi(Some(embedded_hal::spi::ErrorKind::Overrun)), bus),
    ];
    for (why, inject, fault) in cases {
        let mut bench = running();
        run(&mut bench, &to(STEP_RAD), 60);
        inject(&mut bench);
        let frame = bench.tick(&to(STEP_RAD)).unwrap();
        assert_safe(&bench, &frame, fault, why);
    }
    for bit in 0..8 {
        let mut bench = running();
        run(&mut bench, &to(STEP_RAD), 60);
        bench.resolver.with(|chip| chip.raise_faults(1 << bit));
        let frame = bench.tick(&to(STEP_RAD)).unwrap();
        assert_safe(&bench, &frame, Faults::RESOLVER_CHIP, &format!("fault bit {bit}"));
    }
}

#[test]
fn a_bus_stuck_low_or_a_frozen_resolver_is_found_when_it_matters() {
    // Stuck low reads as code 0 without fault: a jump unless the rotor happens to be there.
    let mut bench = running();
    run(&mut bench, &to(STEP_RAD), 60);
    bench.resolver.with(|chip| chip.set_bus_fault(BusFault::AllZeros, 1));
    let frame = bench.tick(&to(STEP_RAD)).unwrap();
    assert_safe(&bench, &frame, Faults::RESOLVER_JUMP, "all zeros");
    // Frozen in motion: the counts stop at once, which is a change of speed no torque can make.
    let mut bench = running();
    run(&mut bench, &to(STEP_RAD), 60);
    bench.resolver.with(|chip| chip.freeze(true));
    let frame = bench.tick(&to(STEP_RAD)).unwrap();
    assert_safe(&bench, &frame, Faults::RESOLVER_JUMP, "frozen in motion");
    // Frozen at rest: harmless until torque asks for motion, then found within 20 ms of torque.
    let mut bench = running();
    bench.resolver.with(|chip| chip.freeze(true));
    run(&mut bench, &to(0.0), 400);
    let frames = run(&mut bench, &to(STEP_RAD), 42);
    assert_safe(&bench, frames.last().unwrap(), Faults::RESOLVER_STALE, "frozen at rest");
}

#[test]
fn every_other_cause_is_safe_in_the_tick_it_shows() {
    let step = to(STEP_RAD);
    let reported = Orders { reported: Faults::TICK_OVERRUN, ..step };
    let silent = Orders { reference_from_link: true, ..step };
    type Injection = fn(&mut Bench);
    let cases: [(&str, Injection, Orders, Faults); 6] = [
        ("interlock", |b| b.interlock_closed.set(false), step, Faults::INTERLOCK_OPEN),
        ("stop", |b| b.stop_released.set(false), step, Faults::STOP_PRESSED),
        ("field monitor", |b| b.stray_field_kv_mm = 3.9, step, Faults::FIELD_OVER),
        ("amplifier", |b| b.amplifier_ready.set(false), step, Faults::AMPLIFIER),
        ("overrun", |_| (), reported, Faults::TICK_OVERRUN),
        ("link", |_| (), silent, Faults::LINK_LOST),
    ];
    for (why, inject, orders, fault) in cases {
        let mut bench = running();
        run(&mut bench, &step, 60);
        inject(&mut bench);
        let frame = bench.tick(&orders).unwrap();
        bench.stray_field_kv_mm = 0.0;
        assert_safe(&bench, &frame, fault, why);
    }
}

#[test]
fn a_dac_that_cannot_be_written_is_cleared_by_its_pin_in_the_same_tick() {
    let mut bench = running();
    run(&mut bench, &to(STEP_RAD), 60);
    bench.dac.fail_spi(Some(embedded_hal::spi::ErrorKind::Other));
    bench.tick(&to(STEP_RAD)).unwrap();
    assert_eq!(bench.acting(), (0.0, 0.0));
    let frame = bench.tick(&to(STEP_RAD)).unwrap();
    assert_safe(&bench, &frame, Faults::OUTPUT_BUS, "DAC");
}

#[test]
fn a_dac_whose_outputs_are_overloaded_or_hot_is_found_within_64_ms_and_clears_when_it_is_well() {
    let faults: [fn(&mut plant::chips::Dac, bool); 2] =
        [|chip, bad| chip.overload([false, bad]), |chip, bad| chip.overheat(bad)];
    for fault in faults {
        let mut bench = running();
        run(&mut bench, &to(STEP_RAD), 300);
        bench.dac.with(|chip| fault(chip, true));
        let frames = run(&mut bench, &to(STEP_RAD), 130);
        assert_safe(&bench, &frames[129], Faults::OUTPUT_BUS, "DAC");
        bench.dac.with(|chip| fault(chip, false));
        bench.init().unwrap();
        run(&mut bench, &Orders { request: Request::ClearFault, ..to(STEP_RAD) }, 1);
        let frames = run(&mut bench, &to(STEP_RAD), 300);
        assert_eq!(frames[299].outputs.supervisor, Supervisor::Ready);
    }
}

#[test]
fn a_fault_is_left_by_clear_and_enable_only_and_only_without_its_cause() {
    let mut bench = running();
    bench.interlock_closed.set(false);
    bench.tick(&to(0.0)).unwrap();
    let clear = Orders { request: Request::ClearFault, ..to(0.0) };
    let enable = Orders { request: Request::Enable, ..to(0.0) };
    assert_eq!(bench.tick(&clear).unwrap().outputs.supervisor.name(), "fault");
    bench.interlock_closed.set(true);
    assert_eq!(bench.tick(&enable).unwrap().outputs.supervisor.name(), "fault");
    assert_eq!(bench.tick(&clear).unwrap().outputs.supervisor.name(), "boot");
    assert_eq!(bench.enable().unwrap().outputs.supervisor.name(), "running");
}

#[test]
fn chips_that_do_not_answer_keep_the_drive_from_ready() {
    let mut bench = Bench::new(&model(), Params::new(&Config::default()).unwrap(), 0.0005).unwrap();
    bench.resolver.with(|chip| chip.set_bus_fault(BusFault::AllOnes, 1));
    assert!(bench.init().is_err());
    let frames = run(&mut bench, &to(0.0), 60);
    assert!(frames.iter().all(|frame| frame.outputs.torque_nm == 0.0));
    assert!(frames.last().unwrap().outputs.supervisor.faults().contains(Faults::RESOLVER_BUS));
}

#[test]
fn the_interlock_or_the_stop_refuses_an_enable() {
    for open in [true, false] {
        let mut bench = Bench::new(&model(), Params::new(&Config::default()).unwrap(), 0.0005).unwrap();
        bench.init().unwrap();
        if open {
            bench.interlock_closed.set(false)
        } else {
            bench.stop_released.set(false)
        }
        let frame = bench.enable().unwrap();
        assert_eq!(frame.outputs.supervisor, Supervisor::Ready);
        assert_eq!(frame.outputs.limits, er_servo::Limits::ENABLE_REFUSED);
    }
}

#[test]
fn an_axis_that_does_not_follow_or_is_too_fast_is_stopped() {
    // A quarter of the torque of friction alone: the reference goes, the axis does not.
    let mut bench = running_with(&Config { torque_limit_nm: 0.2, ..Config::default() });
    let frames = run(&mut bench, &to(0.6), 1100);
    let tripped = frames.iter().position(|frame| frame.outputs.supervisor != Supervisor::Running).unwrap();
    assert!((1000..1010).contains(&tripped), "0.5 s and a tick: {tripped}");
    assert_safe(&bench, frames.last().unwrap(), Faults::FOLLOWING_ERROR, "does not follow");

    let mut bench = running_with(&Config { over_speed_rad_s: 5.0, ..Config::default() });
    let frames = run(&mut bench, &to(STEP_RAD), 200);
    let seen = frames.iter().position(|frame| frame.outputs.speed_rad_s > 5.0).unwrap();
    let frame = &frames[seen + 1];
    assert_eq!(frame.outputs.supervisor, Supervisor::Fault { faults: Faults::OVER_SPEED });
    assert_eq!((frame.outputs.torque_nm, frame.outputs.field_kv_mm), (0.0, 0.0));
}

#[test]
fn high_voltage_that_stays_or_does_not_follow_its_command_is_found() {
    // Still there after a disable.
    let mut bench = running();
    run(&mut bench, &to(0.0), 100);
    bench.tick(&Orders { request: Request::Disable, ..to(0.0) }).unwrap();
    bench.stray_field_kv_mm = 0.2;
    let frames = run(&mut bench, &to(0.0), 220);
    let tripped = frames.iter().position(|frame| frame.outputs.supervisor.name() == "fault").unwrap();
    assert!((195..=205).contains(&tripped), "100 ms: {tripped}");
    assert_eq!(frames[tripped].outputs.supervisor.faults(), Faults::HV_PRESENT);
    // It comes without having been asked for, or does not come.
    let mut bench = running();
    run(&mut bench, &to(0.0), 100);
    bench.stray_field_kv_mm = 1.0;
    let frames = run(&mut bench, &to(0.0), 60);
    let tripped = frames.iter().position(|frame| frame.outputs.supervisor.name() == "fault").unwrap();
    assert!((40..=42).contains(&tripped), "20 ms: {tripped}");
    assert_eq!(frames[tripped].outputs.supervisor.faults(), Faults::FIELD_APART);
}

#[test]
fn a_disable_in_motion_brakes_to_rest_before_everything_goes_off() {
    let stop = |config: &Config| {
        let mut bench = running_with(config);
        // Half-way through the step, at some 9 rad/s.
        run(&mut bench, &to(STEP_RAD), 100);
        let (speed_rad_s, from_rad) = (bench.truth().velocity, bench.truth().position);
        let mut frames = vec![bench.tick(&Orders { request: Request::Disable, ..to(STEP_RAD) }).unwrap()];
        frames.extend(run(&mut bench, &to(STEP_RAD), 1000));
        assert_eq!(bench.acting(), (0.0, 0.0));
        assert_eq!(frames.last().unwrap().outputs.supervisor, Supervisor::Ready);
        (speed_rad_s, bench.truth().position - from_rad, frames)
    };
    let (speed_rad_s, controlled_rad, frames) = stop(&Config::default());
    assert!(speed_rad_s > 5.0, "{speed_rad_s}");
    assert_eq!(frames[0].outputs.supervisor, Supervisor::Stopping { faults: Faults::empty() });
    assert!(frames.iter().all(|frame| frame.outputs.torque_nm.abs() <= 10.0), "the bound of a stop");
    assert!(frames.iter().take(20).all(|frame| frame.outputs.field_kv_mm == 3.0));
    let ticks = frames.iter().position(|frame| frame.outputs.supervisor == Supervisor::Ready).unwrap();
    let (_, coasting_rad, frames) = stop(&Config { stop_on_disable: false, ..Config::default() });
    assert_eq!(frames[0].outputs.supervisor, Supervisor::Ready);
    println!(
        "{speed_rad_s:.1} rad/s: {controlled_rad:.3} rad in {ticks} ticks, or {coasting_rad:.3} rad without a stop"
    );
    assert!(controlled_rad < 0.5 * coasting_rad, "{controlled_rad} {coasting_rad}");
}

#[test]
fn a_lost_link_stops_as_the_parameters_say() {
    let silent = Orders { reference_from_link: true, ..to(STEP_RAD) };
    for (stop_on_link_loss, state) in [(false, "fault"), (true, "stopping")] {
        let mut bench = running_with(&Config { stop_on_link_loss, ..Config::default() });
        run(&mut bench, &to(STEP_RAD), 100);
        let frame = bench.tick(&silent).unwrap();
        assert_eq!(frame.outputs.supervisor.name(), state);
        let frames = run(&mut bench, &silent, 1000);
        assert_safe(&bench, frames.last().unwrap(), Faults::LINK_LOST, state);
        // A fault that forbids torque ends the stop at once.
        let mut bench = running_with(&Config { stop_on_link_loss, ..Config::default() });
        run(&mut bench, &to(STEP_RAD), 100);
        bench.tick(&silent).unwrap();
        bench.stop_released.set(false);
        bench.tick(&silent).unwrap();
        assert_eq!(bench.acting(), (0.0, 0.0));
    }
}

#[test]
fn a_pause_loses_the_position_and_motion_meanwhile_is_not_taken_for_a_small_way() {
    let mut bench = running();
    run(&mut bench, &to(0.0), 100);
    bench.tick(&Orders { request: Request::Disable, ..to(0.0) }).unwrap();
    bench.tick(&Orders { request: Request::SetPosition, reference: Counts(1000), ..Orders::default() }).unwrap();
    let state = *bench.servo.state();
    assert!(state.homed() && state.position() == Counts(1000));
    // While chips come up again the rotor is turned by one pole pair and 40 counts: 40 is all that can be seen of it.
    bench.external_torque_nm = 8.0;
    run(&mut bench, &Orders::default(), 60);
    bench.init().unwrap();
    let frame = bench.tick(&Orders::default()).unwrap();
    assert!(!bench.servo.state().homed(), "the count of pole pairs is lost, and known to be");
    assert!((0..4096).contains(&frame.outputs.position.0));
    // The heartbeat goes on with every tick.
    let levels: Vec<bool> =
        (0..4).map(|_| (bench.tick(&Orders::default()).unwrap(), bench.heartbeat.level()).1).collect();
    assert_eq!(levels[..2], levels[2..]);
    assert_ne!(levels[0], levels[1]);
}

#[test]
fn the_bound_of_a_command_holds_the_torque() {
    let mut bench = running();
    let frames = run(&mut bench, &Orders { torque_bound_nm: 2, ..to(STEP_RAD) }, 300);
    assert!(frames.iter().all(|frame| frame.outputs.torque_nm.abs() <= 2.0));
    assert!(frames.iter().any(|frame| frame.outputs.torque_nm == 2.0));
}
