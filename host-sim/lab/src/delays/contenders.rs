//! The delay models that compete.

use diagnosis::effects::find;
use diagnosis::hypothesis::Hypothesis;
use diagnosis::ranking::Contender;

/// Delays that the fits of one delay begin with, s: those of electrorheological fluids run from below a millisecond to some
/// tens of them (control.md, section 5).
const STARTS_S: [f64; 7] = [1e-3, 2e-3, 4e-3, 8e-3, 15e-3, 30e-3, 60e-3];
/// The same of each of two delays.
const STARTS_OF_TWO_S: [f64; 4] = [1e-3, 3e-3, 8e-3, 20e-3];

/// A hypothesis of effects with one value each; an effect the vocabulary does not have adds nothing.
fn hypothesis(delays: &[(&str, f64)]) -> Hypothesis {
    let known = delays.iter().filter_map(|&(id, delay_s)| Some((find(id)?, delay_s)));
    known.fold(Hypothesis::default(), |all, (effect, delay_s)| all.with(effect, vec![delay_s]))
}

fn one(name: &'static str, id: &str) -> Contender {
    Contender { name, starts: STARTS_S.iter().map(|&delay_s| hypothesis(&[(id, delay_s)])).collect() }
}

/// Where the fits of a late coefficient of viscosity begin.
pub(crate) fn late_viscosities() -> Vec<Hypothesis> {
    ["viscosity_dead_time", "viscosity_lag"].iter().flat_map(|id| one("Q", id).starts).collect()
}

/// What a model is where some of its delays are zero. A delayed viscosity without its delay is no field without one: its drag
/// Q |w| vanishes at rest, where a E^2 + b E holds.
pub(super) fn special_cases(name: &str) -> &'static [&'static str] {
    match name {
        "E dead" | "E lag" => &["none"],
        "E dead and lag" => &["none", "E dead", "E lag"],
        _ => &[],
    }
}

/// All of them.
pub(super) fn all() -> Vec<Contender> {
    let pairs = STARTS_OF_TWO_S.iter().flat_map(|&dead_s| STARTS_OF_TWO_S.map(|lag_s| (dead_s, lag_s)));
    let both = pairs.map(|(dead_s, lag_s)| hypothesis(&[("field_dead_time", dead_s), ("field_lag", lag_s)])).collect();
    vec![
        Contender { name: "none", starts: vec![Hypothesis::default()] },
        one("Q dead", "viscosity_dead_time"),
        one("Q lag", "viscosity_lag"),
        one("E dead", "field_dead_time"),
        one("E lag", "field_lag"),
        Contender { name: "E dead and lag", starts: both },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_has_its_effects() {
        let effects = |contender: &Contender| contender.starts.iter().map(|start| start.entries.len()).max();
        let counts: Vec<_> = all().iter().map(effects).collect();
        assert_eq!(counts, [0, 1, 1, 1, 1, 2].map(Some));
    }
}
