//! Each law of these kinds by itself: what it does to a motion that is given.

use std::f64::consts::PI;

use super::super::Hidden;
use super::super::given_motion::{STEP_S, along, last, near, seen};
use super::{drive, fluid, loads, moments, once, sensor};

/// Torques of a drive at rest under commands over the time.
fn driven(seconds: f64, mut drive: impl Hidden, command: impl Fn(f64) -> f64) -> Vec<f64> {
    along(seconds, |_| 0.0, |at| drive.drive(at, command(at.t_s)))
}

#[test]
fn torque_rises_otherwise_than_it_falls() {
    let on = |t_s: f64| if t_s < 0.5 { 2.0 } else { 0.0 };
    let torques = driven(1.0, drive::DiodeFalls::new(&[0.1]), on);
    assert!(torques[0] == 2.0 && near(torques[6000], 2.0 * (-1.0_f64).exp()), "{}", torques[6000]);
    // The other way it rises at once as soon as it has fallen to nothing: of 2 to -2 after ln 2.
    let turns = driven(1.0, drive::DiodeFalls::new(&[0.1]), |t_s| if t_s < 0.5 { 2.0 } else { -2.0 });
    let rises = 5000 + (0.1 * 2.0_f64.ln() / STEP_S) as usize;
    assert!(turns[rises - 10] > 0.0 && turns[rises + 10] == -2.0);
    // Of a root: (1 - t / 2)^2 is missing, and nothing after twice the time.
    let fills = driven(0.5, drive::OrificeFills::new(&[0.1, 2.0]), |_| 2.0);
    assert!(near(fills[1000], 1.5) && near(fills[2100], 2.0), "{} {}", fills[1000], fills[2100]);
    let booster = driven(0.5, drive::BoosterLags::new(&[0.1, 1.5]), |_| 2.0);
    assert!(near(booster[0], 1.5) && near(booster[1000], 2.0 - 0.5 * (-1.0_f64).exp()));
    let small = driven(0.5, drive::BoosterLags::new(&[0.1, 1.5]), |t_s| (20.0 * t_s).sin());
    assert!(small.iter().enumerate().all(|(row, torque)| near(*torque, (20.0 * STEP_S * row as f64).sin())));
}

#[test]
fn a_spool_stays_until_it_is_asked_far_enough() {
    let mut sticks = drive::SpoolSticks::new(&[0.5]);
    let torques = [0.4, 0.6, 0.2, 0.0, -0.4].map(|torque| sticks.drive(&seen(0.0, 0.0, 0.0, 0.0), torque));
    assert_eq!(torques, [0.0, 0.6, 0.6, 0.0, 0.0]);
    // After a long rest a step within the band is not obeyed, after a short one it is.
    let steps = |rest_s: f64| {
        let spool = drive::SpoolSilts::new(&[1.0, 0.1, 0.1]);
        let torques = driven(2.0, spool, |t_s| {
            if t_s < 1.0 {
                0.0
            } else if t_s < 1.0 + rest_s {
                2.0
            } else {
                1.5
            }
        });
        (torques[9000], torques[10_000], torques[10_010 + (rest_s / STEP_S) as usize])
    };
    assert_eq!(steps(0.05), (0.0, 2.0, 1.5));
    assert_eq!(steps(0.5), (0.0, 2.0, 2.0));
}

#[test]
fn commands_are_held_over_a_loss_and_late_at_speed() {
    let lost = |pattern: f64| driven(4.0, drive::FramesLost::new(&[0.5, 0.1, pattern]), |t_s| t_s);
    let torques = lost(1.0);
    let behind = torques.iter().enumerate().map(|(row, torque)| STEP_S * row as f64 - torque);
    let held = behind.clone().filter(|by| *by > 1e-9).count();
    // Half of some of the 40 whiles, by half a while at most.
    assert!((4000..12_000).contains(&held) && behind.clone().fold(0.0, f64::max) < 0.0501, "{held}");
    assert!(behind.fold(0.0, f64::min) > -1e-12 && torques == lost(1.0) && torques != lost(2.0));
    let late = |speed: f64| {
        let mut busy = drive::BusyLoop::new(&[0.01, 2.0]);
        1.0 - last(&along(1.0, |_| speed, |at| busy.drive(at, at.t_s))) - STEP_S
    };
    assert!(near(late(0.0), 0.0) && near(late(-2.0), 0.01) && near(late(1.0), 0.0025), "{} {}", late(-2.0), late(1.0));
    assert!(near(late(100.0), 0.04), "{}", late(100.0));
}

/// Mean torque in the last part of a motion.
fn settled(torques: &[f64]) -> f64 {
    let late = &torques[torques.len() / 2..];
    late.iter().sum::<f64>() / late.len() as f64
}

#[test]
fn a_coupling_takes_its_load_along_until_it_skips() {
    let magnet = |gain: f64, damping_ratio: f64| {
        let mut load = loads::MagnetCoupling::new(&[0.5, 10.0, damping_ratio, 3.0, 100.0]);
        along(2.0, |t_s| gain * t_s, |at| load.torque(at))
    };
    // The most is omega^2 over the poles, 39: below that all of the load is taken along.
    assert!(near(settled(&magnet(20.0, 0.2)), -0.5 * 3.0 * 20.0));
    // Far beyond, pole after pole pulls it on and back.
    assert!(settled(&magnet(400.0, 0.0)).abs() < 0.5 * 3.0 * 4.0);
    let balls = |gain: f64, until_s: f64| {
        let mut load = loads::BallDetent::new(&[0.5, 10.0, 0.2, 3.0, 0.01]);
        along(20.0, |t_s| gain * t_s.min(until_s), |at| load.torque(at))
    };
    // The most is omega^2 twist, 39 again.
    assert!(near(settled(&balls(20.0, 1e9)), -0.5 * 3.0 * 20.0));
    let thrown = balls(200.0, 0.1);
    let most = thrown.iter().map(|torque| torque.abs()).fold(0.0, f64::max);
    // Thrown out, dragged along by what the balls rub, and held again at rest.
    assert!(most < 0.5 * 3.0 * 600.0 && settled(&thrown).abs() < 1e-6, "{most}");
    assert!(near(loads::BallDetent::new(&[0.5, 1.0, 0.0, 1.0, 1.0]).inertia(&seen(0.0, 0.0, 0.0, 0.0)), 0.5));
}

#[test]
fn a_weight_falls_no_faster_than_it_can() {
    let weight = |gain: f64| {
        let mut weight = loads::WeightJumps::new(&[0.5, 20.0, 3.0, 10.0]);
        along(2.0, |t_s| gain * t_s, |at| weight.torque(at))
    };
    assert!(weight(0.0).iter().all(|torque| torque.abs() < 1e-9));
    assert!(near(settled(&weight(8.0)), -0.5 * 3.0 * 8.0) && near(settled(&weight(-8.0)), 0.5 * 3.0 * 8.0));
    // Slack: the axis has all of the balance, and no more.
    assert!(near(settled(&weight(-20.0)), 0.5 * 3.0 * 10.0) && near(last(&weight(-20.0)), 15.0));
    let mut lands = loads::WeightLands::new(&[0.5, 20.0, 3.0, 10.0, 0.1]);
    let speed = |t_s: f64| if t_s < 2.0 { -0.2 } else { 0.2 };
    let torques = along(4.0, speed, |at| lands.torque(at));
    // Half a second down and half a second before the end.
    assert!(torques[4000..4800].iter().all(|torque| torque.abs() < 0.3) && near(torques[9000], 15.0));
    assert!(near(torques[34_000], 15.0) && last(&torques).abs() < 0.2, "{} {}", torques[34_000], last(&torques));
}

#[test]
fn a_base_moves_only_where_it_is_pushed_and_stops() {
    let base = |mut base: Box<dyn Hidden>, push: &dyn Fn(f64) -> f64| {
        along(3.0, |_| 0.0, |at| base.torque(&seen(at.t_s, 0.0, 0.0, push(at.t_s))))
    };
    let pushed = |push: f64| move |t_s: f64| if t_s < 1.0 { push } else { 0.0 };
    let still = base(Box::new(loads::FeetSlide::new(&[0.5, 2.0])), &pushed(1.9));
    assert!(still.iter().all(|torque| *torque == 0.0));
    let slides = base(Box::new(loads::FeetSlide::new(&[0.5, 2.0])), &pushed(3.0));
    // Gains 1 for a second, loses 2 for half a second, then stands.
    assert!(near(slides[5000], 0.5) && near(slides[12_000], -1.0) && slides[15_100] == 0.0);
    assert!(near(slides.iter().sum::<f64>(), 0.0));
    let raft = base(Box::new(loads::RaftTurns::new(&[0.5, 25.0])), &|_| 4.0);
    // At first free, later as fast as the water lets it: 0.4, a tenth of a second's push.
    assert!(near(raft[0], 2.0) && last(&raft).abs() < 1e-3 && near(raft.iter().sum::<f64>() * STEP_S, 0.5 * 0.4));
}

#[test]
fn a_drive_that_asks_nothing_brakes() {
    let mut shorted = moments::ShortedIdle([2.0, 1.0]);
    let drags = [0.0, 0.5, -1.0, 1.5].map(|torque| shorted.friction(&seen(0.0, 0.0, 1.0, torque)).viscous);
    assert!(drags.iter().zip([2.0, 2.0, 1.0, 0.0]).all(|(drag, wanted)| near(*drag, wanted)), "{drags:?}");
    let mut brake = moments::HoldingBrake::new(&[3.0, 1.0, 0.1]);
    let idle = |t_s: f64| (0.2..0.25).contains(&t_s) || (0.4..0.8).contains(&t_s);
    let push = |t_s: f64| if idle(t_s) { 0.5 } else { -2.0 };
    let levels = along(1.0, |_| 0.0, |at| brake.friction(&seen(at.t_s, 0.0, 0.0, push(at.t_s))).level);
    // Not for a short while; after the time, for as long after.
    assert!(levels[..4900].iter().all(|level| *level == 0.0) && near(levels[7500], 3.0) && near(levels[8900], 3.0));
    assert!(near(levels[9200], 3.0 * (-1.0_f64).exp()), "{}", levels[9200]);
}

#[test]
fn what_lets_go_does_so_once() {
    let mut spring = once::SpringUnhooks::new(&[1.0, 2.0]);
    let torques = [0.4, -0.5, 0.6, 0.4].map(|at| spring.torque(&seen(0.0, at, 0.0, 0.0)));
    assert_eq!(torques, [-0.8, 1.0, 0.0, 0.0]);
    let mut peg = once::PegShears::new(&[0.4, 2.0, 0.5]);
    let inertias = along(1.0, |_| 0.0, |at| peg.torque(&seen(at.t_s, 0.0, 0.0, -2.0)) + peg.inertia(at));
    assert!(inertias[4990] == 1.0 && inertias[5010] == 0.6);
    // Twice the torque tires eight times as fast.
    let mut peg = once::PegShears::new(&[0.4, 2.0, 0.5]);
    let inertias = along(1.0, |_| 0.0, |at| peg.torque(&seen(at.t_s, 0.0, 0.0, 4.0)) + peg.inertia(at));
    assert!(inertias[620] == 1.0 && inertias[630] == 0.6);
    let torques = driven(2.0, once::FuseTrips::new(&[0.5, 4.0, 1e-3]), |t_s| if t_s < 1.5 { 2.0 } else { 0.5 });
    assert!(torques[9990] == 2.0 && near(torques[10_100], 1.0) && near(last(&torques), 0.25));
}

#[test]
fn what_comes_by_itself_asks_no_motion() {
    let pushes = |pattern: f64| {
        let mut push = moments::Telegraph([2.0, 0.01, pattern]);
        along(4.0, |_| 0.0, |at| push.torque(at))
    };
    let torques = pushes(1.0);
    let changes = torques.windows(2).filter(|two| two[0] * two[1] < 0.0).count();
    let mean = torques.iter().sum::<f64>() / 4e4;
    // Half of the 400 whiles are not as the one before.
    assert!(mean.abs() < 0.4 && (160..240).contains(&changes), "{mean} {changes}");
    assert!(
        torques.iter().all(|torque| torque.abs() < 2.0 + 1e-12) && torques == pushes(1.0) && torques != pushes(2.0)
    );
    let mut balance = moments::ToppedUp([2.0, 0.5, PI]);
    let torques = along(2.0, |_| 0.0, |at| balance.torque(at));
    // Half a period on: it leaks for nine parts and is filled up over one.
    assert!(near(torques[0], -2.0 / 9.0) && near(torques[2000], -2.0) && near(torques[2500], 2.0), "{}", torques[0]);
    assert!(torques.iter().sum::<f64>().abs() < 40.0 && near(torques[7000], torques[2000]));
}

#[test]
fn a_tone_sounds_while_it_is_excited() {
    let loudest = |torques: &[f64]| torques.iter().map(|torque| torque.abs()).fold(0.0, f64::max);
    let speed = |t_s: f64| if t_s < 1.0 { 0.5 } else { 2.0 };
    let mut squeals = moments::Squeals::new(&[3.0, 20.0, 1.0]);
    let torques = along(2.0, speed, |at| squeals.torque(at));
    assert!(near(loudest(&torques[5000..10_000]), 3.0) && loudest(&torques[15_000..]) < 0.01);
    assert!(torques[5000..10_000].windows(2).filter(|two| two[0] * two[1] < 0.0).count().abs_diff(20) <= 1);
    let mut rests = moments::Squeals::new(&[3.0, 20.0, 1.0]);
    assert!(along(1.0, |_| 0.05, |at| rests.torque(at)).iter().all(|torque| *torque == 0.0));
    let mut cut = moments::CutChatters::new(&[3.0, 20.0, 1.0]);
    let torques = along(3.0, |t_s| if t_s < 1.0 { -2.0 } else { speed(3.0 - t_s) }, |at| cut.torque(at));
    // Under a torque of 1: not backward, forward at more than 1.
    assert!(loudest(&torques[..10_000]) == 0.0 && near(loudest(&torques[15_000..20_000]), 3.0));
    assert!(loudest(&torques[25_000..]) < 0.01);
}

#[test]
fn a_thrust_and_the_bus_change_the_drag() {
    let mut squeezes = fluid::ThrustSqueezes([0.4, 2.0]);
    let drags = [0.0, 2.0, -2.0, 1e6].map(|torque| squeezes.drag(&seen(0.0, 0.0, 0.0, torque), 3.0));
    assert!(drags.iter().zip([2.4, 3.0, 3.0, 3.6]).all(|(drag, wanted)| near(*drag, wanted)), "{drags:?}");
    let mut moves = fluid::ThrustMoves([0.4, 2.0]);
    let drags = [0.0, 1e6, -1e6].map(|torque| moves.drag(&seen(0.0, 0.0, 0.0, torque), 3.0));
    assert!(drags.iter().zip([3.0, 4.2, 1.8]).all(|(drag, wanted)| near(*drag, wanted)), "{drags:?}");
    let mut sags = fluid::BusSags([0.4, 2.0]);
    let drags = [-9.0, 2.0, 1e6].map(|speed| sags.drag(&seen(0.0, 0.0, speed, 1.0), 3.0));
    assert!(drags.iter().zip([3.6, 3.0, 2.4]).all(|(drag, wanted)| near(*drag, wanted)), "{drags:?}");
    let mut pumped = fluid::BusPumped::new(&[0.4, 2.0, 0.1]);
    // A power of 20 over 2 for a tenth of a second: a store of 1.
    let drags = along(3.0, |t_s| if t_s < 1.0 { -20.0 } else { 20.0 }, |at| pumped.drag(at, 3.0));
    assert!(drags[0] < 3.01 && near(drags[9990], 3.0 * 1.2) && near(last(&drags), 3.0), "{}", drags[9990]);
}

#[test]
fn a_reading_is_smoothed_by_how_it_moves() {
    let behind = |speed: f64| {
        let mut smooth = sensor::AdaptiveSmoothing::new(&[0.02, 1.0, 1e-3]);
        let at = |row: u32| speed * 1e-3 * f64::from(row);
        let errors = (0..2000).map(|row| at(row) - smooth.measured(at(row))).collect::<Vec<f64>>();
        last(&errors) / speed
    };
    // Late by the time when slow, by half of it at the speed.
    assert!(
        near(behind(0.01), 0.02) && near(behind(1.0), 0.01) && behind(30.0) < 1e-4,
        "{} {}",
        behind(0.01),
        behind(1.0)
    );
    let mut slewed = sensor::SlewedReading::new(&[0.5, 100.0, 1e-3]);
    let read = [0.1, 0.3, 0.3, 0.3, 0.25].map(|at| slewed.measured(at));
    assert!(read.iter().zip([0.1, 0.25, 0.3, 0.3, 0.25]).all(|(read, wanted)| near(*read, wanted)), "{read:?}");
}

#[test]
fn a_sensor_is_right_again_at_its_mark_and_at_rest() {
    let mut index = sensor::IndexResets::new(&[0.1, 0.5]);
    let errors = [0.2, 0.4, 0.2, 0.6, 0.8].map(|at| index.measured(at) - at);
    assert!(
        errors.iter().zip([0.02, 0.04, 0.06, 0.01, 0.03]).all(|(error, wanted)| near(*error, wanted)),
        "{errors:?}"
    );
    let mut gyro = sensor::RestUpdates::new(&[0.2, 0.1, 0.05, 1e-3]);
    let position = |row: u32| f64::from(row.min(1000)) * 1e-3;
    let errors = (0..2000).map(|row| gyro.measured(position(row)) - position(row)).collect::<Vec<f64>>();
    assert!(near(errors[1000], 0.2) && near(errors[1050], 0.2 * (-1.0_f64).exp()) && near(last(&errors), 0.0));
}
