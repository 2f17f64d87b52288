//! Stamps that repeat: rounded to longer steps than the rows are apart, one for each packet of rows, or of rows that are written twice.

/// A row that takes less than this part of the usual row's time is none that was rounded: the clock stood still. Stamps that are
/// rounded to just over a row's time leave half of one.
const LEAST_OF_USUAL: f64 = 1.0 / 3.0;
/// A row that takes more than this many usual ones is the last before a gap.
const MOST_OF_USUAL: f64 = 3.0;

/// What becomes of stamps of which some repeat.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Repeats {
    /// None does.
    None,
    /// These rows are the one before again and are left out.
    WrittenTwice(Vec<usize>),
    /// The stamps of the first rows, spread evenly to the next that differs, and how many of them repeated; rows behind them are the
    /// last one again.
    Spread(Vec<f64>, usize),
}

/// What becomes of stamps that never run back, in any unit; `is_again` tells whether a row is the one before it in every column.
///
/// Spreading shifts all columns of a row alike, which no model notices, and by less than one stamp is from the next.
///
/// # Errors
///
/// The first row, counted from 0, whose stamp repeats for more rows than fit in before the next.
pub(crate) fn repeats(stamps: &[f64], is_again: impl Fn(usize) -> bool) -> Result<Repeats, usize> {
    let same = |row: usize| stamps[row] == stamps[row - 1];
    // A log that is filled up behind its end.
    let end = (1..stamps.len()).rev().find(|row| !(same(*row) && is_again(*row))).map_or(1, |row| row + 1);
    let repeated: Vec<usize> = (1..end.min(stamps.len())).filter(|row| same(*row)).collect();
    if repeated.iter().all(|row| is_again(*row)) {
        let again: Vec<usize> = repeated.into_iter().chain(end..stamps.len()).collect();
        return Ok(if again.is_empty() { Repeats::None } else { Repeats::WrittenTwice(again) });
    }
    spread(&stamps[..end]).map(|stamps| Repeats::Spread(stamps, repeated.len()))
}

fn spread(stamps: &[f64]) -> Result<Vec<f64>, usize> {
    // Where each stamp comes first, and the end.
    let mut starts: Vec<usize> =
        (0..stamps.len()).filter(|row| *row == 0 || stamps[*row] != stamps[*row - 1]).collect();
    starts.push(stamps.len());
    let groups = || starts.windows(2).map(|pair| (pair[0], pair[1]));
    let own = |(from, to): (usize, usize)| stamps.get(to).map(|next| (next - stamps[from]) / (to - from) as f64);
    let mut all: Vec<f64> = groups().filter_map(own).collect();
    all.sort_by(f64::total_cmp);
    let Some(&usual) = all.get(all.len() / 2).filter(|usual| usual.is_finite()) else { return Err(1) };
    let mut risen = Vec::with_capacity(stamps.len());
    for group in groups() {
        let step = own(group).filter(|step| *step <= MOST_OF_USUAL * usual).unwrap_or(usual);
        if step < LEAST_OF_USUAL * usual && group.1 > group.0 + 1 {
            return Err(group.0 + 1);
        }
        risen.extend((0..group.1 - group.0).map(|row| stamps[group.0] + row as f64 * step));
    }
    // Times so large that a part of their step is lost in rounding.
    match risen.windows(2).position(|pair| pair[0] >= pair[1]) {
        Some(row) => Err(row + 1),
        None => Ok(risen),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn near(found: &Result<Repeats, usize>, expected: &[f64], count: usize) {
        let spread = if let Ok(Repeats::Spread(stamps, repeated)) = found { Some((stamps, *repeated)) } else { None };
        let (stamps, repeated) = spread.unwrap();
        assert_eq!((stamps.len(), repeated), (expected.len(), count));
        assert!(stamps.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9), "{stamps:?}");
    }

    #[test]
    fn stamps_that_are_rounded_or_of_packets_are_spread() {
        let quarters: Vec<f64> = (0..40).map(|row| 0.25 * f64::from(row)).collect();
        let whole: Vec<f64> = quarters.iter().map(|stamp| stamp.floor()).collect();
        near(&repeats(&whole, |_| false), &quarters, 30);
        // One of a thousand rounded the wrong way.
        let mut stamps: Vec<f64> = (0..40).map(f64::from).collect();
        stamps[21] = 20.0;
        near(&repeats(&stamps, |_| false), &(0..40).map(f64::from).collect::<Vec<_>>(), 1);
        // Packets of five rows, a pause after the second, and rows behind the end that are the last one again.
        let mut packets: Vec<f64> =
            (0..20).map(|row| f64::from(row / 5 * 5 + if row < 10 { 0 } else { 100 })).collect();
        packets.extend([115.0; 7]);
        let even: Vec<f64> = (0..20).map(|row| f64::from(row + if row < 10 { 0 } else { 100 })).collect();
        near(&repeats(&packets, |row| row >= 20), &even, 16);
    }

    #[test]
    fn rows_that_are_written_twice_are_left_out_and_others_are_as_they_are() {
        assert_eq!(repeats(&[0.0, 1.0, 2.0], |_| false), Ok(Repeats::None));
        assert_eq!(repeats(&[], |_| false), Ok(Repeats::None));
        assert_eq!(repeats(&[3.0], |_| false), Ok(Repeats::None));
        assert_eq!(repeats(&[0.0, 1.0, 1.0, 2.0, 2.0], |_| true), Ok(Repeats::WrittenTwice(vec![2, 4])));
    }

    #[test]
    fn a_clock_that_stands_still_is_refused() {
        let mut stamps: Vec<f64> = (0..100).map(f64::from).collect();
        stamps.splice(50..50, [49.0; 30]);
        assert_eq!(repeats(&stamps, |_| false), Err(50));
        assert_eq!(repeats(&[1.0; 9], |row| row < 5), Err(1));
        assert_eq!(repeats(&[1e17, 1e17, 1e17 + 16.0], |_| false), Err(1));
    }
}
