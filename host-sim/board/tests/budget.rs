//! What a tick costs and what it may reach, on the release image.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use board::world::World;

use common::{ENABLE, firmware, ms, recorded, run_alone, world};
use er_servo::Mode;
use er_servo::experiment::Shape;
use er_servo::link::{Answer, Command};
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

/// Instructions of the whole interrupt, waits for the buses included.
const MOST_INSTRUCTIONS: u64 = 2500;

/// The stacks of thread mode and of the handlers, all of the core-coupled memory, from their tops down.
const STACKS: [std::ops::Range<u64>; 2] = [0x1000_0000..0x1000_C000, 0x1000_C000..0x1001_0000];
/// Every mode and every experiment.
const END_MS: f64 = 10_300.0;
/// The drive runs from here on.
const RUNNING_NS: u64 = 101_500_000;
/// One count of the timer, rounded up, ns.
const COUNT_NS: u64 = 12;
const PAINT: u64 = 0xA5A5_A5A5;

/// Paints the stacks before the first instruction, and measures at the end how much of the paint is gone from each.
fn measure_stacks(world: &mut World, end_ms: f64) -> [Arc<AtomicU64>; 2] {
    let used: [Arc<AtomicU64>; 2] = Default::default();
    let result = used.clone();
    world.at(ms(0.0), |_, _, host, _| {
        let words = STACKS.iter().flat_map(|stack| stack.clone().step_by(4));
        words.for_each(|address| host.write(address, Width::W32, PAINT).unwrap());
    });
    world.at(ms(end_ms - 1.0), move |_, _, host, _| {
        for (stack, used) in STACKS.iter().zip(&result) {
            let mut words = stack.clone().step_by(4);
            let deepest = words.find(|address| host.read(*address, Width::W32).unwrap() != PAINT);
            used.store(stack.end - deepest.unwrap(), Ordering::Relaxed);
        }
    });
    used
}

/// From the falling edge of SAMPLE to the instant that follows it in `instants`, ns, shortest first; of every tick from
/// `from_ns` on.
fn after_sample_ns(run: &common::Run, instants: &[VirtualNanos], from_ns: u64) -> Vec<u64> {
    let after = |sample: u64| Some(instants.get(instants.partition_point(|at| at.0 <= sample))?.0 - sample);
    let samples = run.driver.samples.iter().filter(|sample| sample.0 > from_ns);
    let mut delays: Vec<u64> = samples.filter_map(|sample| after(sample.0)).collect();
    delays.sort_unstable();
    delays
}

/// The functions of an image: address to name, size, and code.
struct Code {
    functions: BTreeMap<u64, (String, u64)>,
    text: Vec<u8>,
    start: u64,
}

impl Code {
    fn read() -> Self {
        let bytes = std::fs::read(common::elf()).unwrap();
        let elf = object::File::parse(&*bytes).unwrap();
        let text = elf.section_by_name(".text").unwrap();
        let functions = elf.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0);
        Self {
            functions: functions
                .map(|symbol| (symbol.address() & !1, (symbol.name().unwrap().to_owned(), symbol.size())))
                .collect(),
            text: text.data().unwrap().to_vec(),
            start: text.address(),
        }
    }

    fn half(&self, address: u64) -> u16 {
        let at = (address - self.start) as usize;
        u16::from_le_bytes([self.text[at], self.text[at + 1]])
    }

    /// Address, first and second halfword of every instruction of a function; data among them reads as some instruction.
    fn instructions(&self, function: u64) -> Vec<(u64, u16, Option<u16>)> {
        let end = function + self.functions[&function].1;
        let mut found = Vec::new();
        let mut at = function;
        while at + 2 <= end {
            let first = self.half(at);
            let wide = first >> 11 >= 0b11101 && at + 4 <= end;
            found.push((at, first, wide.then(|| self.half(at + 2))));
            at += if wide { 4 } else { 2 };
        }
        found
    }

    fn at(&self, name: &str) -> u64 {
        *self.functions.iter().find(|(_, (known, _))| known == name).unwrap().0
    }

    /// Where a function returns: `bx lr`, or a pop that takes the program counter.
    fn returns(&self, function: u64) -> Vec<u64> {
        let instructions = self.instructions(function).into_iter();
        instructions
            .filter(|(_, first, second)| match second {
                None => *first == 0x4770 || first & 0xFF00 == 0xBD00,
                Some(second) => *first == 0xE8BD && second & 0x8000 != 0,
            })
            .map(|(at, _, _)| at)
            .collect()
    }

    /// Functions that a function calls or jumps to (BL and B.W).
    fn calls(&self, function: u64) -> BTreeSet<u64> {
        let mut found = BTreeSet::new();
        for (at, first, second) in self.instructions(function) {
            let Some(second) = second else { continue };
            let branches = first & 0xF800 == 0xF000 && (second & 0xD000 == 0xD000 || second & 0xD000 == 0x9000);
            if !branches {
                continue;
            }
            let bit = |word: u16, nth: u16| i64::from(word >> nth & 1);
            let sign = bit(first, 10);
            let (i1, i2) = (1 - (bit(second, 13) ^ sign), 1 - (bit(second, 11) ^ sign));
            let offset =
                -(sign << 24) | i1 << 23 | i2 << 22 | i64::from(first & 0x3FF) << 12 | i64::from(second & 0x7FF) << 1;
            let target = (at as i64 + 4 + offset) as u64;
            if self.functions.contains_key(&target) {
                found.insert(target);
            }
        }
        found
    }

    /// Calls through a register (BLX), which no one can follow.
    fn indirect_calls(&self, function: u64) -> usize {
        let instructions = self.instructions(function).into_iter();
        instructions.filter(|(_, first, second)| second.is_none() && first & 0xFF87 == 0x4780).count()
    }

    /// Every function that can be reached from one.
    fn reachable(&self, from: u64) -> BTreeSet<u64> {
        let (mut seen, mut open) = (BTreeSet::from([from]), vec![from]);
        while let Some(function) = open.pop() {
            for called in self.calls(function) {
                if seen.insert(called) {
                    open.push(called);
                }
            }
        }
        seen
    }
}

#[test]
fn the_tick_reaches_no_panic_and_no_double_precision() {
    let code = Code::read();
    let reachable = code.reachable(code.at("TIM3"));
    println!("{} functions are reachable from the tick", reachable.len());
    assert_eq!(reachable.iter().map(|function| code.indirect_calls(*function)).sum::<usize>(), 0);
    let names: Vec<&str> = reachable.iter().map(|function| code.functions[function].0.as_str()).collect();
    let bad: Vec<_> = names
        .iter()
        .filter(|name| {
            ["panic", "__aeabi_d", "unwrap_failed", "expect_failed", "slice_index_fail", "defmt"]
                .iter()
                .any(|word| name.contains(word))
        })
        .collect();
    assert!(bad.is_empty(), "{bad:?}");
}

#[test]
fn the_tick_keeps_its_budget_in_every_mode() {
    let (firmware, code) = (firmware(), Code::read());
    let mut world = world(&firmware, END_MS);
    let stacks = measure_stacks(&mut world, END_MS);
    let handler = code.at("TIM3");
    let returns = code.returns(handler);
    world.watch = returns.iter().copied().chain([handler]).collect();
    let shapes = [
        Shape::Step { amplitude_rad: 0.5 },
        Shape::Steps { amplitude_rad: 0.5, dwell_s: 0.25, seed: 1 },
        Shape::Multisine { amplitude_rad: 0.2, low_hz: 0.5, high_hz: 8.0, tones: 16 },
        Shape::Chirp { amplitude_rad: 0.2, from_hz: 0.5, to_hz: 8.0 },
        Shape::Ramp { speed_rad_s: 1.0, travel_rad: 0.5 },
    ];
    world.link.at(ms(90.0), Command::StartRecording { run: 1, over_link: false });
    world.link.at(ms(100.0), ENABLE);
    for (nth, shape) in shapes.into_iter().enumerate() {
        world.link.at(ms(120.0 + 2000.0 * nth as f64), run_alone(shape, 1.95));
    }
    let run = firmware.run(world).unwrap();

    let mut entered = None;
    let mut instructions = Vec::new();
    for (address, count) in &run.driver.hits {
        if *address == handler {
            entered = Some(*count);
        } else if let Some(from) = entered.take() {
            instructions.push(count - from + 1);
        }
    }
    instructions.sort_unstable();
    // The first conversion is started long before the first tick.
    let mut law = run.driver.law_instructions[1..].to_vec();
    law.sort_unstable();
    let recording = &recorded(&run)[0];
    for mode in [Mode::Off, Mode::Damper, Mode::Brake] {
        assert!(recording.frames.iter().any(|frame| frame.outputs.mode == mode), "{mode:?} was never used");
    }
    let bytes = run.driver.probe.as_ref().unwrap().frames.bytes.len();
    let (median, worst) = (instructions[instructions.len() / 2], instructions[instructions.len() - 1]);
    println!("{} ticks: median {median}, worst {worst} instructions of {MOST_INSTRUCTIONS}", instructions.len());
    println!("of which the law: median {}, worst {}", law[law.len() / 2], law[law.len() - 1]);
    println!("RTT: {:.1} bytes a tick; {} frames lost", bytes as f64 / recording.frames.len() as f64, recording.lost());
    for ((name, stack), used) in ["thread mode", "handlers"].iter().zip(&STACKS).zip(&stacks) {
        let (used, size) = (used.load(Ordering::Relaxed), stack.end - stack.start);
        println!("stack of {name}: {used} of {size} bytes at its deepest");
        // Half of it is for what a path that this run does not take may add.
        assert!((64..=size / 2).contains(&used), "stack of {name}: {used} bytes");
    }
    let told_ns = run.driver.link.replies.iter().find_map(|(_, reply)| match reply.answer {
        Answer::Hello { sample_to_output_ns, .. } => Some(u64::from(sample_to_output_ns)),
        _ => None,
    });
    let told_ns = told_ns.unwrap();
    // Running from the tick after the enable to the end.
    let ends = |delays: &[u64]| (delays[0], delays[delays.len() - 1], delays.len());
    let (least, most, ticks) = ends(&after_sample_ns(&run, &run.driver.loads, RUNNING_NS));
    println!("SAMPLE to the outputs: {least} to {most} ns in {ticks} ticks; the image says {told_ns}");
    // Machine files are written with what the image says; the board sees an edge at the end of an instruction.
    assert!(told_ns <= least && most <= told_ns + COUNT_NS, "{least} to {most} ns, not {told_ns}");
    assert!(ticks > 20_000, "{ticks} ticks");
    let (least, most, _) = ends(&after_sample_ns(&run, &run.driver.armed, RUNNING_NS));
    println!("commands ready {least} to {most} ns after SAMPLE, at one instruction a cycle");
    // A core takes more than a cycle for an instruction: half of the time is left for that.
    assert!(most <= told_ns / 2, "ready after {most} ns of {told_ns}");
    assert_eq!(recording.lost(), 0);
    assert!(worst <= MOST_INSTRUCTIONS, "worst tick {worst} instructions");
}
