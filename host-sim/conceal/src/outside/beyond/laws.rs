//! Each law of these kinds by itself: what it does to a motion that is given.

use std::f64::consts::{PI, TAU};

use super::super::Hidden;
use super::super::given_motion::{STEP_S, along, last, near, seen};
use super::{drive, fluid, friction, mechanics, scatter, sensor};

#[test]
fn torque_waits_for_the_flux_and_has_all_of_it_then() {
    let mut builds = drive::FluxBuilds::new(&[0.1, 1.0]);
    let torques = along(1.0, |_| 0.0, |at| builds.drive(at, 1.0));
    assert!(torques[0] < 0.3 && near(last(&torques), 1.0), "{} {}", torques[0], last(&torques));
    let mut returns = drive::FluxReturnsLate::new(&[0.1, 1.0]);
    let speed = |t_s: f64| if t_s < 1.0 { 3.0 } else { 0.5 };
    let torques = along(2.0, speed, |at| returns.drive(at, 1.0));
    assert!(near(torques[9_990], 1.0) && torques[10_010] < 0.4 && near(last(&torques), 1.0));
}

#[test]
fn a_drive_protects_its_winding_and_its_bus() {
    let mut folds = drive::Foldback::new(&[1.0, 1.0, 0.1]);
    let torques = along(1.0, |_| 0.0, |at| folds.drive(at, 2.0));
    assert!(torques[0] == 2.0 && torques.contains(&1.0));
    let mut fills = drive::BusFills::new(&[0.5, 1.0]);
    let brakes = along(2.0, |_| 1.0, |at| fills.drive(at, -1.0));
    assert!(brakes[0] == -1.0 && near(last(&brakes), -0.5), "{}", last(&brakes));
    let drives = along(2.0, |_| 1.0, |at| fills.drive(at, 1.0));
    assert!(drives.iter().all(|torque| *torque == 1.0) && fills.drive(&seen(0.0, 0.0, 1.0, 0.0), -1.0) == -1.0);
}

#[test]
fn ranges_change_at_another_value_up_than_down() {
    let mut ranges = drive::TwoRanges::new(&[0.2, 1.0]);
    let gains = [0.8, 1.1, 0.8, 0.4, 0.8].map(|torque| ranges.drive(&seen(0.0, 0.0, 0.0, 0.0), torque) / torque);
    assert!(gains.iter().zip([1.2, 1.0, 1.0, 1.2, 1.2]).all(|(gain, wanted)| near(*gain, wanted)), "{gains:?}");
    let mut windings = drive::Reconnects::new(&[0.01, 1.0]);
    let torques = along(1.0, |t_s| 2.0 * (PI * t_s).sin(), |at| windings.drive(at, 1.0));
    // Up once and down once, each time without torque for the pause.
    assert!(near(torques.iter().map(|torque| (1.0 - torque) * STEP_S).sum::<f64>(), 0.02));
}

#[test]
fn chance_is_fair_and_the_same_in_a_recording() {
    let shares: Vec<f64> = (0..10_000).map(|place| scatter(f64::from(place) - 5000.0, 0.7)).collect();
    let mean = shares.iter().sum::<f64>() / 1e4;
    let next = shares.windows(2).map(|at| (at[0] - 0.5) * (at[1] - 0.5)).sum::<f64>() / 1e4;
    assert!((mean - 0.5).abs() < 0.02 && next.abs() < 0.005, "{mean} {next}");
    assert!(scatter(3.0, 0.7) == shares[5003] && scatter(3.0, 0.8) != shares[5003]);
    let bounced = |pattern: f64| {
        let mut brushes = drive::BrushBounce::new(&[0.5, 0.01, pattern]);
        along(3.0, |_| 1.0, |at| brushes.drive(at, 1.0))
    };
    let lost = bounced(1.0).iter().map(|torque| 1.0 - torque).sum::<f64>() / 3e4;
    assert!((0.08..0.2).contains(&lost) && bounced(1.0) == bounced(1.0) && bounced(1.0) != bounced(2.0), "{lost}");
    let mut chips = friction::Debris::new(&[1.0, 0.01, 1.0]);
    let rubs = along(3.0, |_| 1.0, |at| chips.friction(at).level);
    assert!(
        (0.05..0.15).contains(&(rubs.iter().sum::<f64>() / 3e4)) && rubs.iter().all(|rub| (0.0..=1.0).contains(rub))
    );
}

#[test]
fn friction_goes_with_load_power_and_gain_of_speed() {
    let mut film = friction::GearFilm([0.2, 1.0]);
    let levels = [(0.0, 2.0), (1.0, 2.0), (1.0, -4.0)].map(|(w, t)| film.friction(&seen(0.0, 0.0, w, t)).level);
    assert!(levels.iter().zip([0.4, 0.2, 0.4]).all(|(level, wanted)| near(*level, wanted)), "{levels:?}");
    let mut hot = friction::FlashHeat([0.4, 2.0]);
    let shares = [(0.0, 2.0), (1.0, 2.0), (1e9, 2.0)].map(|(w, t)| hot.friction(&seen(0.0, 0.0, w, t)).share);
    assert!(shares.iter().zip([1.2, 1.0, 0.8]).all(|(share, wanted)| near(*share, wanted)), "{shares:?}");
    let mut mass = friction::MassBeside::new(&[0.5, 2.0, 0.01]);
    let levels = along(1.0, |t_s| if t_s < 0.5 { 4.0 * t_s } else { 4.0 - 4.0 * t_s }, |at| mass.friction(at).level);
    assert!(near(levels[4990], 4.0) && near(last(&levels), -4.0), "{} {}", levels[4990], last(&levels));
    let mut brake = friction::InertiaBrake::new(&[1.0, 2.0, 0.01]);
    let speed = |t_s: f64| if t_s < 0.5 { t_s } else { 0.5 + 4.0 * (t_s - 0.5).min(0.5) - 5.0 * (t_s - 1.0).max(0.0) };
    let levels = along(1.2, speed, |at| brake.friction(at).level);
    assert!(levels[4990] == 0.0 && near(levels[9990], 1.0) && last(&levels) < 0.01);
}

#[test]
fn two_states_are_left_at_different_speeds() {
    let mut bearing = friction::LiftsOff::new(&[0.4, 1.0, 1e-3]);
    let mut fluid = fluid::WallSlip::new(&[0.4, 1.0, 1e-3]);
    // Up to 2 and down to nothing.
    let speed = |t_s: f64| if t_s < 1.0 { 2.0 * t_s } else { 4.0 - 2.0 * t_s };
    let shares = along(2.0, speed, |at| bearing.friction(at).share);
    let drags = along(2.0, speed, |at| fluid.drag(at, 1.0));
    for (share, drag) in [(shares[4900], drags[4900]), (last(&shares), last(&drags))] {
        assert!(near(share, 1.2) && near(drag, 1.2), "{share} {drag}");
    }
    assert!([5200, 15_200, 19_000].iter().all(|&row| near(shares[row], 0.8) && near(drags[row], 0.8)));
}

#[test]
fn what_is_taken_one_way_is_left_the_other() {
    let mut wheel = mechanics::Freewheel::new(&[0.5, 1e-3, 1e6, 2.0]);
    let torques = along(2.0, |t_s| 1.0 - (1.0 - t_s).abs(), |at| wheel.torque(at));
    // Half of 2 gains 1 each second, then runs on.
    assert!(near(torques[9990], -1.0) && torques[10_100..].iter().all(|torque| *torque == 0.0));
    let mut chain = mechanics::PicksUp([0.4, 1.0, 2.0]);
    let [up, down] = [3.0, -3.0].map(|speed| chain.torque(&seen(0.0, 0.5, speed, 0.0)));
    // dJ/dx = 0.4: what is picked up takes 0.4 w^2.
    assert!(near(up, -0.5 * 0.4 * 2.0 * 9.0) && down == 0.0);
    let slope = [0.1, 0.6].map(|position| chain.inertia(&seen(0.0, position, 0.0, 0.0)));
    assert!(near(2.0 * (slope[1] - slope[0]) / 0.5, 0.4));
}

#[test]
fn springs_snap_and_gimbals_let_go() {
    let mut strip = mechanics::Snaps::new(&[1.0, 0.5, 1e-4]);
    let torques = along(4.0, |t_s| (PI * t_s).cos(), |at| strip.torque(at) * at.speed * STEP_S);
    // Reversals at 1/pi do not reach the other side.
    assert!(torques.iter().sum::<f64>().abs() < 0.2);
    let mut strip = mechanics::Snaps::new(&[1.0, 0.1, 1e-5]);
    let work: f64 =
        along(8.0, |t_s| (PI * t_s).cos(), |at| strip.torque(at) * at.speed * STEP_S)[20_000..].iter().sum();
    // Each of six ways, there and back: against 1 until 0.1 to the other side, by the strip's slope there.
    assert!(work < -6.0 * 0.1, "{work}");
    let mut pawl = mechanics::Clicks::new(&[1.0, 0.1]);
    let torques = along(1.05, |_| 1.0, |at| pawl.torque(at));
    assert!(
        near(torques.iter().copied().fold(0.0, f64::min), -1.0) && torques.iter().filter(|t| **t > -0.005).count() > 40
    );
    let mut dry = mechanics::DryGimbal::new(&[2.0, 0.5]);
    assert!(along(1.0, |_| 0.4, |at| dry.torque(at)).iter().all(|torque| *torque == 0.0));
    assert!(
        near(last(&along(1.0, |_| 1.5, |at| dry.torque(at))), -2.0)
            && last(&along(5.0, |_| 0.0, |at| dry.torque(at))) == 0.0
    );
    let mut stops = mechanics::GimbalStops::new(&[2.0, 1.0 / TAU, 0.5]);
    let torques = along(2.0, |_| 1.0, |at| stops.torque(at));
    // Half of the square of a second turns it to the stop.
    assert!(near(torques[9900], -1.98) && torques[10_100].abs() < 0.01);
}

#[test]
fn what_moves_beside_adds_no_work_of_its_own_at_rest() {
    let mut elbow = mechanics::Elbow([0.5, 1.0, 0.0, 2.0]);
    assert_eq!(elbow.torque(&seen(0.3, 0.1, 0.0, 1.0)), 0.0);
    // dJ/dt in the middle of the step.
    assert!(near(elbow.torque(&seen(0.0, 0.0, 1.0, 0.0)), -2.0 * 0.5 * TAU));
    let mut ship = mechanics::RollingShip([1.0, 0.25, 0.0, 2.0, 0.5]);
    assert!(ship.torque(&seen(0.0, 0.3, 0.0, 0.0)).abs() < 1e-3);
    assert!(near(ship.torque(&seen(1.0, 0.3, 0.0, 0.0)), 0.6_f64.sin() - 1.1_f64.sin()));
}

#[test]
fn an_order_shows_most_where_it_meets_the_resonance() {
    let swing = |speed: f64| {
        let mut guide = friction::Chatter::new(&[1.0, 10.0, 0.0, 0.1, 0.05]);
        let levels = along(12.0, |_| speed, |at| guide.friction(at).level);
        levels[60_000..].iter().copied().fold(0.0, f64::max)
    };
    assert!(near(swing(0.02), 1.0) && near(swing(1.0), 10.0) && swing(5.0) < 0.1);
    let takes = |speed: f64| {
        let mut crank = mechanics::Shaker::new(&[1.0, 10.0, 0.0, 0.1, 0.05]);
        let torques = along(TAU * 4.0 / speed.min(1.0), |_| speed, |at| crank.torque(at));
        torques[torques.len() / 2..].iter().sum::<f64>() / (torques.len() / 2) as f64
    };
    // Of u = 10 sin(angle) a torque of -10 sin^2.
    assert!(
        near(takes(1.0), -5.0) && takes(0.05).abs() < 0.05 && takes(4.0).abs() < 0.1,
        "{} {}",
        takes(1.0),
        takes(4.0)
    );
}

#[test]
fn a_sensor_under_load_reads_the_torque() {
    let mut column = sensor::ColumnBends::new(&[0.1, 0.01, 0.001]);
    column.feels(2.0);
    let read: Vec<f64> = (0..100).map(|_| column.measured(1.0)).collect();
    assert!(read[0] < 1.02 && near(last(&read), 1.2));
    let mut stray = sensor::StrayField::new(&[0.1, 1.0, 0.0]);
    assert_eq!(stray.measured(0.5), 0.5);
    stray.feels(2.0);
    assert!(near(stray.measured(0.5) - 0.5, 0.2 * 0.5_f64.sin()));
}

#[test]
fn a_sensor_between_its_words_holds_or_guesses() {
    let mut told = sensor::OnChange::new(&[0.1]);
    assert_eq!([0.05, 0.12, 0.2, 0.01].map(|at| told.measured(at)), [0.0, 0.12, 0.12, 0.01]);
    let mut guess = sensor::DeadReckoning::new(&[1.0, 0.005, 0.001]);
    let read: Vec<f64> = (0..20).map(|row| guess.measured(if row < 10 { f64::from(row) } else { 10.0 })).collect();
    // Right on a steady way, beyond it after a stop until the second value since.
    assert!(near(read[7], 7.0) && near(read[12], 12.0) && near(read[17], 10.0) && near(read[3], 0.0), "{read:?}");
}

#[test]
fn a_scale_in_pieces_is_right_at_the_start_and_off_elsewhere() {
    let mut butted = sensor::Butted([0.1, 0.5, 0.01]);
    assert!([0.0, 0.4, 0.6].map(|at| butted.measured(at) - at).iter().zip([0.0, 0.0, 0.1]).all(|(a, b)| near(*a, b)));
    let mut marks = sensor::MarksOff([0.1, 0.2, 0.3]);
    let errors: Vec<f64> = (-500..500).map(|at| marks.measured(f64::from(at) * 0.01) - f64::from(at) * 0.01).collect();
    assert!(errors[500] == 0.0 && errors.iter().all(|error| error.abs() <= 0.2));
    // Straight between marks: no step larger than from one end to the other over a pitch.
    assert!(errors.windows(2).all(|at| (at[1] - at[0]).abs() <= 0.2 * 0.01 / 0.2 + 1e-12));
}

#[test]
fn a_turning_sensor_is_off_by_speed_or_by_direction() {
    let mut voltages = sensor::SpeedVoltages::new(&[0.01, 1.0, 0.5 * PI, 0.001]);
    voltages.measured(0.0);
    voltages.measured(0.002);
    assert!(near(voltages.measured(0.004) - 0.004, 0.02) && near(voltages.measured(0.004), 0.004));
    let mut head = sensor::TiltingHead::new(&[0.1, 0.0, 0.5 * PI, 0.05]);
    let errors = [0.2, 0.3, 0.15, 0.1].map(|at| head.measured(at) - at);
    assert!(errors.iter().zip([0.1, 0.1, -0.1, -0.1]).all(|(a, b)| near(*a, b)), "{errors:?}");
}

#[test]
fn particles_come_and_go() {
    let mut drawn = fluid::Electrophoresis::new(&[0.4, 0.1, 0.1, 2.0]);
    drawn.field(2.0);
    assert!(near(last(&along(2.0, |_| 0.0, |at| drawn.drag(at, 1.0))), 0.8));
    assert!(near(last(&along(2.0, |_| 1.0, |at| drawn.drag(at, 1.0))), 1.0));
    drawn.field(0.0);
    assert!(near(last(&along(2.0, |_| 1.0, |at| drawn.drag(at, 1.0))), 1.2));
    let mut spun = fluid::SpunOut::new(&[0.4, 1.0, 0.1]);
    let drags = along(4.0, |t_s| if t_s < 2.0 { 3.0 } else { 0.0 }, |at| spun.drag(at, 1.0));
    assert!(near(drags[19_000], 1.0 + 0.4 * (0.5 - 0.9)) && near(last(&drags), 1.2), "{}", drags[19_000]);
}

#[test]
fn strain_builds_chains_and_tears_them() {
    let level = |t_s: f64| if t_s < 1.0 { 1.0 } else { 0.0 };
    let mut builds = fluid::StrainBuilds::new(&[0.1, 0.0]);
    let drags = along(1.2, |_| 0.2, |at| builds.drag(at, level(at.t_s)));
    assert!(near(drags[5000], 1.0 - (-1.0_f64).exp()) && drags[10_001] == 0.0, "{}", drags[5000]);
    let mut lasts = fluid::Outlast::new(&[0.1, 0.0]);
    let drags = along(1.5, |_| 0.2, |at| lasts.drag(at, level(at.t_s)));
    assert!(drags[0] == 1.0 && near(last(&drags), (-1.0_f64).exp()), "{}", last(&drags));
}

#[test]
fn rings_need_field_and_shear_and_turning_pumps_the_charge() {
    let mut rings = fluid::Rings::new(&[0.5, 0.1, 0.05, 1e-3]);
    assert!(near(last(&along(1.0, |_| 0.0, |at| rings.drag(at, 1.0))), 1.0));
    assert!(near(last(&along(2.0, |_| 1.0, |at| rings.drag(at, 1.0))), 1.5));
    along(1.0, |_| 1.0, |at| rings.drag(at, 0.0));
    assert!(near(rings.drag(&seen(0.0, 0.0, 0.0, 0.0), 1.0), 1.0));
    let mut charge = fluid::ChargePumped::new(&[0.5, 1.0, 0.0, 0.1]);
    assert_eq!(charge.drag(&seen(0.0, 0.0, 0.0, 0.0), 2.0), 2.0);
    // The charge stays where turning is fast, and is the supply's again where it is slow.
    assert!(near(charge.drag(&seen(0.0, 0.5 * PI, 0.0, 0.0), 1.5), 1.0));
    let rests = (0..10_000).map(|_| charge.drag(&seen(0.0, 0.5 * PI, 0.0, 0.0), 1.5)).fold(0.0, f64::max);
    assert!(near(rests, 1.5), "{rests}");
}
