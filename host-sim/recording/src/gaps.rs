//! Where rows are missing.
//!
//! A row is missing after row `i` where `seq` steps by more than one, or where the step of `t_s` is over
//!
//! ```text
//! m + max(m / 2, 5 s)
//! ```
//!
//! with `m` the median of the 31 steps around it and `s` their spread (1.4826 times the median absolute deviation, the
//! standard deviation where they are normally distributed). A lost row doubles a step, so half a step more divides lost
//! from late where sampling is regular; where it is not, the limit moves out with the jitter that the neighbours show.
//! Medians of neighbours follow a rate that changes within the recording, and do not follow the gaps themselves.

/// Steps on either side that tell what is usual.
const NEIGHBOURS: usize = 15;
/// Excess over the usual step, as a part of it, that means a lost row.
const LOST: f64 = 0.5;
/// Excess over the usual step, as a multiple of the spread, that jitter does not reach.
const JITTER: f64 = 5.0;
/// Standard deviation of a normal distribution over its median absolute deviation.
pub(crate) const SIGMA_PER_MAD: f64 = 1.4826;

/// Indices `i` where rows are missing between rows `i` and `i + 1`.
pub(crate) fn find(t_s: &[f64], seq: Option<&[u64]>) -> Vec<usize> {
    let mut window = Vec::with_capacity(2 * NEIGHBOURS + 1);
    (0..t_s.len().saturating_sub(1))
        .filter(|&i| seq.is_some_and(|seq| seq[i + 1] - seq[i] > 1) || is_long_step(t_s, i, &mut window))
        .collect()
}

fn is_long_step(t_s: &[f64], i: usize, window: &mut Vec<f64>) -> bool {
    let step = |k: usize| t_s[k + 1] - t_s[k];
    let this = step(i);
    let neighbours = i.saturating_sub(NEIGHBOURS)..=(i + NEIGHBOURS).min(t_s.len() - 2);
    // The usual step is short enough only if half of the neighbours are: a count spares nearly every row the median.
    let (mut short, mut all) = (0, 0);
    for k in neighbours.clone() {
        short += usize::from(this > (1.0 + LOST) * step(k));
        all += 1;
    }
    if 2 * short < all {
        return false;
    }
    window.clear();
    window.extend(neighbours.map(step));
    let usual = median(window);
    for value in window.iter_mut() {
        *value = (*value - usual).abs();
    }
    let spread = SIGMA_PER_MAD * median(window);
    this > usual + (LOST * usual).max(JITTER * spread)
}

/// The lower median; `values` must not be empty.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regular(rows: usize) -> Vec<f64> {
        (0..rows).map(|k| k as f64 * 5e-4).collect()
    }

    #[test]
    fn regular_time_has_no_gap_and_a_removed_row_is_one() {
        let mut t_s = regular(1000);
        assert_eq!(find(&t_s, None), Vec::<usize>::new());
        t_s.remove(500);
        t_s.remove(10);
        assert_eq!(find(&t_s, None), [9, 498]);
    }

    #[test]
    fn a_sequence_number_tells_where_time_does_not() {
        let t_s = regular(6);
        assert_eq!(find(&t_s, Some(&[0, 1, 2, 4, 5, 9])), [2, 4]);
    }

    #[test]
    fn a_change_of_rate_is_not_a_gap() {
        let mut t_s = regular(200);
        t_s.extend((1..200).map(|k| 0.1 + f64::from(k) * 5e-3));
        assert_eq!(find(&t_s, None), Vec::<usize>::new(), "ten times slower from row 200");
    }

    #[test]
    fn jitter_of_thirty_percent_is_not_a_gap() {
        // Low-discrepancy offsets, uniform over +-15 % of the step: steps vary by up to 30 %.
        let t_s: Vec<f64> =
            (0..5000).map(|k| f64::from(k) + 0.3 * ((f64::from(k) * 0.618_033_988_75).fract() - 0.5)).collect();
        assert_eq!(find(&t_s, None), Vec::<usize>::new());
    }

    #[test]
    fn short_recordings_have_no_gap_for_want_of_neighbours() {
        assert_eq!(find(&[], None), Vec::<usize>::new());
        assert_eq!(find(&[1.0], None), Vec::<usize>::new());
        assert_eq!(find(&[1.0, 5.0], None), Vec::<usize>::new());
    }
}
