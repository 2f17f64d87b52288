//! The fault campaign: 248 seeded cases against the unmodified image.
//!
//! Whatever happens: no field over 3.5 kV/mm, no torque over 30 N m, no hang. Where the cause can be seen at once, both
//! outputs are zero and the high voltage is off in the tick after it, and the log says why.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::sync::atomic::{AtomicUsize, Ordering};

use board::bench::Firmware;
use board::world::{CommandSeen, INTERLOCK, STOP_RELEASED, World};
use common::{Run, events, firmware, log, ms};
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::Command;
use object::{Object, ObjectSection, ObjectSymbol};
use plant::chips::BusFault;
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

const SEED: u64 = 20_260_401;
const REPEATS: u64 = 16;
/// A cause is seen by the next sample, half a millisecond later at most, and acted upon within the same tick.
const ONE_TICK_NS: u64 = 500_000 + 25_000;
const STEP_MS: f64 = 120.0;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Cause {
    ChipFault,
    Garbage,
    AllOnes,
    AllZeros,
    Jump,
    Frozen,
    Interlock,
    Stop,
    LinkCut,
    Flood,
    Replay,
    BitInTick,
    BitInRam,
    BitInStack,
    Reset,
    NoReader,
}

const CAUSES: [Cause; 15] = [
    Cause::Garbage,
    Cause::AllOnes,
    Cause::AllZeros,
    Cause::Jump,
    Cause::Frozen,
    Cause::Interlock,
    Cause::Stop,
    Cause::LinkCut,
    Cause::Flood,
    Cause::Replay,
    Cause::BitInTick,
    Cause::BitInRam,
    Cause::BitInStack,
    Cause::Reset,
    Cause::NoReader,
];

/// What must be seen of a cause.
enum Expected {
    /// Outputs zero within so many nanoseconds, and this in the log.
    Safe(u64, &'static str),
    /// The drive goes on as if nothing had happened.
    Undisturbed,
    /// Nothing but the limits, and that ticks go on (after a restart by the watchdog, if need be).
    Bounded,
}

impl Cause {
    fn expected(self) -> Expected {
        match self {
            Self::ChipFault | Self::AllOnes => Expected::Safe(ONE_TICK_NS, "resolver converter reports a fault"),
            // Noise may be a fault byte, or none and a jump.
            Self::Garbage => Expected::Safe(ONE_TICK_NS, "resolver"),
            Self::AllZeros | Self::Jump => Expected::Safe(ONE_TICK_NS, "resolver counts jumped"),
            // A rotor at rest is no fault; one at rest under a torque that must move it is, after stale_time_s (20 ms).
            Self::Frozen => Expected::Safe(21_000_000 + ONE_TICK_NS, "counts stand still under torque"),
            Self::Interlock => Expected::Safe(ONE_TICK_NS, "interlock opened"),
            Self::Stop => Expected::Safe(ONE_TICK_NS, "emergency stop pressed"),
            // The cause is the silence, which is one after 250 ms.
            Self::LinkCut => Expected::Safe(250_000_000 + ONE_TICK_NS, "command link lost"),
            Self::Reset => Expected::Safe(ONE_TICK_NS, "er-servo"),
            Self::Flood | Self::Replay | Self::NoReader => Expected::Undisturbed,
            // A flipped bit in a reference or a state is a value like any other; in the parameters it is a fault.
            Self::BitInTick | Self::BitInRam | Self::BitInStack => Expected::Bounded,
        }
    }
}

/// Where the image keeps its variables: address and size.
struct Variables {
    /// What the interrupt works on.
    tick: (u64, u64),
    /// Every variable in RAM but the bytes of the log's ring, by its symbol: no padding, no free memory.
    ram: Vec<(u64, u64)>,
}

/// Top of the stack, where the frame of `main` holds what thread mode works on: log, link, parameters, storage.
const STACK_TOP: u64 = 0x1001_0000;
const MAIN_FRAME_BYTES: u64 = 1024;

fn variables() -> Variables {
    let bytes = std::fs::read(common::elf()).unwrap();
    let elf = object::File::parse(&*bytes).unwrap();
    let tick = elf.symbols().find(|symbol| symbol.name().is_ok_and(|name| name.contains("4tick4TICK"))).unwrap();
    let in_ram = |address: u64| {
        [".data", ".bss"]
            .map(|name| elf.section_by_name(name).unwrap())
            .iter()
            .any(|section| (section.address()..section.address() + section.size()).contains(&address))
    };
    let ram = elf.symbols().filter(|symbol| symbol.size() > 0 && in_ram(symbol.address()));
    let ram: Vec<_> = ram.map(|symbol| (symbol.address(), symbol.size())).collect();
    assert!(ram.len() > 5, "the image has lost its symbols: {ram:?}");
    Variables { tick: (tick.address(), tick.size()), ram }
}

fn prepare(firmware: &Firmware, cause: Cause, at_ns: u64, bit: u32, rng: &mut StdRng, variables: &Variables) -> World {
    let linked = cause == Cause::LinkCut;
    let end_ns = at_ns + if linked { 300_000_000 } else { 160_000_000 };
    let mut world = common::world(firmware, end_ns as f64 * 1e-6);
    world.link.at(ms(100.0), Command::Enable);
    if linked {
        for nth in 0.. {
            let when_ns = 110_000_000 + nth * 20_000_000;
            if when_ns > at_ns {
                break;
            }
            world.link.at(VirtualNanos(when_ns), Command::Reference { counts: 2000 + nth as i32 * 20 });
        }
    } else {
        let shape = Shape::Step { amplitude_rad: 0.02 };
        world.link.at(ms(STEP_MS), Command::Run(Experiment { shape, duration_s: 1.0 }));
    }
    if matches!(cause, Cause::Flood | Cause::Replay) {
        world.link.at(VirtualNanos(at_ns + 130_000_000), Command::Status);
    }
    let at = VirtualNanos(at_ns);
    let seed: u64 = rng.random();
    match cause {
        Cause::ChipFault => world.at(at, move |_, board, _, _| {
            board.resolver().unwrap().chip.raise_faults(1 << bit);
        }),
        Cause::Garbage | Cause::AllOnes | Cause::AllZeros => world.at(at, move |_, board, _, _| {
            let fault = match cause {
                Cause::Garbage => BusFault::Garbage,
                Cause::AllOnes => BusFault::AllOnes,
                _ => BusFault::AllZeros,
            };
            board.resolver().unwrap().chip.set_bus_fault(fault, seed);
        }),
        Cause::Jump => {
            // Beyond what 6500 rad/s2 and the 45 rad/s of the defaults can reach in a tick, either way.
            let counts = rng.random_range(400..1700) * if rng.random() { 1 } else { -1 };
            world.at(at, move |_, board, _, _| board.resolver().unwrap().chip.jump(counts));
        }
        Cause::Frozen => world.at(at, |_, board, _, _| board.resolver().unwrap().chip.freeze(true)),
        Cause::Interlock => world.drive_at(at, INTERLOCK, false),
        Cause::Stop => world.drive_at(at, STOP_RELEASED, false),
        Cause::LinkCut => {}
        Cause::Flood => {
            let bytes: Vec<u8> = (0..5000).map(|_| rng.random()).collect();
            world.at(at, move |_, board, _, now| board.terminal().unwrap().send(now, &bytes));
        }
        Cause::Replay => world.at(at, |world, board, _, now| {
            let again = world.link.last_sent.repeat(100);
            board.terminal().unwrap().send(now, &again);
        }),
        Cause::BitInTick | Cause::BitInRam | Cause::BitInStack => {
            let (start, size) = match cause {
                Cause::BitInTick => variables.tick,
                Cause::BitInStack => (STACK_TOP - MAIN_FRAME_BYTES, MAIN_FRAME_BYTES),
                _ => variables.ram[rng.random_range(0..variables.ram.len())],
            };
            let (address, bit) = (start + rng.random_range(0..size), rng.random_range(0..8));
            world.at(at, move |_, _, host, _| {
                let byte = host.read(address, Width::W8).unwrap();
                host.write(address, Width::W8, byte ^ 1 << bit).unwrap();
                assert_ne!(host.read(address, Width::W8).unwrap(), byte, "the flip has hit");
            });
        }
        Cause::Reset => world.reset_at = Some(at),
        Cause::NoReader => world.probe = None,
    }
    world
}

fn is_safe(command: &CommandSeen) -> bool {
    command.torque_nm == 0.0 && command.field_kv_mm == 0.0 && !command.hv_enable
}

/// What is wrong with the run, if anything.
fn verdict(run: &Run, cause: Cause, at_ns: u64) -> Result<(), String> {
    let commands = &run.driver.commands;
    let end_ns = run.stop.unwrap().at.0;
    for command in commands {
        if command.torque_nm.abs() > 30.0 || command.field_kv_mm > 3.5 {
            return Err(format!("beyond the limits: {command:?}"));
        }
    }
    let last = run.driver.samples.last().unwrap().0;
    if end_ns - last > 1_000_000 {
        // Only a restart is an excuse: the chips take 45 ms to come up.
        let restarted = run.session.resets().last().is_some_and(|reset| end_ns - reset.at.0 < 60_000_000);
        if !restarted {
            return Err(format!("hangs: last sample at {last} ns of {end_ns}"));
        }
    }
    let before = commands.iter().rev().find(|command| command.at.0 < at_ns).unwrap();
    if !before.hv_enable {
        return Err("the drive was not running before".to_owned());
    }
    match cause.expected() {
        Expected::Safe(within_ns, sentence) => {
            let until = if cause == Cause::LinkCut { last_heard_ns(run) } else { at_ns } + within_ns;
            let state = commands.iter().rev().find(|command| command.at.0 <= until).unwrap();
            if !is_safe(state) || commands.iter().any(|command| command.at.0 > until && !is_safe(command)) {
                return Err(format!("not safe {within_ns} ns after the cause at {at_ns}: {state:?}"));
            }
            let events = events(&log(run));
            if !events.iter().any(|event| event.contains(sentence)) {
                return Err(format!("the log does not say `{sentence}`: {events:?}"));
            }
            let boots = events.iter().filter(|event| event.starts_with("er-servo")).count();
            if cause == Cause::Reset && (boots != 2 || !events.last().unwrap().ends_with("ready")) {
                return Err(format!("does not come up again: {events:?}"));
            }
        }
        Expected::Undisturbed => {
            if !commands.last().unwrap().hv_enable || !run.session.resets().is_empty() {
                return Err("the drive stopped".to_owned());
            }
            let counters = run.driver.link.status().map(|status| status.counters).unwrap_or_default();
            let counted = match cause {
                Cause::Flood => counters.damaged + counters.overlong,
                Cause::Replay => counters.replayed,
                _ => 1,
            };
            if counted == 0 {
                return Err(format!("not counted: {counters:?}"));
            }
            let late = run
                .driver
                .samples
                .windows(2)
                .skip(100)
                .find(|pair| !(499_000..501_000).contains(&(pair[1].0 - pair[0].0)));
            if let Some(pair) = late {
                return Err(format!("a tick was disturbed: {pair:?}"));
            }
        }
        Expected::Bounded => {
            // It goes on, or it stands still in its safe state; and where the watchdog restarted it, the log says so.
            let state = commands.last().unwrap();
            if !state.hv_enable && !is_safe(state) {
                return Err(format!("commands without the high voltage: {state:?}"));
            }
            if let Some(reset) = run.session.resets().first()
                && commands.iter().any(|command| command.at.0 > reset.at.0 && !is_safe(command))
            {
                return Err("commands after a restart".to_owned());
            }
        }
    }
    Ok(())
}

/// When the drive last heard of the link: the last answer, as every packet is answered.
fn last_heard_ns(run: &Run) -> u64 {
    run.driver.link.replies.last().unwrap().0.0
}

#[test]
fn two_hundred_and_forty_eight_cases() {
    let firmware = firmware();
    let variables = variables();
    let mut cases: Vec<(Cause, u64, u32)> = Vec::new();
    for repeat in 0..REPEATS {
        cases.extend(CAUSES.iter().map(|cause| (*cause, repeat, 0)));
    }
    cases.extend((0..8).map(|bit| (Cause::ChipFault, u64::from(bit), bit)));
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut failed = Vec::new();
        while let Some((cause, repeat, bit)) = cases.get(next.fetch_add(1, Ordering::Relaxed)).copied() {
            let seed = SEED ^ (repeat << 8) ^ cause as u64;
            let mut rng = StdRng::seed_from_u64(seed);
            // The frozen resolver freezes while there is torque to see it by: just after the step.
            let span_ns = if cause == Cause::Frozen { 600_000..4_000_000 } else { 1_000_000..60_000_000 };
            let at_ns = (STEP_MS * 1e6) as u64 + rng.random_range(span_ns);
            let run = firmware.run(prepare(&firmware, cause, at_ns, bit, &mut rng, &variables)).unwrap();
            if let Err(why) = verdict(&run, cause, at_ns) {
                let failure = format!("{cause:?} {bit}, seed {seed:#x}, at {at_ns} ns: {why}");
                println!("{failure}");
                failed.push(failure);
            }
        }
        failed
    };
    let failed: Vec<String> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..2).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    assert!(failed.is_empty(), "{} of {} cases failed:\n{}", failed.len(), cases.len(), failed.join("\n"));
    println!("{} cases, seed {SEED}: all passed", cases.len());
}
