//! A world in which the drive runs and one thing goes wrong.

use board::bench::Firmware;
use board::core::Upset;
use board::flash::{Array, SECTOR_BYTES, Shared};
use board::world::{AMPLIFIER_READY, INTERLOCK, STOP_RELEASED, World};
use er_servo::experiment::Shape;
use er_servo::link::{Command, Pace, Target};
use er_servo::{Config, storage};
use object::{Object, ObjectSection, ObjectSymbol};
use plant::chips::BusFault;
use rand::Rng;
use rand::rngs::StdRng;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use crate::cause::Cause;
use crate::common::flash::OnHost;
use crate::common::{self, ENABLE, Panics, ms, run_alone};

/// The chips are up and the drive is ready.
pub const ENABLE_MS: f64 = 76.0;
pub const STEP_MS: f64 = 82.0;

/// Where the image keeps its variables: address and size.
pub struct Variables {
    /// What the interrupt works on.
    tick: (u64, u64),
    /// Every variable in RAM but the bytes of the log's ring, by its symbol: no padding, no free memory.
    ram: Vec<(u64, u64)>,
    panics: Panics,
}

/// Top of the stack, where the frame of `main` holds what thread mode works on: log, link, parameters, storage.
const STACK_TOP: u64 = 0x1000_C000;
const MAIN_FRAME_BYTES: u64 = 1024;

pub fn variables() -> Variables {
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
    Variables { tick: (tick.address(), tick.size()), ram, panics: Panics::of(&elf) }
}

// Over 40 lines: every cause once.
pub fn prepare(
    firmware: &Firmware,
    cause: Cause,
    at_ns: u64,
    bit: u32,
    rng: &mut StdRng,
    variables: &Variables,
) -> World {
    let linked = cause == Cause::LinkCut;
    let mut world = common::world(firmware, (at_ns + cause.watched_ns()) as f64 * 1e-6);
    world.link.at(ms(ENABLE_MS), ENABLE);
    if linked {
        for nth in 0.. {
            let when_ns = (STEP_MS * 1e6) as u64 + nth * 20_000_000;
            if when_ns > at_ns {
                break;
            }
            let (target, pace) = (Target::Relative(2000 + nth as i32 * 20), Pace::default());
            world.link.at(VirtualNanos(when_ns), Command::Reference { target, pace, torque_bound_nm: 0 });
        }
    } else if cause != Cause::DamagedFlash {
        world.link.at(ms(STEP_MS), run_alone(Shape::Step { amplitude_rad: 0.02 }, 1.0));
    }
    if matches!(cause, Cause::Flood | Cause::Replay) {
        world.link.at(VirtualNanos(at_ns + 120_000_000), Command::Status);
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
        Cause::CommandBus => world.at(at, move |_, board, _, _| {
            let dac = &mut board.dac().unwrap().chip;
            match seed % 3 {
                0 => dac.deafen(true),
                1 => dac.set_bus_fault(BusFault::AllZeros, seed),
                _ => dac.overload([seed.is_multiple_of(2), true]),
            }
        }),
        Cause::FieldOver | Cause::FieldApart | Cause::StuckHighVoltage => {
            let stray_kv_mm = match cause {
                Cause::FieldOver => 3.9,
                Cause::FieldApart => rng.random_range(1.0..1.5),
                _ => rng.random_range(0.2..0.7),
            };
            world.at(at, move |world, _, _, _| world.stray_field_kv_mm = stray_kv_mm);
            if cause == Cause::StuckHighVoltage {
                world.link.at(at, Command::Disable);
            }
        }
        Cause::Amplifier => world.drive_at(at, AMPLIFIER_READY, false),
        Cause::OverSpeed => {
            let push_nm = rng.random_range(150.0..300.0) * if rng.random() { 1.0 } else { -1.0 };
            world.at(at, move |world, _, _, _| world.rotor.disturb(push_nm));
        }
        Cause::Overrun | Cause::Halt => {
            world.at(at, |_, _, host, _| host.hold(true));
            if cause == Cause::Overrun {
                let until = VirtualNanos(at_ns + rng.random_range(1_200_000..1_800_000));
                world.at(until, |_, _, host, _| host.hold(false));
            }
        }
        Cause::Panic => {
            let panics = variables.panics;
            world.at(at, move |world, _, host, _| panics.now(&world.hand, host));
        }
        Cause::HardFault => {
            // Registers of peripherals, which hold no code; nothing at all; a function of the debugger's.
            let to = [0x4000_0000, 0x7000_0000, 0xE000_0000][rng.random_range(0..3)];
            world.at(at, move |world, _, _, _| world.hand.upset(Upset::Jump { to, r0: 0 }));
        }
        Cause::StackOverflow => world.at(at, |world, _, _, _| {
            world.hand.upset(Upset::Stack { to: STACK_BOTTOM as u32 });
        }),
        Cause::TimerUpset => world.at(at, move |_, board, _, now| board.upset_timer(now, seed)),
        Cause::Crystal => world.at(at, |world, _, _, _| world.hand.upset(Upset::NonMaskable)),
        Cause::SecondClient => {
            world.at(at, |world, board, _, now| world.link.say_hello(board.terminal().unwrap(), now));
            let shape = Shape::Step { amplitude_rad: 1.0 };
            let (target, pace) = (Target::Relative(90_000), Pace::default());
            let wants = [
                run_alone(shape, 1.0),
                Command::Reference { target, pace, torque_bound_nm: 0 },
                Command::Hold { autonomous: false },
                Command::Defaults,
                Command::ClearFault,
                Command::Status,
            ];
            for (nth, command) in (1..).zip(wants) {
                world.link.at(VirtualNanos(at_ns + nth * 2_000_000), command);
            }
        }
        Cause::DamagedFlash => world.flash = Shared::new(Array::holding(damaged(rng))),
        Cause::Reset => world.reset_at = Some(at),
        Cause::NoReader => world.probe = None,
    }
    world
}

/// Just above the end of thread mode's stack.
const STACK_BOTTOM: u64 = 0x1000_0008;

/// The parameter sectors with one set in them that has lost a bit, or with noise, or with what another image has stored.
fn damaged(rng: &mut StdRng) -> Vec<u8> {
    let mut bytes = vec![0xFF; 2 * SECTOR_BYTES];
    match rng.random_range(0..3) {
        0 => {
            let mut sound = vec![0xFF; 2 * SECTOR_BYTES];
            embassy_futures::block_on(storage::save(OnHost(&mut sound), 0..sound_length(), &Config::default()))
                .unwrap();
            bytes = sound;
            // Within the values of the record; every bit is covered by its check.
            bytes[rng.random_range(12..100)] ^= 1 << rng.random_range(0..8);
        }
        1 => bytes.iter_mut().for_each(|byte| *byte = rng.random()),
        _ => bytes[rng.random_range(0..2 * SECTOR_BYTES)] = 0,
    }
    bytes
}

fn sound_length() -> u32 {
    2 * SECTOR_BYTES as u32
}
