//! Rows between two samples of a slower channel, which repeat the one before: a bus that is slower than the logger.

/// Fewer samples tell no rate.
const ENOUGH: usize = 30;
/// A change by less, in steps of the sensor, may be of an axis that is slow: a sample of a moving axis passes more.
const STEPS: f64 = 2.0;
/// Of the samples of a moving axis so many must come again in the next row,
const HELD: f64 = 0.9;
/// and so many for as long as the others, within half of that: an axis that sticks and slips keeps no time.
const ALIKE: f64 = 0.8;

/// The rows of a position that are samples; none where each is one. `step` tells the step of its sensor, 0 where it has none.
///
/// An axis that stands repeats its position too: what is counted are places that it leaves by more than [`STEPS`] steps at once. Where
/// it stands, samples go on as far apart as they were.
pub(crate) fn samples(position: &[f64], step: impl FnOnce() -> f64) -> Option<Vec<usize>> {
    let changes: Vec<usize> = (1..position.len()).filter(|row| position[*row] != position[*row - 1]).collect();
    // Most logs are done with here.
    if !most_are_held(changes.windows(2).map(|pair| pair[1] - pair[0])) {
        return None;
    }
    let least = STEPS * step();
    let leaves = |row: usize| (position[row] - position[row - 1]).abs() >= least;
    let left = changes.windows(2).filter(|pair| leaves(pair[1])).map(|pair| pair[1] - pair[0]);
    let mut lengths: Vec<usize> = left.collect();
    lengths.sort_unstable();
    let usual = *lengths.get(lengths.len() / 2)?;
    let alike = lengths.iter().filter(|length| 2 * **length >= usual && 2 * **length <= 3 * usual).count();
    if !most_are_held(lengths.iter().copied()) || (alike as f64) < ALIKE * lengths.len() as f64 {
        return None;
    }
    let mut samples = Vec::new();
    let ends = changes.iter().copied().chain([position.len()]);
    for (start, end) in [0].into_iter().chain(changes.iter().copied()).zip(ends) {
        // What is left of less than half the usual length is the last sample, late.
        samples.extend((start..end).step_by(usual).filter(|row| *row == start || 2 * (end - row) > usual));
    }
    Some(samples)
}

fn most_are_held(lengths: impl Iterator<Item = usize> + Clone) -> bool {
    let (all, held) = (lengths.clone().count(), lengths.filter(|length| *length >= 2).count());
    all >= ENOUGH && held as f64 >= HELD * all as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn swing(row: usize) -> f64 {
        (0.003 * row as f64).sin()
    }

    #[test]
    fn a_slower_channel_is_told_by_its_even_steps() {
        let held: Vec<f64> = (0..3000).map(|row| swing(row / 15 * 15)).collect();
        let every_15th: Vec<usize> = (0..200).map(|sample| 15 * sample).collect();
        assert_eq!(samples(&held, || 0.0), Some(every_15th.clone()));
        // It stands for a second in the middle.
        let stands: Vec<f64> = (0..3000).map(|row| swing((row / 15 * 15).clamp(600, 1500))).collect();
        assert_eq!(samples(&stands, || 0.0), Some(every_15th));
        // Two and a half rows a sample.
        let uneven: Vec<f64> = (0..1000).map(|row| swing(row * 2 / 5)).collect();
        let rows = samples(&uneven, || 0.0).unwrap();
        assert_eq!((rows.len(), &rows[..5]), (400, &[0, 3, 5, 8, 10][..]));
    }

    #[test]
    fn each_row_of_others_is_a_sample() {
        let plain: Vec<f64> = (0..3000).map(swing).collect();
        assert_eq!(samples(&plain, || 0.0), None);
        // A slow axis on a coarse sensor stands for rows between two steps.
        let coarse: Vec<f64> = plain.iter().map(|place| (place / 0.05).round() * 0.05).collect();
        assert_eq!(samples(&coarse, || 0.05), None);
        // Stick and slip: away at once, after times that are not alike.
        let slips: Vec<f64> = (0..3000_usize).map(|row| (row.isqrt() as f64).floor()).collect();
        assert_eq!(samples(&slips, || 0.1), None);
        assert_eq!(samples(&[], || 0.0), None);
        assert_eq!(samples(&[1.0; 50], || 0.0), None);
    }
}
