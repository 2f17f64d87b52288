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

#[test]
fn every_kind_that_is_a_law_of_the_vocabulary_is_listed() {
    let nominal = moved(&Physics::nominal());
    // Neither 0 nor 1, and different from each other, so that no two laws agree by chance.
    let values = [0.23, 3.0, 0.4, 0.7];
    let mut found = Vec::new();
    for kind in kinds() {
        let mut physics = Physics::nominal();
        match kind.put {
            Put::Number(put) => put(&mut physics, &values),
            Put::Beside(_) => kind.conceal(&mut physics, &values),
        }
        let outside = moved(&physics);
        for entry in ENTRIES.iter().filter(|entry| entry.in_vocabulary) {
            let mut physics = Physics::nominal();
            entry.put(&mut physics, &values);
            let inside = moved(&physics);
            let moves = largest(&outside, &nominal);
            if moves > 1e-6 && largest(&outside, &inside) < 1e-3 * moves {
                found.push((kind.id, entry.id));
            }
        }
    }
    println!("{found:?}");
    assert!(found.contains(&("torque_ripple", "torque_ripple")), "{found:?}");
    for pair in found {
        assert!(NAMED_SINCE.contains(&pair), "{pair:?}");
    }
}
