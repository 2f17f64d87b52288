//! An 8 s recording at 2 kHz replayed in windows of 100 samples, for each effect: `cargo bench -p plant --bench effects`.
#![allow(clippy::unwrap_used, missing_docs)]

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::hint::black_box;

use common::{TICK_S, command, every_effect};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use plant::{Command, Mechanics, Plant, State, Timeline};

const TICKS: usize = 16_000;
const WINDOW: usize = 100;

fn replay(c: &mut Criterion) {
    let mut group = c.benchmark_group("replay_16000_ticks");
    group.throughput(Throughput::Elements(TICKS as u64)).sample_size(10);
    let times_s: Vec<f64> = (0..TICKS).map(|tick| tick as f64 * TICK_S).collect();
    let commands: Vec<Command> = (0..TICKS).map(command).collect();
    let mut positions = vec![0.0; TICKS];
    for (name, model) in every_effect() {
        let timeline = Timeline::new(&model, &times_s, &commands, &Command::default()).unwrap();
        let mechanics = Mechanics::new(&model).unwrap();
        let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
        let mut starts = Vec::new();
        for (tick, command) in commands.iter().enumerate() {
            if tick % WINDOW == 0 {
                starts.push(*plant.state());
            }
            plant.advance(command, (tick + 1) as f64 * TICK_S).unwrap();
        }
        group.bench_function(name, |b| {
            b.iter(|| {
                for (window, start) in starts.iter().enumerate() {
                    let range = window * WINDOW..(window + 1) * WINDOW;
                    let times_s = &times_s[range.clone()];
                    mechanics.simulate(&timeline, times_s[0], *start, times_s, &mut positions[range]).unwrap();
                }
                black_box(positions[TICKS - 1])
            });
        });
    }
    group.finish();
}

criterion_group!(benches, replay);
criterion_main!(benches);
