//! Whether a kind outside the vocabulary is a law that has a name by now: the same values give the same motion.
#![allow(clippy::unwrap_used)]

use super::{NAMED_SINCE, Put, kinds};
use crate::catalogue::ENTRIES;
use crate::physics::Physics;
use crate::rotor::{Command, Rotor};

/// Positions under a torque and a field that both come and go.
fn moved(physics: &Physics) -> Vec<f64> {
    let mut rotor = Rotor::new(physics, 2e-5);
    let step = |row: u32| {
        let t = f64::from(row);
        let torque_nm = 6.0 * (0.011 * t).sin() + 3.0 * (0.029 * t).cos();
        let field_kv_mm = if row / 150 % 2 == 1 { 1.5 } else { 0.2 };
        (0..25).for_each(|_| rotor.step(&Command { torque_nm, field_kv_mm, ..Command::default() }));
        rotor.position_rad()
    };
    (0..1500).map(step).collect()
}

fn largest(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Pairs of a kind and an effect of the vocabulary that move the axis alike with these values.
fn alike(values: [f64; 5]) -> Vec<(&'static str, &'static str)> {
    let nominal = moved(&Physics::nominal());
    let with = |put: &dyn Fn(&mut Physics)| {
        let mut physics = Physics::nominal();
        put(&mut physics);
        moved(&physics)
    };
    let inside: Vec<(&str, Vec<f64>)> = ENTRIES
        .iter()
        .filter(|entry| entry.in_vocabulary)
        .map(|entry| (entry.id, with(&|physics| entry.put(physics, &values))))
        .collect();
    let mut pairs = Vec::new();
    for kind in kinds() {
        let outside = with(&|physics| match kind.put {
            Put::Number(put) => put(physics, &values),
            Put::Beside(_) => kind.conceal(physics, &values),
        });
        // An axis that stands still is the same under any law.
        let way = outside.iter().fold(0.0_f64, |most, at| most.max(at.abs()));
        let moves = largest(&outside, &nominal);
        if way > 0.01 && moves > 1e-6 {
            let same = inside.iter().filter(|(_, inside)| largest(&outside, inside) < 1e-3 * moves);
            pairs.extend(same.map(|(effect, _)| (kind.id, *effect)));
        }
    }
    pairs
}

#[test]
fn every_kind_that_is_a_law_of_the_vocabulary_is_listed() {
    // Neither 0 nor 1, and different from each other, so that no two laws agree by chance; weak and strong.
    let mut found: Vec<_> = [0.23, 0.85].into_iter().flat_map(|first| alike([first, 3.0, 0.4, 0.7, 0.5])).collect();
    found.sort_unstable();
    found.dedup();
    println!("{found:?}");
    assert_eq!(found[..], [("friction_by_load", "load_dependent_friction"), ("torque_ripple", "torque_ripple")]);
    assert!(found.iter().all(|pair| NAMED_SINCE.contains(pair)), "{found:?}");
}
