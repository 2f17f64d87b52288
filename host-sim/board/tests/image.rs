//! The release image on the emulated board: boots, refuses, follows, records.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use board::flash::{Array, Change, SECTOR_BYTES, Shared};
use board::world::INTERLOCK;
use common::flash::OnHost;
use common::{ENABLE, event, events, firmware, log, ms, recorded, run_alone, world};
use embassy_futures::block_on;
use er_servo::drivers::scaling::{FieldCode, TorqueCode};
use er_servo::events::{Event, EventLog};
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::{Answer, Command, Pace, Refusal, Target};
use er_servo::parameters::TABLE;
use er_servo::{Config, Counts, Faults, Frame, Limits, Mode, Params, State, Supervisor, step};
use rigless::mcu::Operate;
use rigless::soc::Width;
use wire::log::{Entry, Image, recordings};

/// 120 pole pairs of 12 bit.
const COUNTS_PER_REV: f64 = 491_520.0;

#[test]
fn boots_to_ready_and_ticks_at_2_khz() {
    let firmware = firmware();
    let mut world = world(&firmware, 300.0);
    world.link.at(ms(250.0), Command::Status);
    let run = firmware.run(world).unwrap();
    assert_eq!(run.session.unmapped(), vec![], "every address the image touches exists");
    assert!(run.session.resets().is_empty());
    let events = events(&log(&run));
    assert!(events[0].starts_with("er-servo"), "{events:?}");
    assert!(events.iter().any(|event| event.ends_with("ready")), "{events:?}");
    assert_eq!(run.driver.link.status().unwrap().state, 1);
    // A sample every half millisecond, and a tick that makes use of it.
    let samples = run.driver.samples.windows(2).skip(200).map(|pair| pair[1].0 - pair[0].0);
    samples.for_each(|period_ns| assert!((499_990..500_010).contains(&period_ns), "{period_ns} ns"));
    let beats = run.driver.beats.windows(2).skip(200).map(|pair| pair[1].0 - pair[0].0);
    beats.for_each(|period_ns| assert!((490_000..510_000).contains(&period_ns), "{period_ns} ns"));
}

#[test]
fn refuses_to_enable_with_the_interlock_open() {
    let firmware = firmware();
    let mut world = world(&firmware, 300.0);
    world.drive_at(ms(1.0), INTERLOCK, false);
    world.link.at(ms(150.0), ENABLE);
    world.link.at(ms(250.0), Command::Status);
    let run = firmware.run(world).unwrap();
    assert_eq!(run.driver.link.status().unwrap().state, 1);
    assert!(run.driver.commands.iter().all(|command| !command.hv_enable && command.codes == [0, 0]));
}

#[test]
fn a_step_response_of_two_seconds_is_that_of_the_host_to_the_bit() {
    let firmware = firmware();
    let mut world = world(&firmware, 2400.0);
    let step_up = run_alone(Shape::Step { amplitude_rad: std::f32::consts::FRAC_PI_6 }, 2.0);
    world.link.at(ms(100.0), Command::StartRecording { run: 42, over_link: false });
    world.link.at(ms(150.0), ENABLE);
    world.link.at(ms(160.0), step_up);
    world.link.at(ms(2300.0), Command::StopRecording);
    world.link.at(ms(2320.0), Command::Status);
    let run = firmware.run(world).unwrap();
    assert!(run.driver.link.replies.iter().all(|(_, reply)| !matches!(reply.answer, Answer::Refused(_))));

    let recordings = recorded(&run);
    let [recording] = recordings.as_slice() else { panic!("{} recordings", recordings.len()) };
    assert_eq!((recording.begin.run, recording.lost(), recording.damaged), (42, 0, 0));
    assert!(recording.frames.len() > 4300, "{} frames", recording.frames.len());

    let params = Params::new(&recording.begin.config).unwrap();
    let mut state = recording.begin.state;
    let mut turns = BTreeSet::new();
    for frame in &recording.frames {
        // What the image says it read is where the rotor stood when SAMPLE fell; so the host is fed with the same counts.
        let true_counts = (run.driver.angles_rad[frame.seq as usize + 2] / TAU * COUNTS_PER_REV).floor() as i64;
        assert_eq!(i64::from(frame.inputs.resolver.code.0), true_counts.rem_euclid(4096), "tick {}", frame.seq);
        turns.insert(true_counts - i64::from(frame.outputs.position.0));
        let outputs = step(&params, &mut state, &frame.inputs);
        assert_eq!(outputs.torque_nm.to_bits(), frame.outputs.torque_nm.to_bits(), "tick {}", frame.seq);
        assert_eq!(outputs.field_kv_mm.to_bits(), frame.outputs.field_kv_mm.to_bits(), "tick {}", frame.seq);
        assert_eq!(outputs, frame.outputs, "tick {}", frame.seq);
        // And the frame is what the DAC was told: one write a tick, in the order of the ticks.
        let torque = TorqueCode::from_torque_nm(outputs.torque_nm).bits();
        let field = FieldCode::from_field_kv_mm(outputs.field_kv_mm).bits();
        assert_eq!(written_in(&run, frame.seq), [torque, field], "tick {}", frame.seq);
    }
    // Counted across pole pairs, from the one that the image began in.
    assert!(turns.len() == 1 && turns.iter().all(|offset| offset % 4096 == 0), "{turns:?}");
    // Frames are in a ring of their own: people's log has none.
    assert!(log(&run).iter().all(|entry| matches!(entry, Entry::Event(_))));
    assert!(events(&log(&run)).iter().any(|event| event.contains("damper, ")), "the mode is told");
    // A limit is told with the tick that reached it.
    let tick_of =
        |event: &String| event.strip_prefix("tick ")?.strip_suffix(": field off over off_speed_rad_s")?.parse().ok();
    let limited: Vec<u32> = events(&log(&run)).iter().filter_map(tick_of).collect();
    let frame = |seq: &u32| recording.frames.iter().find(|frame| frame.seq == *seq).unwrap();
    assert!(!limited.is_empty(), "{:?}", events(&log(&run)));
    assert!(limited.iter().all(|seq| frame(seq).outputs.limits.contains(Limits::OVER_OFF_SPEED)), "{limited:?}");
    // The machine has moved by 30 degrees and stands within what friction holds.
    assert!(
        (run.driver.rotor.angle_rad() - 0.0123 - std::f64::consts::FRAC_PI_6).abs() < 0.01,
        "{}",
        run.driver.rotor.angle_rad()
    );
    assert!(recording.frames.iter().any(|frame| frame.outputs.supervisor == Supervisor::Running));
    println!("{:?}", run.driver.link.status());
}

#[test]
fn a_recording_over_the_link_has_every_tick_to_the_bit_beside_the_answers() {
    let firmware = firmware();
    let mut world = world(&firmware, 1500.0);
    world.link.keep_recorded();
    world.link.at(ms(100.0), Command::StartRecording { run: 43, over_link: true });
    world.link.at(ms(120.0), ENABLE);
    // The busiest line there is: everything moves, and a status is asked for every 10 ms.
    world.link.at(ms(130.0), run_alone(Shape::Chirp { amplitude_rad: 0.3, from_hz: 1.0, to_hz: 8.0 }, 1.2));
    for nth in 0..120 {
        world.link.at(ms(140.0 + 10.0 * f64::from(nth)), Command::Status);
    }
    world.link.at(ms(1400.0), Command::StopRecording);
    let mut run = firmware.run(world).unwrap();
    let entries = run.driver.link.recorded().unwrap();
    let recordings = recordings(&entries);
    let [recording] = recordings.as_slice() else { panic!("{} recordings", recordings.len()) };
    assert_eq!((recording.begin.run, recording.lost(), recording.damaged), (43, 0, 0));
    assert!(matches!(entries.last(), Some(Entry::End)));
    assert!(recording.frames.len() > 2580, "{} frames", recording.frames.len());
    assert_eq!(recording.begin.build, Image::parse(&std::fs::read(common::elf()).unwrap()).unwrap().build());
    let params = Params::new(&recording.begin.config).unwrap();
    let mut state = recording.begin.state;
    for frame in &recording.frames {
        assert_eq!(step(&params, &mut state, &frame.inputs), frame.outputs, "tick {}", frame.seq);
    }
    let statuses =
        run.driver.link.replies.iter().filter(|(_, reply)| matches!(reply.answer, Answer::Status(_))).count();
    assert_eq!(statuses, 120, "every question is answered");
    // And the log stays one for people: no frames in it.
    assert!(!log(&run).iter().any(|entry| matches!(entry, Entry::Frame(_))));
    assert!(events(&log(&run)).iter().any(|event| event.contains("damper, ")), "the mode is told");
}

/// Codes at the DAC after the write of a tick.
fn written_in(run: &common::Run, seq: u32) -> [u16; 2] {
    // The first two samples are those of the converter's start-up; a tick's load follows its sample.
    let sample = run.driver.samples[seq as usize + 2];
    let loads = &run.driver.loads;
    let loaded = loads[loads.partition_point(|at| *at <= sample)];
    run.driver.commands.iter().find(|command| command.at == loaded).unwrap().codes
}

/// What differs between the three sets: the defaults; soft gains with a slow filter and a brake that holds; stiff gains
/// without a brake and a field that saturates.
const SETS: [&[(&str, f32)]; 3] = [
    &[],
    &[("kp_nm_rad", 120.0), ("kd_nm_s_rad", 5.0), ("speed_filter_s", 0.003), ("near_rad", 0.05), ("hold", 1.0)],
    &[
        ("kp_nm_rad", 270.0),
        ("kd_nm_s_rad", 7.5),
        ("er_a", 0.03),
        ("er_q0", 3.5),
        ("er_q1_s_rad", -7.0),
        ("er_q2_s2_rad2", 2.0),
        ("field_limit_kv_mm", 2.5),
        ("near_rad", 0.0),
    ],
];
const SHAPE_S: f32 = 0.6;

fn shapes() -> [Shape; 5] {
    [
        Shape::Step { amplitude_rad: 0.5 },
        Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.15, seed: 7 },
        Shape::Multisine { amplitude_rad: 0.1, low_hz: 1.0, high_hz: 12.0, tones: 16 },
        Shape::Chirp { amplitude_rad: 0.15, from_hz: 1.0, to_hz: 10.0 },
        Shape::Ramp { speed_rad_s: 1.0, travel_rad: 0.25 },
    ]
}

/// The references of the frames must be those of the host's own sequence, from where the reference was before.
fn assert_follows(frames: &[Frame], shape: Shape, period_s: f32) {
    let sequence: Vec<Counts> = Experiment { shape, duration_s: SHAPE_S }.start(period_s).unwrap().collect();
    let reference = |at: usize| frames[at].inputs.reference.0;
    let found = (1..frames.len() - sequence.len()).find(|start| {
        let base = reference(start - 1);
        sequence.iter().enumerate().all(|(nth, offset)| reference(start + nth) == base + offset.0)
    });
    assert!(found.is_some(), "{shape:?} is not the host's");
}

#[test]
fn every_shape_and_mode_is_that_of_the_host_to_the_bit_under_three_sets_of_parameters() {
    let firmware = firmware();
    for set in SETS {
        let mut world = world(&firmware, 150.0 + 700.0 * 5.0 + 60.0);
        let mut at = 75.0;
        let mut tell = |command, wait_ms: f64| {
            world.link.at(ms(at), command);
            at += wait_ms;
        };
        for (name, value) in set {
            let index = TABLE.iter().position(|parameter| parameter.name == *name).unwrap() as u8;
            tell(Command::WriteParameter { index, value: *value }, 1.5);
        }
        tell(Command::Apply { force: true }, 1.5);
        tell(Command::StartRecording { run: 1, over_link: false }, 3.0);
        tell(ENABLE, 5.0);
        shapes().into_iter().for_each(|shape| tell(run_alone(shape, SHAPE_S), 700.0));
        // In motion, for the controlled stop.
        tell(run_alone(Shape::Step { amplitude_rad: 0.5 }, 1.0), 30.0);
        tell(Command::Disable, 0.0);
        let run = firmware.run(world).unwrap();
        assert!(run.driver.link.replies.iter().all(|(_, reply)| !matches!(reply.answer, Answer::Refused(_))));

        let recording = &recorded(&run)[0];
        let mut expected = Config::default();
        for (name, value) in set {
            (TABLE.iter().find(|parameter| parameter.name == *name).unwrap().set)(&mut expected, *value);
        }
        assert_eq!((recording.begin.config, recording.lost()), (expected, 0));
        let params = Params::new(&expected).unwrap();
        let mut state: State = recording.begin.state;
        for frame in &recording.frames {
            let outputs = step(&params, &mut state, &frame.inputs);
            assert_eq!(outputs, frame.outputs, "tick {}", frame.seq);
            assert_eq!(outputs.torque_nm.to_bits(), frame.outputs.torque_nm.to_bits(), "tick {}", frame.seq);
            assert_eq!(outputs.field_kv_mm.to_bits(), frame.outputs.field_kv_mm.to_bits(), "tick {}", frame.seq);
        }
        shapes().iter().for_each(|shape| assert_follows(&recording.frames, *shape, expected.period_s));
        let modes = [Mode::Off, Mode::Damper, Mode::Brake];
        let running = recording.frames.iter().filter(|frame| frame.outputs.supervisor == Supervisor::Running);
        let seen = modes.map(|mode| running.clone().filter(|frame| frame.outputs.mode == mode).count());
        let stopping = |frame: &&Frame| matches!(frame.outputs.supervisor, Supervisor::Stopping { .. });
        let stops = recording.frames.iter().filter(stopping).count();
        println!("{set:?}: {} ticks to the bit, modes {seen:?}, {stops} of a stop", recording.frames.len());
        assert!(seen[0] > 0 && seen[1] > 0 && (seen[2] > 0 || expected.near_rad == 0.0) && stops > 3);
    }
}

#[test]
fn a_fault_is_in_flash_and_is_told_after_the_power_was_off() {
    let firmware = firmware();
    let mut world = world(&firmware, 140.0);
    let flash = world.flash.clone();
    world.link.at(ms(76.0), ENABLE);
    world.drive_at(ms(90.0), INTERLOCK, false);
    world.drive_at(ms(95.0), INTERLOCK, true);
    world.link.at(ms(100.0), Command::ClearFault);
    world.link.at(ms(135.0), Command::Event { back: 0 });
    let first = event(&firmware.run(world).unwrap()).unwrap();
    assert_eq!((first.number, first.faults()), (0, Faults::INTERLOCK_OPEN));
    assert!((45..60).contains(&first.at_ms), "{} ms after the first tick", first.at_ms);

    // The same flash in another run: the power was off.
    let bytes = flash.lock().bytes.clone();
    let mut world = common::world(&firmware, 90.0);
    world.flash = Shared::new(Array::holding(bytes));
    world.link.at(ms(80.0), Command::Event { back: 0 });
    let run = firmware.run(world).unwrap();
    assert_eq!(event(&run), Some(first));
    assert_eq!(run.driver.flash.lock().refused, 0, "every store keeps the rules of the flash interface");
}

/// Whether the axis was homed, each time that the status was asked for.
fn homed(run: &common::Run) -> Vec<bool> {
    let answers = run.driver.link.replies.iter().map(|(_, reply)| reply.answer);
    answers.filter_map(|answer| if let Answer::Status(status) = answer { Some(status.homed) } else { None }).collect()
}

#[test]
fn a_save_costs_the_axis_its_position() {
    let firmware = firmware();
    // An erase takes up to 0.8 s, and what is homed must be so in the tick after.
    let after_ms = 1000.0;
    let mut world = world(&firmware, after_ms + 20.0);
    world.link.at(ms(77.0), Command::SetPosition { counts: 1000 });
    world.link.at(ms(80.0), Command::Status);
    world.link.at(ms(82.0), Command::Save);
    world.link.at(ms(after_ms), Command::Status);
    world.link.at(ms(after_ms + 2.0), ENABLE);
    let (target, pace) = (Target::Absolute(1000), Pace::default());
    world.link.at(ms(after_ms + 6.0), Command::Reference { target, pace, torque_bound_nm: 0 });
    let run = firmware.run(world).unwrap();
    assert_eq!(homed(&run), [true, false]);
    let last = run.driver.link.replies.last().unwrap().1.answer;
    assert_eq!(last, Answer::Refused(Refusal::NotHomed));
}

/// Faults in flash before, and those after which the log is full: a start leaves room for 64.
const FILLS_BEFORE: u32 = 448;
const FILLS: u32 = 64;
/// From one fault to the next: clear, chips settled, enabled.
const FAULT_MS: f64 = 34.0;

/// Sector 3 with so many faults in it, and parameter sectors with nothing.
fn with_events(count: u32) -> Vec<u8> {
    let mut bytes = Array::default().bytes;
    let mut flash = OnHost(&mut bytes);
    let sector = 2 * SECTOR_BYTES as u32..3 * SECTOR_BYTES as u32;
    let mut log = block_on(EventLog::open(&mut flash, sector)).unwrap();
    (0..count).for_each(|_| block_on(log.append(&mut flash, &Event::default())).unwrap());
    bytes
}

#[test]
fn an_event_log_that_fills_up_is_tidied_at_a_clear_and_keeps_the_newest() {
    let firmware = firmware();
    let first_ms = 80.0;
    let until_ms = first_ms + FAULT_MS * f64::from(FILLS);
    // An erase takes up to 0.8 s.
    let after_ms = until_ms + 900.0;
    let mut world = world(&firmware, after_ms + 80.0);
    world.flash = Shared::new(Array::holding(with_events(FILLS_BEFORE)));
    world.link.at(ms(77.0), Command::SetPosition { counts: 0 });
    for nth in 0..=FILLS {
        let at_ms = if nth < FILLS { first_ms + FAULT_MS * f64::from(nth) } else { after_ms };
        world.link.at(ms(at_ms), ENABLE);
        world.drive_at(ms(at_ms + 3.0), INTERLOCK, false);
        world.drive_at(ms(at_ms + 4.0), INTERLOCK, true);
        world.link.at(ms(at_ms + 6.0), Command::Status);
        world.link.at(ms(at_ms + 8.0), Command::ClearFault);
    }
    world.link.at(ms(after_ms + 70.0), Command::Event { back: 0 });
    let run = firmware.run(world).unwrap();
    assert!(run.session.resets().is_empty(), "the watchdog waits for the erase: {:?}", run.session.resets());
    let answers: Vec<Answer> = run.driver.link.replies.iter().map(|(_, reply)| reply.answer).collect();
    assert!(!answers.iter().any(|answer| matches!(answer, Answer::Refused(_))), "{answers:?}");
    assert_eq!(
        homed(&run).iter().position(|homed| !homed),
        Some(FILLS as usize),
        "the position is lost with the erase"
    );
    assert_eq!(
        event(&run).map(|event| (event.number, event.faults())),
        Some((FILLS_BEFORE + FILLS, Faults::INTERLOCK_OPEN))
    );
    let flash = run.driver.flash.lock();
    let erases = flash.changes.iter().filter(|change| matches!(change, Change::Erase { .. })).count();
    assert_eq!((erases, flash.refused), (1, 0));
}

#[test]
fn clears_in_a_row_do_not_starve_the_watchdog() {
    let firmware = firmware();
    let mut world = world(&firmware, 500.0);
    world.link.at(ms(76.0), ENABLE);
    world.at(ms(90.0), |_, board, _, _| board.resolver().unwrap().chip.raise_faults(0x40));
    // Each brings the chips up again, which takes 45 ms, in vain.
    for nth in 0..5 {
        world.link.at(ms(100.0 + 0.01 * f64::from(nth)), Command::ClearFault);
    }
    let run = firmware.run(world).unwrap();
    assert!(run.session.resets().is_empty(), "{:?}", run.session.resets());
    let answers =
        run.driver.link.replies.iter().filter(|(_, reply)| reply.answer == Answer::Refused(Refusal::Hardware));
    assert_eq!(answers.count(), 5, "{:?}", run.driver.link.replies);
}

/// DBGMCU APB1_FZ.
const APB1_FREEZE: u64 = 0xE004_2008;

#[test]
fn the_image_sets_the_part_up_within_its_limits() {
    let firmware = firmware();
    let mut world = world(&firmware, 120.0);
    // As a debugger would have left it, which no reset of the core clears.
    world.at(ms(0.0), |_, board, _, now| board.mcu.write(now, APB1_FREEZE, Width::W32, u64::from(u32::MAX)).unwrap());
    let mut run = firmware.run(world).unwrap();
    let now = run.stop.unwrap().at;
    let mut register = |address| run.session.board_mut().mcu.peek(now, address, Width::W32).unwrap();
    // C_ADC CCR, ADCPRE: a quarter of 84 MHz; the converter takes 36 at most.
    assert_eq!(register(0x4001_2304) >> 16 & 0b11, 0b01);
    // RCC CR, CSSON: a crystal that fails is a non-maskable interrupt.
    assert_eq!(register(0x4002_3800) >> 19 & 1, 1);
    // DBGMCU APB1_FZ: the watchdog and the timers TIM3 and TIM5 run on while a debugger holds the core.
    let kept = register(APB1_FREEZE);
    assert_eq!(kept & (1 << 12 | 1 << 1 | 1 << 3), 0, "{kept:#x}");
    assert_ne!(kept, 0, "the emulator keeps what a debugger writes");
}
