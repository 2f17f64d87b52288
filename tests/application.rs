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
    let cases: [(&str, Injection, Orders, Faults); 5] = [
        ("interlock", |b| b.interlock_closed.set(false), step, Faults::INTERLOCK_OPEN),
        ("stop", |b| b.stop_released.set(false), step, Faults::STOP_PRESSED),
        ("field monitor", |b| b.stray_field_kv_mm = 3.9, step, Faults::FIELD_OVER),
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
