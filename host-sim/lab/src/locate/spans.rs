//! Change points: where a residual turns from quiet to loud and back.

/// A change must pay for itself by this much log likelihood; neighbours overlap, so that evidence counts about twice.
const CHANGE: f64 = 12.0;
/// Louder than this many times the quiet variance, or all is one.
const LOUDER: f64 = 4.0;
/// Rounds of estimating both variances and assigning again.
const ROUNDS: usize = 5;

/// Ranges `from..to` of a series of residuals, in units of their noise, that are louder than the rest; the whole series
/// where all of it is loud alike.
pub(super) fn loud(series: &[f64]) -> Vec<(usize, usize)> {
    if series.is_empty() {
        return Vec::new();
    }
    let squares: Vec<f64> = series.iter().map(|r| r * r).collect();
    let mut sorted = squares.clone();
    sorted.sort_by(f64::total_cmp);
    let (lower, upper) = sorted.split_at(sorted.len() * 3 / 4);
    // Noise has the variance one; less is chance.
    let (mut quiet, mut high) = (mean(lower).max(1.0), mean(upper));
    let mut states = Vec::new();
    for _ in 0..ROUNDS {
        high = high.max(LOUDER * quiet);
        states = most_likely(&squares, quiet, high);
        let of = |state: bool| -> Vec<f64> {
            squares.iter().zip(&states).filter(|(_, s)| **s == state).map(|(square, _)| *square).collect()
        };
        let (still, loud) = (of(false), of(true));
        if loud.is_empty() || still.is_empty() {
            break;
        }
        (quiet, high) = (mean(&still).max(1.0), mean(&loud));
    }
    if !states.contains(&true) {
        // Even noise that is above the floor is one span.
        return if mean(&squares) > LOUDER { vec![(0, series.len())] } else { Vec::new() };
    }
    ranges(&states)
}

fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// The most likely sequence of quiet (false) and loud, by Viterbi's recursion.
fn most_likely(squares: &[f64], quiet: f64, high: f64) -> Vec<bool> {
    let cost = |square: f64, variance: f64| 0.5 * (square / variance + variance.ln());
    let (mut to_quiet, mut to_loud) = (0.0, 0.0);
    // Whether the state before was loud, for quiet now and for loud now.
    let mut from = Vec::with_capacity(squares.len());
    for &square in squares {
        let (stay, fall) = (to_quiet, to_loud + CHANGE);
        let (hold, rise) = (to_loud, to_quiet + CHANGE);
        from.push((fall < stay, rise >= hold));
        to_quiet = stay.min(fall) + cost(square, quiet);
        to_loud = hold.min(rise) + cost(square, high);
    }
    let mut states = vec![false; squares.len()];
    let mut state = to_loud < to_quiet;
    for index in (0..squares.len()).rev() {
        states[index] = state;
        state = if state { from[index].1 } else { from[index].0 };
    }
    states
}

fn ranges(states: &[bool]) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    let mut from = 0;
    for part in states.chunk_by(|a, b| a == b) {
        if part[0] {
            all.push((from, from + part.len()));
        }
        from += part.len();
    }
    all
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::StdRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    fn noise(deviation: impl Fn(usize) -> f64) -> Vec<f64> {
        let draws = StandardNormal.sample_iter(StdRng::seed_from_u64(3));
        draws.take(1000).enumerate().map(|(index, draw): (usize, f64)| deviation(index) * draw).collect()
    }

    #[test]
    fn a_loud_part_is_found_to_a_few_samples_and_noise_has_none() {
        assert_eq!(loud(&noise(|_| 1.0)), []);
        let spans = loud(&noise(|index| if (400..430).contains(&index) { 6.0 } else { 1.0 }));
        assert_eq!(spans.len(), 1, "{spans:?}");
        assert!(spans[0].0.abs_diff(400) <= 3 && spans[0].1.abs_diff(430) <= 3, "{spans:?}");
    }

    #[test]
    fn what_is_loud_all_over_is_one_span_and_louder_parts_stand_out_of_it() {
        assert_eq!(loud(&noise(|_| 5.0)), [(0, 1000)]);
        let spans = loud(&noise(|index| if index % 250 < 25 { 30.0 } else { 3.0 }));
        assert_eq!(spans.len(), 4, "{spans:?}");
        assert_eq!(loud(&[]), []);
    }
}
