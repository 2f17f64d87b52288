//! The plan of the paper's own experiment: single steps of the servo, and a delay of its fluid to be told.

use super::{Arm, Blueprint, Sizes};

/// What may be late, as the paper's models have it: nothing, the field by a dead time, a lag or both, the coefficient of viscosity by a
/// dead time or a lag.
const DELAYS: [&[&str]; 6] = [
    &[],
    &["field_dead_time"],
    &["field_lag"],
    &["field_dead_time", "field_lag"],
    &["viscosity_dead_time"],
    &["viscosity_lag"],
];
/// Delays in all over the paper's 5 ms, three strata a factor of two wide each: electrorheological fluids answer in one to ten
/// milliseconds.
const STRATA: [Sizes; 3] =
    [Sizes { high: 2.0, low: 1.0 }, Sizes { high: 1.0, low: 0.5 }, Sizes { high: 0.5, low: 0.25 }];

/// One round; seed s is case s modulo its length.
pub fn plan() -> Vec<Blueprint> {
    let case = |sizes, effects| Blueprint { sizes, ..Blueprint::new(Arm::Steps, effects, 1.0) };
    STRATA.iter().flat_map(|&sizes| DELAYS.iter().map(move |effects| case(sizes, effects))).collect()
}
