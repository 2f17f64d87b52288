//! Every kind of the newer lists at work on the nominal machine. A kind is told by its place in them.

use rand::SeedableRng;
use rand::rngs::StdRng;

use super::{Kind, Scales, Shape, afield, aloft, beyond, further, kinds, unseen};
use crate::catalogue::{ENTRIES, for_recording};
use crate::physics::Physics;
use crate::rotor::{Command, Rotor, STEP_S};
use crate::sensor::Measured;

const ROWS: usize = 3000;
const SHAPES: [Shape; 2] = [[0.3, 0.6, 0.2, 0.8], [0.9, 0.1, 0.7, 0.4]];
/// Of the motion under [`command`], about.
const SCALES: Scales = Scales {
    torque: 5.0,
    speed: 2.5,
    travel: 0.4,
    duration_s: 1.5,
    period_s: 0.0005,
    inertia: 0.075,
    coulomb: 0.763,
    field_kv_mm: 1.5,
};

/// A torque and a field that both come and go, with rests between.
fn command(row: usize, times: f64) -> Command {
    let t = row as f64;
    let swing = 6.0 * (0.011 * t).cos() + 4.0 * (0.027 * t).cos();
    let torque_nm = if row % 1000 > 900 { 0.0 } else { times * swing };
    let field_kv_mm = if row / 150 % 2 == 1 { 1.5 } else { 0.2 };
    Command { torque_nm, field_kv_mm, ..Command::default() }
}

/// Positions and readings, row by row.
fn moved(physics: &Physics, steps: usize, times: f64) -> Vec<f64> {
    let step_s = SCALES.period_s / steps as f64;
    let mut rotor = Rotor::new(physics, step_s);
    let mut sensor = Measured::new(physics, step_s);
    let mut random = StdRng::seed_from_u64(0);
    let row = |row: usize| {
        (0..steps).for_each(|_| rotor.step(&command(row, times)));
        let position = rotor.position_rad();
        sensor.feel(rotor.drive_nm());
        [position, sensor.sample(position, &mut random)]
    };
    (0..ROWS).flat_map(row).collect()
}

/// Kinds of the lists that are held against each other.
fn newer() -> impl Iterator<Item = &'static Kind> {
    unseen::KINDS.iter().chain(further::KINDS).chain(beyond::KINDS).chain(afield::KINDS).chain(aloft::KINDS)
}

fn with(kind: &'static Kind, size: f64, shape: &Shape) -> Physics {
    let mut physics = Physics::nominal();
    kind.conceal(&mut physics, &(kind.values)(&SCALES, size, shape));
    physics
}

fn largest(one: &[f64], other: &[f64]) -> f64 {
    assert!(one.iter().chain(other).all(|value| value.is_finite()));
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn no_size_is_no_effect_and_what_is_larger_shows_more() {
    let nominal = moved(&Physics::nominal(), 20, 1.0);
    let way = largest(&nominal, &vec![0.0; 2 * ROWS]);
    for (index, kind) in newer().enumerate() {
        for shape in &SHAPES {
            let changes = |size: f64| largest(&moved(&with(kind, size, shape), 20, 1.0), &nominal);
            let [none, least, small, more, whole] = [0.0, 1e-9, 0.003, 0.03, 1.0].map(changes);
            println!("{index}: {none:.1e} {least:.1e} {small:.1e} {more:.1e} {whole:.1e} of {way:.1e} rad");
            assert!(none < 1e-9 * way && least < 1e-6 * way, "{index}");
            assert!(small <= more && more < whole && small < 0.1 * way && whole > 5e-3 * way, "{index}");
        }
    }
}

#[test]
fn what_differs_between_recordings_is_what_the_list_says() {
    for kind in newer() {
        let physics = with(kind, 0.5, &SHAPES[0]);
        let values = |seed: u64| {
            let of = for_recording(&physics, 0, &mut StdRng::seed_from_u64(seed));
            of.hidden.map_or(Vec::new(), |hiding| hiding.values)
        };
        let differ = values(1).iter().zip(values(2)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, usize::from(kind.free_phase.is_some()));
    }
}

#[test]
fn extreme_torques_sizes_and_steps_leave_every_number_finite() {
    for kind in newer() {
        for shape in &SHAPES {
            for (size, times, steps) in [(1.0, 1e4, 10), (4.0, 100.0, 10), (1.0, 1.0, 1)] {
                let rows = moved(&with(kind, size, shape), steps, times);
                assert!(rows.iter().all(|value| value.is_finite()));
            }
        }
    }
}

#[test]
fn every_kind_converges_as_the_step_becomes_finer() {
    for (index, kind) in newer().enumerate() {
        let runs = |physics: &Physics| [1, 4].map(|finer| moved(physics, finer * (5e-4 / STEP_S) as usize / 4, 1.0));
        let [coarse, fine] = runs(&with(kind, 0.2, &SHAPES[0]));
        let error = largest(&coarse, &fine);
        let way = largest(&fine, &vec![0.0; 2 * ROWS]);
        println!("{index}: {error:.1e} of {way:.1e} rad");
        assert!(error < 2e-3 * way, "{index}");
    }
}

/// Cosine between what two kinds add to the nominal motion.
fn alike(one: &[f64], other: &[f64]) -> f64 {
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    product(one, other) / (product(one, one) * product(other, other)).sqrt().max(f64::MIN_POSITIVE)
}

#[test]
fn no_kind_is_another_again() {
    // Readings' second differences: of the position itself the slowest part alone would be compared.
    let bends = |physics: &Physics| -> Vec<f64> {
        let rows: Vec<f64> = moved(physics, 20, 1.0).into_iter().skip(1).step_by(2).collect();
        rows.windows(3).map(|at| at[0] - 2.0 * at[1] + at[2]).collect()
    };
    let nominal = bends(&Physics::nominal());
    let adds = |physics: &Physics| -> Vec<f64> {
        bends(physics).iter().zip(&nominal).map(|(with, without)| with - without).collect()
    };
    let of_kinds = kinds().flat_map(|kind| SHAPES.iter().map(move |shape| (kind.id, with(kind, 0.05, shape))));
    let inside = ENTRIES.iter().filter(|entry| entry.in_vocabulary).map(|entry| {
        let mut physics = Physics::nominal();
        entry.conceal(0.1, &mut physics, &mut StdRng::seed_from_u64(1));
        (entry.id, physics)
    });
    let all: Vec<(&str, Vec<f64>)> = of_kinds.chain(inside).map(|(id, physics)| (id, adds(&physics))).collect();
    for (index, kind) in newer().enumerate() {
        for (_, own) in all.iter().filter(|(id, _)| *id == kind.id) {
            let others = all.iter().filter(|(id, _)| *id != kind.id);
            let most = others.map(|(_, other)| alike(own, other).abs()).fold(0.0, f64::max);
            println!("{index}: {most:.3}");
            assert!(most < 0.95, "{index}");
        }
    }
}
