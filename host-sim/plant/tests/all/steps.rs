//! Accuracy without a reference: cutting steps, closed against open loop, effects of size zero.

use crate::common::{self, TICK_S, command, distance, every_effect, run};
use plant::{Command, Mechanics, State, Timeline};

#[test]
fn half_the_step_changes_nothing() {
    let mut worst = Vec::new();
    for (name, model) in every_effect().into_iter().chain(common::combinations()) {
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

#[test]
fn effects_that_vanish_leave_the_nominal_machine() {
    let nominal = run(&common::nominal(), 2000, 1);
    for (name, model, tolerance) in common::vanishing_effects() {
        let error = distance(&nominal, &run(&model, 2000, 1));
        println!("{name}: {error:.1e} rad from nominal");
        assert!(error <= tolerance, "{name}: {error:e} rad");
    }
}

#[test]
fn stiff_springs_and_fast_slews_approach_the_nominal_machine() {
    let nominal = run(&common::nominal(), 2000, 1);
    type Build = fn(f64) -> plant::Model;
    let families: [(&str, Build); 3] = [
        ("presliding", |k| plant::Model { presliding_stiffness: Some(k), ..common::nominal() }),
        ("er_preyield", |k| common::fluid(|er| er.preyield_stiffness = Some(k))),
        ("field_slew_limit", |k| common::field(|field| field.slew_kv_mm_s = Some(k))),
    ];
    for (name, build) in families {
        let errors = [1e3, 1e4, 1e5, 1e6].map(|k| distance(&nominal, &run(&build(k), 2000, 1)));
        println!("{name} at 1e3, 1e4, 1e5, 1e6: {errors:?} rad from nominal");
        assert!(errors.is_sorted_by(|rough, fine| rough > fine) && errors[3] < 1e-3, "{name}: {errors:?}");
    }
}
