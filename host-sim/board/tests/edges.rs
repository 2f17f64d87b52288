//! SAMPLE and LDAC by the timer: what a tick that comes late, and a core that stops, leave at the outputs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use board::bench::Firmware;
use board::core::Upset;
use board::world::{CommandSeen, INTERLOCK, World};
use common::{ENABLE, Panics, Run, event, events, firmware, log, ms, recorded, run_alone, world};
use er_servo::drivers::scaling::{FieldCode, TorqueCode};
use er_servo::events::Restart;
use er_servo::experiment::Shape;
use er_servo::link::Command;
use er_servo::{Faults, Frame, SAMPLE_TO_OUTPUT_NS};
use rigless::time::VirtualNanos;

const TO_OUTPUT_NS: u64 = SAMPLE_TO_OUTPUT_NS as u64;
/// The drive is in motion, so that torque and field change with every tick.
const MOVING_MS: f64 = 100.0;
/// What is left of an experiment after that.
const END_MS: f64 = 108.0;
/// The watchdog has restarted the drive after at most 196 ms, and it has come up again.
const RESTARTED_MS: f64 = MOVING_MS + 300.0;
/// An interrupt that the image does not use.
const EXTI0: u8 = 6;
/// A core that is disturbed needs this long to its first output, ns: entry, and the few instructions of a handler.
const AT_ONCE_NS: u64 = 2_000;

fn moving(firmware: &Firmware) -> World {
    moving_until(firmware, END_MS)
}

fn moving_until(firmware: &Firmware, end_ms: f64) -> World {
    let mut world = world(firmware, end_ms);
    world.link.at(ms(74.0), Command::StartRecording { run: 1, over_link: false });
    world.link.at(ms(80.0), ENABLE);
    world.link.at(ms(84.0), run_alone(Shape::Step { amplitude_rad: 0.5 }, 1.0));
    world
}

/// The instants of the samples are those of every run on this image: nothing that a test does changes them.
fn sample_after_ms(firmware: &Firmware, after_ms: f64) -> u64 {
    let run = firmware.run(moving(firmware)).unwrap();
    run.driver.samples.iter().find(|at| **at > ms(after_ms)).unwrap().0
}

fn is_off(command: &CommandSeen) -> bool {
    command.torque_nm == 0.0 && command.field_kv_mm == 0.0 && !command.hv_enable
}

fn codes(frame: &Frame) -> [u16; 2] {
    let (torque, field) = (frame.outputs.torque_nm, frame.outputs.field_kv_mm);
    [TorqueCode::from_torque_nm(torque).bits(), FieldCode::from_field_kv_mm(field).bits()]
}

/// Every pair that was ever at the outputs is one that a tick has decided on, and never a half of two.
fn assert_whole(run: &Run, what: &str) {
    let frames = &recorded(run)[0].frames;
    let decided: Vec<[u16; 2]> = frames.iter().map(codes).chain([[0, 0]]).collect();
    for command in run.driver.commands.iter().filter(|command| command.at > ms(78.0)) {
        assert!(decided.contains(&command.codes), "{what}: {command:?} is no pair");
    }
}

#[test]
fn a_late_tick_gives_its_pair_whole_or_not_at_all() {
    let firmware = firmware();
    let sample_ns = sample_after_ms(&firmware, MOVING_MS);
    let (mut late, mut on_time) = (0, 0);
    // The core stands still from an instant in the tick on, for less than it has time and for more, up to two ticks.
    for from_ns in [0, 2_500, 6_000, 8_500, 9_500, 10_500, 12_500] {
        for still_ns in [3_000, 19_000, 24_000, 90_000, 1_010_000] {
            let mut world = moving(&firmware);
            let from = VirtualNanos(sample_ns + from_ns);
            world.at(from, |_, _, host, _| host.hold(true));
            world.at(VirtualNanos(from.0 + still_ns), |_, _, host, _| host.hold(false));
            let run = firmware.run(world).unwrap();
            let what = format!("halted {from_ns} ns after the sample for {still_ns} ns");
            assert_whole(&run, &what);
            // A core that stands still within a transfer may lose a byte of it: that is told as what it is.
            let told = ["a control tick overran", "command DAC not written", "resolver could not be read"];
            let events = events(&log(&run));
            let told = events.iter().any(|event| told.iter().any(|sentence| event.contains(sentence)));
            let running = run.driver.commands.last().unwrap().hv_enable;
            assert_eq!(told, !running, "{what}: told and off, or neither: {events:?}");
            let loads: Vec<u64> = run.driver.loads.iter().map(|at| at.0).filter(|at| *at > sample_ns).collect();
            if running {
                let off_time = loads.iter().find(|at| (**at - sample_ns) % 500_000 > TO_OUTPUT_NS + 12);
                assert_eq!(off_time, None, "{what}: at the outputs at another instant, and the drive goes on");
                on_time += 1;
            } else {
                // Off in the tick after the late pair at the latest.
                let off =
                    run.driver.commands.iter().find(|command| command.at.0 > sample_ns && is_off(command)).unwrap();
                assert!(off.at.0 <= from.0 + still_ns + 500_000 + TO_OUTPUT_NS, "{what}: {off:?}");
                late += 1;
            }
        }
    }
    println!("{late} late ticks stopped the drive, {on_time} were in time; no half of a pair");
    assert!(late > 10 && on_time > 10);
}

#[test]
fn a_fault_does_not_wait_for_the_instant_of_the_outputs() {
    let firmware = firmware();
    let sample_ns = sample_after_ms(&firmware, MOVING_MS);
    let mut world = moving(&firmware);
    world.drive_at(VirtualNanos(sample_ns - 1_000), INTERLOCK, false);
    let run = firmware.run(world).unwrap();
    let off = run.driver.commands.iter().find(|command| command.at.0 > sample_ns && is_off(command)).unwrap();
    println!("off {} ns after the sample that saw the interlock open", off.at.0 - sample_ns);
    assert!(off.at.0 - sample_ns < TO_OUTPUT_NS / 2, "{off:?} for the sample at {sample_ns}");
    assert!(run.driver.commands.iter().all(|command| command.at < off.at || is_off(command)));
    assert_whole(&run, "interlock");
}

#[test]
fn a_core_that_stops_for_good_takes_the_outputs_off_at_once_whatever_ldac_does() {
    let firmware = firmware();
    let sample_ns = sample_after_ms(&firmware, MOVING_MS);
    let bytes = std::fs::read(common::elf()).unwrap();
    let panics = Panics::of(&object::File::parse(&*bytes).unwrap());
    // Before the read, while the law is worked out and written, and while LDAC is armed and has still to fall; later the core
    // sleeps.
    for after_ns in [500, 3_000, 8_000, 10_000, 11_000, 13_000] {
        for cause in ["panic", "hard fault", "non-maskable interrupt"] {
            let mut world = moving(&firmware);
            let at = VirtualNanos(sample_ns + after_ns);
            world.at(at, move |world, _, host, _| match cause {
                "panic" => panics.now(&world.hand, host),
                "hard fault" => world.hand.upset(Upset::Jump { to: 0x4000_0000, r0: 0 }),
                _ => world.hand.upset(Upset::NonMaskable),
            });
            let run = firmware.run(world).unwrap();
            let what = format!("{cause} {after_ns} ns after the sample");
            let commands = &run.driver.commands;
            let off = commands.iter().find(|command| command.at >= at && is_off(command)).expect(&what);
            assert!(off.at.0 <= at.0 + AT_ONCE_NS, "{what}: {off:?}");
            // LDAC may fall after that: CLR holds the outputs.
            assert!(commands.iter().all(|command| command.at <= off.at || is_off(command)), "{what}");
        }
    }
}

#[test]
fn an_interrupt_without_a_handler_takes_the_outputs_off_and_is_told_after_the_restart() {
    let firmware = firmware();
    // At the beginning of a tick, whose priority is the same: it waits for the tick's end.
    let at = VirtualNanos(sample_after_ms(&firmware, MOVING_MS) + 500);
    let mut world = moving_until(&firmware, RESTARTED_MS);
    world.at(at, |world, _, _, _| world.hand.upset(Upset::Interrupt(EXTI0)));
    let run = firmware.run(world).unwrap();
    let commands = &run.driver.commands;
    let off = commands.iter().find(|command| command.at >= at && is_off(command)).unwrap();
    println!("off {} ns after the interrupt", off.at.0 - at.0);
    assert!(off.at.0 <= at.0 + TO_OUTPUT_NS, "{off:?}");
    assert!(commands.iter().all(|command| command.at <= off.at || is_off(command)));
    assert_eq!(run.session.resets().len(), 1);
    let events = events(&log(&run));
    assert!(events.iter().any(|event| event.contains("has no handler")), "{events:?}");
}

/// What the log says of the time that the drive ran before its last reset, ms.
fn ran_ms(events: &[String]) -> Option<u64> {
    let said = events.iter().rev().find_map(|event| event.strip_prefix("before this reset the drive ran for "))?;
    said.strip_suffix(" ms")?.parse().ok()
}

/// The line of the panic that the log tells after the restart.
fn panicked_at(events: &[String]) -> u16 {
    let place = events.iter().find_map(|event| event.strip_prefix("it panicked at src/")).unwrap();
    place.rsplit_once(':').unwrap().1.parse().unwrap()
}

#[test]
fn why_the_drive_restarted_and_how_long_it_ran_is_told_with_and_without_a_probe() {
    let firmware = firmware();
    let at = VirtualNanos(sample_after_ms(&firmware, MOVING_MS) + 3_000);
    let bytes = std::fs::read(common::elf()).unwrap();
    let panics = Panics::of(&object::File::parse(&*bytes).unwrap());
    let causes = [
        Restart::Watchdog,
        Restart::Panic(0),
        Restart::HardFault,
        Restart::ClockFailed,
        Restart::Interrupt(EXTI0.into()),
    ];
    for restart in causes {
        let mut world = moving_until(&firmware, RESTARTED_MS + 90.0);
        world.at(at, move |world, _, host, _| match restart {
            Restart::Watchdog => host.hold(true),
            Restart::Panic(_) => panics.now(&world.hand, host),
            Restart::HardFault => world.hand.upset(Upset::Jump { to: 0x4000_0000, r0: 0 }),
            Restart::ClockFailed => world.hand.upset(Upset::NonMaskable),
            Restart::Interrupt(_) => world.hand.upset(Upset::Interrupt(EXTI0)),
        });
        // Later than the watchdog's slowest restart.
        world.at(VirtualNanos(at.0 + 200_000_000), |_, _, host, _| host.hold(false));
        world.at(ms(RESTARTED_MS + 60.0), |world, board, _, now| world.link.say_hello(board.terminal().unwrap(), now));
        world.link.at(ms(RESTARTED_MS + 70.0), Command::Event { back: 0 });
        let run = firmware.run(world).unwrap();
        assert_eq!(run.session.resets().len(), 1, "{restart:?}");
        let (found, events) = (event(&run).unwrap(), events(&log(&run)));
        // Of which line, the log knows.
        let expected = if let Restart::Panic(_) = restart { Restart::Panic(panicked_at(&events)) } else { restart };
        assert_eq!((found.faults(), found.restart), (Faults::ABNORMAL_RESET, Some(expected)));
        // The first two samples are those of the converter's start-up; a tick that is cut off is not counted.
        let ticks = run.driver.samples.iter().filter(|sample| **sample < at).count() as u64 - 2;
        let ran_ms = ran_ms(&events).expect("the log says for how long it ran");
        assert!((ticks / 2 - 1..=ticks / 2 + 1).contains(&ran_ms), "{restart:?}: {ran_ms} ms of {ticks} ticks");
    }
}
