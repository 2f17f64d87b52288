//! The four methods against each other on seeded random loops.
//!
//! Agreement means, for the three methods of the continuous loop, the same number of unstable roots in every case, and
//! next to the boundary the same verdict one part in a million on either side of it. The sampled loop is another loop:
//! its delays are whole periods and its torques are held. It must agree with the continuous loop of the same delays
//! plus half a period for each hold, but for held torques within [`BAND`] of the boundary, which is what the hold's own gain,
//! 1 - (w period)^2 / 24, and the next terms leave for delays from 1 ms.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use nalgebra::Complex;
use rand::{Rng, SeedableRng, rngs::StdRng};
use rayon::prelude::*;

use super::case::{Fluid, Loop, NormalisedGains, Plant};
use super::limits::{Quantity, tolerances};
use super::{argument, curves, sampled, spectrum};

const SEED: u64 = 20_050_814;
const CASES: usize = 2000;
/// Change of every held torque within which the sampled and the continuous loop may differ.
const BAND: f64 = 0.01;

fn random_loops() -> Vec<Loop> {
    let mut rng = StdRng::seed_from_u64(SEED);
    (0..CASES).map(|_| random_loop(&mut rng)).collect()
}

fn random_loop(rng: &mut StdRng) -> Loop {
    let torque_delay_s = rng.random_range(1e-3..10e-3);
    let delay_s = rng.random_range(0.0..10e-3);
    let fluid = match rng.random_range(0..3) {
        0 => Fluid::None,
        1 => Fluid::DeadTime { l_q_s: delay_s },
        _ => Fluid::Lag { t_q_s: delay_s },
    };
    let plant = Plant {
        inertia_kg_m2: rng.random_range(0.03..0.15),
        torque_delay_s,
        q0_nm_s_rad: rng.random_range(0.0..1.0),
        q1_nm_s_rad: 60.0 * rng.random::<f64>().powi(2),
        fluid,
    };
    let gains = NormalisedGains { kp: 1.6 * rng.random::<f64>().powi(3), kd: rng.random_range(0.0..1.6) };
    Loop::new(plant, gains.physical(plant.inertia_kg_m2, torque_delay_s)).unwrap()
}

/// Every torque that is held between ticks, scaled: the control's and that of a fluid with a dead time.
fn held_torques_scaled(closed: &Loop, factor: f64) -> Loop {
    let scaled = Quantity::BothGains.set(closed, factor).unwrap();
    match closed.plant().fluid {
        Fluid::DeadTime { .. } => Quantity::Q1.set(&scaled, factor * Quantity::Q1.of(closed)).unwrap(),
        Fluid::None | Fluid::Lag { .. } => scaled,
    }
}

#[test]
fn the_continuous_methods_count_the_same_roots() {
    let loops = random_loops();
    let stable: usize = loops
        .par_iter()
        .map(|closed| {
            let counted = argument::unstable_roots(closed).unwrap();
            let roots = spectrum::rightmost_roots(closed).unwrap();
            assert_eq!(curves::unstable_roots(closed), counted, "curves: {closed:?}");
            assert_eq!(spectrum::unstable_roots(&roots), counted, "spectrum {roots:?}: {closed:?}");
            usize::from(counted == 0)
        })
        .sum();
    println!("seed {SEED}: {CASES} loops, {stable} stable, the same number of unstable roots by all three methods");
    assert!((CASES / 4..CASES * 3 / 4).contains(&stable), "one-sided cases: {stable} stable");
}

#[test]
fn a_loop_is_lost_at_each_limit_and_not_before() {
    const PART: f64 = 1e-6;
    // A quarter of the cases has a thousand stable loops' worth of limits already.
    let limits: usize = random_loops()[..CASES / 4]
        .par_iter()
        .map(|closed| {
            let mut checked = 0;
            for tolerance in tolerances(closed) {
                let ends = [(tolerance.lower, -1.0), (tolerance.upper, 1.0)];
                for (limit, outward) in ends.into_iter().filter_map(|(limit, sign)| limit.map(|limit| (limit, sign))) {
                    for (beyond, inside) in [(-PART, true), (PART, false)] {
                        let moved = tolerance.quantity.set(closed, limit.value * (1.0 + outward * beyond)).unwrap();
                        let context = format!("{tolerance:?} of {closed:?}");
                        assert_eq!(argument::unstable_roots(&moved) == Some(0), inside, "argument: {context}");
                        assert_eq!(curves::is_inside(&moved), inside, "curves: {context}");
                        if tolerance.quantity == Quantity::BothGains {
                            let roots = spectrum::rightmost_roots(&moved).unwrap();
                            let apart = |s: &Complex<f64>| (s - Complex::new(0.0, limit.omega_rad_s)).norm();
                            let lost = roots.iter().min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap();
                            assert_eq!(lost.re < 0.0, inside, "spectrum: {context}");
                            assert!((lost.im.abs() / limit.omega_rad_s - 1.0).abs() < 1e-4, "{context}");
                        }
                    }
                    checked += 1;
                }
            }
            checked
        })
        .sum();
    println!("seed {SEED}: {limits} limits hold to {PART}");
}

#[test]
fn the_sampled_loop_agrees_outside_a_thin_band() {
    let verdict = |closed: &Loop| sampled::spectral_radius(closed, sampled::PERIOD_S).unwrap() < 1.0;
    // The smallest change of the held torques that makes the held continuous loop what the sampled one is.
    let distance = |closed: &Loop, stable: bool| {
        (0..1000).map(|k| f64::from(k) * 1e-3).find(|&change| {
            [1.0 - change, 1.0 + change].iter().any(|&factor| {
                let moved = held_torques_scaled(closed, factor);
                let held = sampled::held_equivalent(&moved, sampled::PERIOD_S).unwrap();
                (argument::unstable_roots(&held) == Some(0)) == stable
            })
        })
    };
    let changes: Vec<f64> =
        random_loops().par_iter().map(|closed| distance(closed, verdict(closed)).unwrap()).collect();
    let differ: Vec<f64> = changes.into_iter().filter(|&change| change > 0.0).collect();
    let largest = differ.iter().fold(0.0, |a: f64, &b| a.max(b));
    println!("seed {SEED}: {} of {CASES} differ, all within {largest} of the boundary", differ.len());
    assert!(largest <= BAND && differ.len() <= CASES / 100);
}
