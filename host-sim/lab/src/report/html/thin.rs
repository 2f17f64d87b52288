//! Rows that a page keeps of a long recording.

use std::ops::Range;

/// Rows to keep of `rows`, rising, at most about `most`: the first and the last of each stretch, and where each column is
/// lowest and highest in it, so that no peak is lost at any zoom. All rows where there are no more than `most`.
///
/// Values of a column that are not finite are not looked at.
pub(super) fn kept(rows: usize, columns: &[&[f64]], most: usize) -> Vec<usize> {
    if rows <= most {
        return (0..rows).collect();
    }
    let a_stretch = 2 * columns.len() + 2;
    let stretches = (most / a_stretch).max(1);
    let mut kept = Vec::with_capacity(most);
    for stretch in 0..stretches {
        let range = stretch * rows / stretches..(stretch + 1) * rows / stretches;
        let mut here = vec![range.start, range.end - 1];
        here.extend(columns.iter().flat_map(|column| extremes(column, range.clone())));
        here.sort_unstable();
        here.dedup();
        kept.extend(here);
    }
    kept
}

fn extremes(column: &[f64], range: Range<usize>) -> impl Iterator<Item = usize> {
    let by_value = |a: &usize, b: &usize| column[*a].total_cmp(&column[*b]);
    let finite = || range.clone().filter(|row| column[*row].is_finite());
    [finite().min_by(by_value), finite().max_by(by_value)].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_recording_keeps_every_row() {
        assert_eq!(kept(5, &[&[0.0; 5]], 10), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn a_single_peak_in_a_long_recording_stays() {
        let mut column = vec![0.0; 1_200_000];
        column[654_321] = 1.0;
        column[7] = -1.0;
        column[8] = f64::NAN;
        let rows = kept(column.len(), &[&column], 16_000);
        assert!(rows.len() <= 16_000 && rows.is_sorted());
        assert!(rows.contains(&654_321) && rows.contains(&7));
        assert_eq!((rows.first(), rows.last()), (Some(&0), Some(&1_199_999)));
    }
}
