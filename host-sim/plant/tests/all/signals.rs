//! Delays, lags, limits and the sensor: what acts when, and what is reported when.

use crate::common::{self, TICK_S, command, field, nominal};
use plant::effects::{Harmonic, Pulse};
use plant::sensor::{LatencyLine, Rounding, Sampler, SamplerConfig, SensorModel, TorqueNoise};
use plant::{Command, Er, Error, FluidResponse, Mechanics, Model, Plant, Segment, State, Timeline};

fn timeline(model: &Model, times_s: &[f64], commands: &[Command]) -> Timeline {
    Timeline::new(model, times_s, commands, &Command::default()).unwrap()
}

fn at(timeline: &Timeline, t_s: f64) -> (&Segment, f64) {
    let segment = timeline.segments().iter().find(|segment| segment.end_s > t_s).unwrap();
    (segment, t_s - segment.start_s)
}

fn torque(timeline: &Timeline, t_s: f64) -> f64 {
    let (segment, dt_s) = at(timeline, t_s);
    segment.torque.at(dt_s)
}

fn fluid(timeline: &Timeline, t_s: f64) -> f64 {
    let (segment, dt_s) = at(timeline, t_s);
    segment.fluid.at(dt_s)
}

#[test]
fn fractional_delays_act_in_order_and_segments_leave_no_gap() {
    // Uneven ticks: each change arrives its own delay after its own time.
    let times_s = [0.0, 0.0004, 0.0011, 0.0013, 0.0024];
    let commands: Vec<Command> = (1..=5).map(|n| Command::new(f64::from(n), 0.5 * f64::from(n))).collect();
    let model = Model { torque_delay_s: 0.00413, er: Some(Er::new(0.0704, 0.47, 0.00237, 0.0)), ..Model::paper() };
    let timeline = timeline(&model, &times_s, &commands);
    for pair in timeline.segments().windows(2) {
        assert_eq!(pair[0].end_s, pair[1].start_s);
        assert!(pair[0].end_s > pair[0].start_s);
    }
    for (index, t_s) in times_s.iter().enumerate() {
        let n = index as f64 + 1.0;
        assert_eq!(torque(&timeline, t_s + 0.00413 - 1e-7), n - 1.0);
        assert_eq!(torque(&timeline, t_s + 0.00413 + 1e-7), n);
        assert_eq!(fluid(&timeline, t_s + 0.00237 - 1e-7), 0.5 * (n - 1.0));
        assert_eq!(fluid(&timeline, t_s + 0.00237 + 1e-7), 0.5 * n);
    }
    assert_eq!(timeline.segments().last().unwrap().end_s, f64::INFINITY);
}

#[test]
fn zero_delay_acts_at_once_and_a_delay_longer_than_the_run_never() {
    let command = Command::new(2.0, 1.0);
    for (delay_s, moves) in [(0.0, true), (5.0, false)] {
        let model = Model { torque_delay_s: delay_s, er: None, ..Model::paper() };
        let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
        for tick in 1..=100 {
            plant.advance(&command, f64::from(tick) * TICK_S).unwrap();
        }
        let expected = if moves { 0.5 * (2.0 - 0.763) / 0.075 * 0.05 * 0.05 } else { 0.0 };
        assert!((plant.state().position - expected).abs() < 1e-15);
    }
}

#[test]
fn whole_tick_delays_make_one_segment_a_tick() {
    let times_s: Vec<f64> = (0..2000).map(|tick| f64::from(tick) * TICK_S).collect();
    let commands: Vec<Command> = (0..2000).map(command).collect();
    let segments = timeline(&nominal(), &times_s, &commands).segments().len();
    // Delays of whole ticks fall together with the ticks; the tail and the settling of the lag add a few.
    assert!((2000..2030).contains(&segments), "{segments}");
}

#[test]
fn lag_slew_and_their_asymmetry_follow_their_formulas() {
    let step = [Command::new(0.0, 2.0), Command::new(0.0, 0.0)];
    let asymmetric = field(|f| (f.dead_time_s, f.rise_s, f.fall_s) = (0.0, 0.003, 0.008));
    let timeline_1 = timeline(&asymmetric, &[0.0, 0.1], &step);
    assert!((fluid(&timeline_1, 0.004) - 2.0 * (1.0 - f64::exp(-4.0 / 3.0))).abs() < 1e-14);
    assert!((fluid(&timeline_1, 0.104) - 2.0 * f64::exp(-0.5)).abs() < 1e-13);

    let slew = field(|f| (f.dead_time_s, f.rise_s, f.fall_s, f.slew_kv_mm_s) = (0.001, 0.0, 0.0, Some(100.0)));
    let timeline_2 = timeline(&slew, &[0.0, 0.1], &step);
    assert!((fluid(&timeline_2, 0.011) - 1.0).abs() < 1e-14);
    assert!((fluid(&timeline_2, 0.05) - 2.0).abs() < 1e-14);
    assert!((fluid(&timeline_2, 0.111) - 1.0).abs() < 1e-13);

    let both = field(|f| (f.dead_time_s, f.slew_kv_mm_s) = (0.0, Some(100.0)));
    let timeline_3 = timeline(&both, &[0.0, 0.1], &step);
    let ramp = |t_s: f64| 100.0 * (t_s - 0.003 * (1.0 - f64::exp(-t_s / 0.003)));
    assert!((fluid(&timeline_3, 0.013) - ramp(0.013)).abs() < 1e-13);
}

#[test]
fn drive_limits_in_their_order() {
    let model = Model {
        torque_gain: 2.0,
        torque_offset: 0.5,
        torque_deadband: 0.25,
        torque_limit: Some(5.0),
        torque_delay_s: 0.0,
        ..Model::paper()
    };
    for (command, acting) in [(0.2, 0.5), (-0.25, 0.5), (1.25, 2.5), (-1.25, -1.5), (4.0, 5.0), (-4.0, -5.0)] {
        let timeline = timeline(&model, &[0.0], &[Command::new(command, 0.0)]);
        assert_eq!(torque(&timeline, 0.1), acting, "command {command}");
    }
}

#[test]
fn braking_is_a_channel_of_its_own() {
    let torque_limit = 2.5;
    let response = FluidResponse::ViscosityDeadTime { dead_time_s: 0.01, torque_limit };
    let model = common::with_response(response);
    let damping = Command { speed_estimate: 0.5, ..Command::new(0.0, 1.0) };
    let braking = Command { braking: true, ..Command::new(0.0, 3.0) };
    let timeline = timeline(&model, &[0.0, 0.02], &[damping, braking]);
    assert!((fluid(&timeline, 0.015) - (0.0704 + 0.47) / 0.5).abs() < 1e-15);
    assert_eq!(at(&timeline, 0.015).0.brake_torque.at(0.0), 0.0);
    assert_eq!(fluid(&timeline, 0.035), 0.0);
    assert!((at(&timeline, 0.035).0.brake_torque.at(0.0) - 2.0436).abs() < 1e-13);
}

#[test]
fn pulses_start_and_end_in_mid_tick() {
    let pulse = Pulse { start_s: 0.01013, duration_s: 0.02, amplitude: 4.0 };
    let model = Model { coulomb: 0.0, er: None, pulses: vec![pulse], ..Model::paper() };
    let mut plant = Plant::new(&model, State::default(), 0.0).unwrap();
    for tick in 1..=100 {
        plant.advance(&Command::default(), f64::from(tick) * TICK_S).unwrap();
    }
    assert!((plant.state().velocity - 4.0 * 0.02 / 0.075).abs() < 1e-13);
}

#[test]
fn late_and_eccentric_positions_are_exact_in_open_loop() {
    let ticks = 600;
    let times_s: Vec<f64> = (0..ticks).map(|tick| f64::from(tick) * TICK_S).collect();
    let commands: Vec<Command> = (0..ticks as usize).map(command).collect();
    let harmonic = Harmonic { amplitude: 1e-3, order: 2.0, phase_rad: 0.3 };
    let run = |latency_s: f64, eccentricity: Vec<Harmonic>, sample_times_s: &[f64]| {
        let model = Model { sensor: SensorModel { latency_s, eccentricity }, ..nominal() };
        let mut positions = vec![0.0; sample_times_s.len()];
        let timeline = timeline(&model, &times_s, &commands);
        let mechanics = Mechanics::new(&model).unwrap();
        mechanics.simulate(&timeline, 0.0, State::default(), sample_times_s, &mut positions).unwrap();
        positions
    };
    for latency_s in [0.00123, -0.00077] {
        let late = run(latency_s, Vec::new(), &times_s);
        // The state at the start is the one reported there; before the first torque acts it does not matter which.
        let shifted: Vec<f64> = times_s.iter().map(|t_s| (t_s - latency_s).max(0.0)).collect();
        let truth = run(0.0, Vec::new(), &shifted);
        let error = late.iter().zip(&truth).map(|(l, t)| (l - t).abs()).fold(0.0, f64::max);
        assert!(error < 1e-14, "{latency_s}: {error:e}");
    }
    let truth = run(0.0, Vec::new(), &times_s);
    for (measured, position) in run(0.0, vec![harmonic], &times_s).iter().zip(&truth) {
        assert!((measured - position - 1e-3 * (2.0 * position + 0.3).sin()).abs() < 1e-15);
    }
    // Closed loop: the delay line interpolates.
    let mut line = LatencyLine::new(0.00123).unwrap();
    let mut plant = Plant::new(&nominal(), State::default(), 0.0).unwrap();
    let exact = run(0.00123, Vec::new(), &times_s);
    for (index, t_s) in times_s.iter().enumerate() {
        let reported = line.report(*t_s, plant.state());
        assert!((reported - exact[index]).abs() < 1e-6, "{reported} {}", exact[index]);
        plant.advance(&commands[index], (index + 1) as f64 * TICK_S).unwrap();
    }
}

#[test]
fn sampler_rounds_draws_and_repeats() {
    let config = SamplerConfig { resolution: 0.1, ..SamplerConfig::default() };
    let mut nearest = Sampler::new(config, 1).unwrap();
    let mut floor = Sampler::new(SamplerConfig { rounding: Rounding::Floor, ..config }, 1).unwrap();
    for (position, up, down) in [(0.16, 0.2, 0.1), (-0.16, -0.2, -0.2), (0.0, 0.0, 0.0)] {
        assert!((nearest.measure(position) - up).abs() < 1e-15 && (floor.measure(position) - down).abs() < 1e-15);
    }
    let noisy = SamplerConfig { noise_sd: 0.01, glitch_fraction: 0.02, glitch_size: 5.0, ..SamplerConfig::default() };
    let draw = |seed| {
        let mut sampler = Sampler::new(noisy, seed).unwrap();
        (0..20_000).map(|_| sampler.measure(1.0)).collect::<Vec<f64>>()
    };
    let samples = draw(7);
    assert_eq!(samples, draw(7));
    assert_ne!(samples, draw(8));
    let (glitches, clean): (Vec<f64>, Vec<f64>) = samples.iter().partition(|&&sample| (sample - 1.0).abs() > 1.0);
    assert!((0.017..0.023).contains(&(glitches.len() as f64 / 20_000.0)));
    let variance = clean.iter().map(|sample| (sample - 1.0).powi(2)).sum::<f64>() / clean.len() as f64;
    assert!((variance.sqrt() / 0.01 - 1.0).abs() < 0.03);
    let mut noise = TorqueNoise::new(0.2, 3).unwrap();
    let power = (0..20_000).map(|_| noise.draw().powi(2)).sum::<f64>() / 20_000.0;
    assert!((power.sqrt() / 0.2 - 1.0).abs() < 0.03);
}

#[test]
fn bad_input_is_named_and_nothing_moves() {
    let refused = |model: Model| Plant::new(&model, State::default(), 0.0).unwrap_err().to_string();
    assert_eq!(refused(Model::new(0.0)), "inertia = 0: must be a finite number above 0");
    assert!(refused(Model { coulomb: f64::NAN, ..nominal() }).starts_with("coulomb = NaN"));
    assert!(refused(common::fluid(|er| er.a = -1.0)).starts_with("er.a = -1"));
    let mut plant = Plant::new(&nominal(), State::new(0.0, 1.0), 0.0).unwrap();
    let before = *plant.state();
    assert!(matches!(plant.advance(&Command::new(f64::NAN, 0.0), 1.0), Err(Error::Command { .. })));
    assert!(matches!(plant.advance(&Command::default(), -1.0), Err(Error::Time { .. })));
    assert!(matches!(plant.advance(&Command::default(), f64::INFINITY), Err(Error::Time { .. })));
    assert_eq!(*plant.state(), before);
    let commands = [Command::default(); 2];
    let build = |times_s: &[f64]| Timeline::new(&nominal(), times_s, &commands, &Command::default());
    assert!(matches!(build(&[0.0, 0.0]), Err(Error::Time { .. })));
    assert!(matches!(build(&[0.0]), Err(Error::Length { .. })));
    assert!(matches!(build(&[0.0, f64::NAN]), Err(Error::Time { .. })));
    let mechanics = Mechanics::new(&nominal()).unwrap();
    let timeline = build(&[0.0, 1.0]).unwrap();
    let simulate = |times_s: &[f64]| {
        let mut out = vec![0.0; times_s.len()];
        mechanics.simulate(&timeline, 0.0, State::default(), times_s, &mut out)
    };
    assert!(matches!(simulate(&[0.5, 0.2]), Err(Error::Time { .. })));
    assert!(matches!(simulate(&[-0.5]), Err(Error::Time { .. })));
}
