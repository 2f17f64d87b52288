//! The conclusion, a pure function of the confidence set and the goodness of fit.

/// What the tool concludes about the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing beyond the noise.
    None,
    /// This is it.
    Named,
    /// Something is missing and the data cannot choose.
    Ambiguous,
    /// Some of what is missing is certain, and something predictable is left.
    Partial,
    /// Something is missing and nothing in the vocabulary explains it.
    Unknown,
}

/// What the confidence set says of one entry of the best hypothesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Nothing in the set has another effect in its place.
    Certain,
    /// Another effect with more free values predicts the same.
    CertainBySimplicity,
    /// Another effect with as few free values predicts the same.
    Contested,
    /// The work that is allowed ended before all that may stand in its place was compared with it.
    NotCompared,
}

/// Decides. `entries` are those of the best hypothesis, none for the nominal machine; `left` is whether what remains is
/// predictable and larger than the sensor's step.
pub fn verdict(entries: &[Standing], left: bool) -> Verdict {
    let is_certain = |one: &&Standing| matches!(one, Standing::Certain | Standing::CertainBySimplicity);
    let certain = entries.iter().filter(is_certain).count();
    match (entries.len(), certain, left) {
        (0, _, false) => Verdict::None,
        (0, _, true) => Verdict::Unknown,
        (all, certain, false) if certain == all => Verdict::Named,
        (all, certain, true) if certain == all => Verdict::Partial,
        _ => Verdict::Ambiguous,
    }
}

#[cfg(test)]
mod tests {
    use super::Standing::{Certain, CertainBySimplicity, Contested, NotCompared};
    use super::*;

    #[test]
    fn every_case_of_the_specification() {
        let table: [(&[Standing], bool, Verdict); 13] = [
            (&[], false, Verdict::None),
            (&[], true, Verdict::Unknown),
            (&[Certain], false, Verdict::Named),
            (&[CertainBySimplicity], false, Verdict::Named),
            (&[Contested], false, Verdict::Ambiguous),
            (&[Certain], true, Verdict::Partial),
            (&[Contested], true, Verdict::Ambiguous),
            (&[Certain, Contested], false, Verdict::Ambiguous),
            (&[Certain, Contested], true, Verdict::Ambiguous),
            (&[Certain, CertainBySimplicity], true, Verdict::Partial),
            (&[NotCompared], false, Verdict::Ambiguous),
            (&[NotCompared], true, Verdict::Ambiguous),
            (&[Certain, NotCompared], true, Verdict::Ambiguous),
        ];
        for (entries, left, expected) in table {
            assert_eq!(verdict(entries, left), expected, "{entries:?} {left}");
        }
    }
}
