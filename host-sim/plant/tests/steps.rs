//! Accuracy without a reference: cutting steps, closed against open loop, effects of size zero.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{TICK_S, command, distance, every_effect, run};
use plant::{Command, Mechanics, State, Timeline};

#[test]
fn half_the_step_changes_nothing() {
    let mut worst = Vec::new();
    for (name, model) in every_effect() {
        let whole = run(&model, 2000, 1);
        let (halves, sevenths) = (distance(&whole, &run(&model, 2000, 2)), distance(&whole, &run(&model, 2000, 7)));
        println!("{name}: half step {halves:.1e} rad, a seventh {sevenths:.1e} rad; moved {:.3}", whole[1999].position);
        if !(halves < 1e-9 && sevenths < 1e-9) {
            worst.push((name, halves, sevenths));
        }
    }
    assert!(worst.is_empty(), "{worst:?}");
}

#[test]
fn open_loop_repeats_closed_loop() {
    let ticks = 1000;
    let commands: Vec<Command> = (0..ticks).map(command).collect();
    let times_s: Vec<f64> = (0..ticks).map(|tick| tick as f64 * TICK_S).collect();
    for (name, model) in every_effect() {
        let closed = run(&model, ticks, 1);
        let timeline = Timeline::new(&model, &times_s, &commands, &Command::default()).unwrap();
        let mut positions = vec![0.0; ticks];
        let mechanics = Mechanics::new(&model).unwrap();
        mechanics.simulate(&timeline, 0.0, State::default(), &times_s, &mut positions).unwrap();
        let error = closed.iter().zip(&positions[1..]).map(|(s, p)| (s.position - p).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{name}: {error:e} rad");
        // From the middle, warm: the state of the closed loop there and the rest of the recording.
        let (from, start_s) = (400, times_s[400]);
        let rest = &mut positions[from..];
        mechanics.simulate(&timeline, start_s, closed[from - 1], &times_s[from..], rest).unwrap();
        let error = closed[from..].iter().zip(&rest[1..]).map(|(s, p)| (s.position - p).abs()).fold(0.0, f64::max);
        assert!(error < 1e-12, "{name} from the middle: {error:e} rad");
    }
}
