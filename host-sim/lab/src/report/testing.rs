//! A small effect made by hand, for the tests of what shows answers.

use super::{EffectAnswer, Evidence, Interval};

/// An effect of one value in N m, with its interval so far to either side.
pub(crate) fn effect(id: &str, parameter: &str, value: f64, half: f64) -> EffectAnswer {
    let value = Interval {
        id: parameter.to_owned(),
        value,
        low: value - half,
        high: value + half,
        unit: "N m".to_owned(),
        nominal: None,
    };
    EffectAnswer {
        id: id.to_owned(),
        text: String::new(),
        equivalent: Vec::new(),
        nuisances: Vec::new(),
        parameters: vec![value],
        evidence: Evidence { heldout_gain: 0.5, p_value: 1e-12, excess_explained: 0.5 },
        recording: None,
    }
}
