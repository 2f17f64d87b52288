//! Each law of these kinds by itself: what it does to a motion that is given.

use std::f64::consts::{PI, TAU};

use super::super::Hidden;
use super::super::given_motion::{STEP_S, along, last, near, seen};
use super::{drive, fluid, mechanics, sensor, speed};

#[test]
fn commutation_is_right_at_rest_and_late_in_motion() {
    let mut behind = drive::AngleBehind(0.5);
    let torques = [0.0, 2.0, -2.0].map(|speed| behind.drive(&seen(0.0, 0.0, speed, 0.0), 3.0));
    assert!(torques.iter().zip([1.0, 1.0_f64.cos(), 1.0_f64.cos()]).all(|(torque, share)| near(*torque, 3.0 * share)));
    // A quarter of a period late, either way: where one way has more the other has less.
    let mut hall = drive::HallHysteresis::new(&[0.3, 1.0, 0.0, 0.5 * PI]);
    let torques = [TAU, 2.5 * PI, 1.5 * PI].map(|at| hall.drive(&seen(0.0, at, 0.0, 0.0), 1.0));
    assert!(torques.iter().zip([0.7, 0.7, 1.3]).all(|(torque, wanted)| near(*torque, wanted)), "{torques:?}");
}

#[test]
fn force_goes_with_the_place_on_the_stator() {
    let mut coil = drive::ShortCoil([0.4, 0.5, 1.0]);
    let torques = [0.5, 1.5, -0.5, 1e6].map(|at| coil.drive(&seen(0.0, at, 0.0, 0.0), 1.0));
    assert!(torques.iter().zip([1.2, 1.0, 1.0, 0.8]).all(|(torque, wanted)| near(*torque, wanted)), "{torques:?}");
    let mut stator = drive::StatorSections([0.4, 1.0, 0.7]);
    let mut at = |place: f64| stator.drive(&seen(0.0, place, 0.0, 0.0), 1.0);
    let gains: Vec<f64> = (-20..20).map(|section| at(f64::from(section))).collect();
    assert!(gains.iter().all(|gain| (0.6..=1.4).contains(gain)) && gains.windows(2).all(|two| two[0] != two[1]));
    // The same within a section, halfway in the middle of handing over, and no jump.
    assert_eq!(at(0.2), at(-0.4));
    assert!(near(at(0.4), 0.5 * (at(0.0) + at(1.0))) && near(at(0.5 - 1e-9), at(0.5 + 1e-9)));
}

#[test]
fn a_drive_adds_what_the_inertia_did_not_get_and_what_it_gave_before() {
    let mut observer = drive::Observer::new(&[0.5, 0.05, 2.0]);
    // One that friction holds: after a time half of what is commanded again, and of that.
    let held = along(2.0, |_| 0.0, |at| observer.drive(at, 1.0));
    assert!(held[0] == 1.0 && near(last(&held), 2.0), "{}", last(&held));
    let mut observer = drive::Observer::new(&[0.5, 0.05, 2.0]);
    let free = along(2.0, |t_s| 0.5 * t_s, |at| observer.drive(at, 1.0));
    assert!(free.iter().all(|torque| near(*torque, 1.0)), "{}", last(&free));
    let mut repeats = drive::Repeats::new(&[0.5, 0.1]);
    let torques = along(0.35, |_| 0.0, |at| repeats.drive(at, f64::from(u8::from(at.t_s < 0.05))));
    for (row, wanted) in [(100, 1.0), (900, 0.0), (1100, 0.5), (2100, 0.25), (3400, 0.125), (2900, 0.0)] {
        assert!(near(torques[row], wanted), "{row}: {}", torques[row]);
    }
}

#[test]
fn half_a_derivative_goes_with_the_root_of_the_time() {
    let mut iron = drive::SolidIron::new(&[1.0, 1.0]);
    let torques = along(3.0, |_| 0.0, |at| iron.drive(at, 1.0));
    // Of a plate: 2 root(t / pi) at first, then all but 8 / pi^2 exp(-pi^2 t / 4). What the series leaves out is there at once.
    let rises = torques[1600] - torques[400];
    assert!((rises / (2.0 / PI.sqrt() * 0.2) - 1.0).abs() < 0.02, "{rises}");
    assert!(near(torques[10_000], 1.0 - 8.0 / (PI * PI) * (-PI * PI / 4.0).exp()) && near(last(&torques), 1.0));
    let mut liquid = mechanics::LiquidLayer::new(&[2.0, 0.01]);
    let drags = along(2.0, |_| 1.0, |at| liquid.friction(at).viscous * at.speed - liquid.torque(at));
    // Of a step 2 / root(pi t), as well as layers four times apart tell, but for those thicker than the vessel: slower than half the
    // slowest, 2 integral of x^(-1/2) / pi.
    let thicker = 4.0 / PI * 0.005_f64.sqrt();
    for row in [200, 1000, 5000, 19_000] {
        let wanted = 2.0 / (PI * f64::from(row) * STEP_S).sqrt() - thicker;
        assert!((drags[row as usize] / wanted - 1.0).abs() < 0.02, "{row}: {} {wanted}", drags[row as usize]);
    }
}

/// Twist of a load under a steady gain of speed by 1, once it has settled: torque over share and inertia is that gain.
fn settles(mut load: impl Hidden, gain: f64) -> f64 {
    let torques = along(2.0, |t_s| gain * t_s, |at| load.torque(at));
    -torques[15_000..].iter().sum::<f64>() / 5000.0
}

#[test]
fn a_load_on_a_spring_takes_its_share_and_rings_as_the_spring_is() {
    for gain in [1.0, -1.0] {
        for open in [1.0, 0.25] {
            assert!(near(settles(mechanics::Cracked::new(&[0.5, 10.0, 0.1, 3.0, open]), gain), 1.5 * gain));
        }
        assert!(near(settles(mechanics::WindsUp::new(&[0.5, 10.0, 0.1, 3.0, 1e-3]), gain), 1.5 * gain));
    }
    // Turns of the torque in a second after a jump of the speed, at rest of the axis then.
    let rings = |mut load: Box<dyn Hidden>, from: f64, sign: f64| {
        let mut torques = Vec::new();
        for row in 0..10_000 {
            let (at, speed) = if row < 20 { (1e-4 * f64::from(row), 1.0) } else { (2e-3, 0.0) };
            torques.push(load.torque(&seen(0.0, from + sign * at, sign * speed, 0.0)));
        }
        torques[20..].windows(2).filter(|two| two[0] * two[1] < 0.0).count()
    };
    let screw = |at: f64| {
        let mut load = mechanics::ScrewLength::new(&[0.5, 20.0, 0.001, 1.0, 1.0]);
        // Carried there slowly.
        (0..200_000).for_each(|row| {
            load.torque(&seen(0.0, at * f64::from(row) / 2e5, at / 20.0, 0.0));
        });
        rings(Box::new(load), at, 1.0)
    };
    // As the root of the length: 1 / 0.5 and 1 / 1.5 of the middle's.
    let turns = [-0.5, 0.0, 0.5].map(screw);
    assert!(turns.iter().zip([56, 40, 33]).all(|(turns, wanted)| turns.abs_diff(wanted) <= 1), "{turns:?}");
    let soft = rings(Box::new(mechanics::WindsUp::new(&[0.5, 20.0, 0.001, 1.0, 1.0])), 0.0, 1.0);
    let wound = rings(Box::new(mechanics::WindsUp::new(&[0.5, 20.0, 0.001, 1.0, 1e-5])), 0.0, 1.0);
    assert!(soft.abs_diff(18) <= 1 && wound.abs_diff(40) <= 2, "{soft} {wound}");
    let cracked = rings(Box::new(mechanics::Cracked::new(&[0.5, 20.0, 0.001, 1.0, 0.25])), 0.0, 1.0);
    // Half a period of the one and half of the other: 1 / 40 + 1 / 20 s.
    assert!(cracked.abs_diff(27) <= 1, "{cracked}");
}

#[test]
fn springs_lose_the_work_between_two_stresses() {
    let mut wire = mechanics::Superelastic::new(&[2.0, 1.0, 0.3, 1.0 / 3.0]);
    let mut at = |position: f64| wire.torque(&seen(0.0, position, 0.0, 0.0));
    let torques = [0.2, 0.3, 0.8, 0.7, 0.6, 0.2, 0.05, -0.8, -0.2, 0.0, 2.0].map(&mut at);
    let wanted = [-0.4, -0.6, -0.6, -0.4, -0.2, -0.2, -0.1, 0.6, 0.2, 0.0, -2.0];
    assert!(torques.iter().zip(wanted).all(|(torque, wanted)| near(*torque, wanted)), "{torques:?}");
    let mut leaves = mechanics::Leaves([2.0, 0.5]);
    for position in [0.4, -0.4] {
        let at = seen(0.0, position, 0.0, 0.0);
        assert!(near(leaves.torque(&at), -2.0 * position) && near(leaves.friction(&at).level, 0.4));
    }
}

#[test]
fn momentum_stays_where_weights_move_and_goes_where_mass_comes() {
    // Free of all else: the rate of J w is what falls in at rest, none, and what the weights take along.
    let coasts = |mut load: Box<dyn Hidden>, push: &dyn Fn(f64) -> f64| {
        let (mut speed, mut momenta) = (2.0, Vec::new());
        for row in 0..20_000 {
            let t_s = f64::from(row) * STEP_S;
            let at = seen(t_s, 0.0, speed, 0.0);
            let torque = load.torque(&at) + push(t_s);
            speed += STEP_S * torque / (3.0 * load.inertia(&at));
            momenta.push(3.0 * load.inertia(&at) * speed);
        }
        (speed, momenta)
    };
    let (speed, momenta) = coasts(Box::new(mechanics::HopperFills([0.5, 0.5, 1.0, 3.0])), &|_| 0.0);
    assert!(near(speed, 2.0 / 1.5) && momenta.iter().all(|momentum| near(*momentum, 6.0)), "{speed}");
    let weights = Box::new(mechanics::WeightsStick::new(&[0.5, 1.0, 0.01, 3.0]));
    let (speed, momenta) = coasts(weights, &|t_s| if t_s < 1.0 { 0.0 } else { -4.0 });
    // They go out at once, and are still out after the push: 2 N m s of 4.5 kg m2.
    assert!(near(momenta[9990], 6.0) && near(speed, 2.0 / 4.5), "{speed}");
    let mut weights = mechanics::WeightsStick::new(&[0.5, 1.0, 0.01, 3.0]);
    let out = along(4.0, |t_s| 2.0 - (2.0 - t_s).abs(), |at| weights.torque(at) * 0.0 + weights.inertia(at));
    assert!([5000, 35_000, 39_500].iter().zip([1.0, 1.5, 1.0]).all(|(row, wanted)| near(out[*row], wanted)));
}

#[test]
fn the_wind_pushes_what_is_slow_and_sheds_from_side_to_side() {
    let mut prism = speed::Gallops([0.5, 2.0]);
    let viscous = [0.0, 2.0, 4.0].map(|speed| prism.friction(&seen(0.0, 0.0, speed, 0.0)).viscous);
    assert!(viscous.iter().zip([-0.5, 0.0, 1.5]).all(|(viscous, wanted)| near(*viscous, wanted)), "{viscous:?}");
    let mut street = speed::Vortices::new(&[0.5, 10.0, 0.0]);
    let torques = along(8.0, |t_s| if t_s < 4.0 { 2.0 } else { -1.0 }, |at| street.torque(at));
    let most = |from: usize, to: usize| torques[from..to].iter().copied().fold(0.0, f64::max);
    let turns = |from: usize, to: usize| torques[from..to].windows(2).filter(|two| two[0] * two[1] < 0.0).count();
    // Twice a period of 2 pi / 10; formed anew after the turn.
    assert!(near(most(30_000, 40_000), 2.0) && near(most(70_000, 80_000), 0.5) && most(40_000, 41_500) < 0.25);
    assert!(turns(20_000, 40_000).abs_diff(13) <= 1 && turns(60_000, 80_000).abs_diff(6) <= 1);
}

#[test]
fn loads_begin_beyond_a_speed() {
    let mut shoes = speed::Shoes([0.5, 2.0]);
    let levels = [0.0, 2.0, -4.0].map(|speed| shoes.friction(&seen(0.0, 0.0, speed, 0.0)).level);
    assert!(levels[0] == 0.0 && levels[1] == 0.0 && near(levels[2], 1.5), "{levels:?}");
    let mut rectifier = speed::Rectifier::new(&[3.0, 0.1, 1.0]);
    let mut brakes = |t_s: f64, speed: f64| last(&along(t_s, |_| speed, |at| rectifier.friction(at).viscous));
    // Charged to 10 of 11 parts; slower it turns freely until the capacitor has lost so much.
    assert!(near(brakes(STEP_S * 1.5, 2.0), 3.0) && near(brakes(4.0, 2.0), 3.0 / 11.0));
    assert!(brakes(0.4, 1.0) == 0.0 && near(brakes(4.0, -1.0), 3.0 / 11.0));
    assert!(brakes(STEP_S * 1.5, 0.0) == 0.0);
}

#[test]
fn stamps_wander_with_the_place_and_by_chance() {
    let mut lines = sensor::ScanLine::new(&[2.0, 1.0]);
    lines.measured(0.49);
    assert!(near(lines.measured(0.5), 0.49) && lines.measured(0.5) == 0.5);
    lines.measured(-0.49);
    assert!(near(lines.measured(-0.5), -0.51));
    let read = |pattern: f64| -> Vec<f64> {
        let mut routes = sensor::TwoRoutes::new(&[3.0, 20.0, pattern]);
        (1..4001).map(|row| f64::from(row) - routes.measured(f64::from(row))).collect()
    };
    let late = read(1.0);
    assert!(late.iter().all(|rows| *rows == 0.0 || *rows == 3.0) && late == read(1.0) && late != read(2.0));
    let changes = late.windows(2).filter(|two| two[0] != two[1]).count();
    // Half of the time late, and half of the 200 whiles are not as the one before.
    let mean = late.iter().sum::<f64>() / 4e3;
    assert!((1.0..2.0).contains(&mean) && (70..130).contains(&changes), "{mean} {changes}");
}

#[test]
fn a_warm_sensor_is_off_and_cools_again() {
    let mut scale = sensor::ScaleGrows::new(&[0.1, 0.4, 0.2, 1e-3]);
    let mut bracket = sensor::BracketWarps::new(&[0.1, 0.4, 0.2, 1e-3]);
    let mut read = |torque: f64| {
        scale.feels(torque);
        bracket.feels(torque);
        let both = |_| (scale.measured(2.0), bracket.measured(2.0));
        (0..3000).map(both).last().unwrap_or_default()
    };
    assert_eq!(read(0.0), (2.0, 2.0));
    // Four over 0.4 for 0.2 s: a heat of 2.
    let warm = 1.0 - (-2.0_f64).exp();
    let (grown, warped) = read(-2.0);
    assert!(near(2.0 - grown, 0.2 * warm) && near(warped - 2.0, 0.1 * warm), "{grown} {warped}");
    assert!(near(read(0.0).0, 2.0));
}

#[test]
fn each_use_has_the_other_pole_and_each_reversal_a_dip() {
    let mut poles = fluid::PolesDiffer::new(&[0.4, 2.0]);
    let mut drags = |field: f64| {
        poles.field(field);
        poles.drag(&seen(0.0, 0.0, 0.0, 0.0), 1.0)
    };
    let found = [2.0, 0.6, 2.0, 0.0, 0.6, 1.0, 0.0, 2.0].map(&mut drags);
    let wanted = [1.2, 1.2, 1.2, 1.2, 1.2, 0.8, 0.8, 1.2];
    assert!(found.iter().zip(wanted).all(|(drag, wanted)| near(*drag, wanted)), "{found:?}");
    let mut flips = fluid::PolarityFlips([0.5, 0.2, PI, 0.01]);
    let drags = along(1.0, |_| 0.0, |at| flips.drag(at, 2.0));
    // First after half of the time between.
    let dips: Vec<usize> = (1..drags.len()).filter(|row| drags[*row] < drags[row - 1] - 0.5).collect();
    assert!(dips.len() == 5 && dips[0].abs_diff(1000) <= 1 && dips[1].abs_diff(3000) <= 1, "{dips:?}");
    assert!(near(drags[dips[0]], 1.0) && near(drags[2900], 2.0));
}
