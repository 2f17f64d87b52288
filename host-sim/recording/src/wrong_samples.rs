//! Single positions that stand apart: a bit lost on the way, a wrong conversion.

use super::gaps::{SIGMA_PER_MAD, median};

/// A position that is off by more than this many times what its neighbours leave of others in the median is no noise, ...
const OFF: f64 = 10.0;
/// ... where no step of time beside it is longer than the shortest by this share, and no motion within that share of a step is as much: a
/// stamp that is late moves the position of a moving axis too.
const EVEN: f64 = 0.2;

/// Rows, counted from 0, whose position is off by itself, and by how much; `step` is the sensor's, times rise.
///
/// What is left of the way between both neighbours is the offset in that row and minus half of it in either row beside: a motion, however it
/// accelerates or hits, leaves no such three, nor does a jump that stays.
pub fn wrong_samples(t_s: &[f64], position: &[f64], step: f64) -> Vec<(usize, f64)> {
    let left: Vec<f64> = position.windows(3).map(|three| three[1] - 0.5 * (three[0] + three[2])).collect();
    let mut sizes: Vec<f64> = left.iter().map(|left| left.abs()).collect();
    if sizes.is_empty() {
        return Vec::new();
    }
    let least = OFF * step.max(SIGMA_PER_MAD * median(&mut sizes));
    let of_one = |three: &[f64], moved: &[f64]| {
        let half = |beside: f64| (beside + 0.5 * three[1]).abs() <= 0.25 * three[1].abs();
        let by_a_stamp = 0.5 * EVEN * (moved[3] - moved[1]).abs();
        three[1].abs() > least.max(by_a_stamp) && half(three[0]) && half(three[2])
    };
    let is_even = |t_s: &[f64]| {
        let steps = || t_s.windows(2).map(|pair| pair[1] - pair[0]);
        steps().fold(0.0, f64::max) <= (1.0 + EVEN) * steps().fold(f64::INFINITY, f64::min)
    };
    let five = t_s.windows(5).zip(position.windows(5));
    let beside = left.windows(3).zip(five).enumerate();
    let rows = beside.filter(|(_, (three, (t_s, moved)))| is_even(t_s) && of_one(three, moved));
    rows.map(|(before, (three, _))| (before + 2, three[1])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Swings, stops hard at 5 s and jumps by 6 rad at 8 s.
    fn moved(row: u32) -> f64 {
        let t_s = f64::from(row) * 1e-3;
        let jump = if row < 8000 { 0.0 } else { 6.0 };
        (3.0 * t_s.min(5.0)).sin() + 1e-5 * (17.0 * f64::from(row)).sin() + jump
    }

    #[test]
    fn single_positions_that_stand_apart_are_found_and_no_motion_is() {
        let mut position: Vec<f64> = (0..10_000).map(moved).collect();
        let t_s: Vec<f64> = (0..10_000).map(|row| f64::from(row) * 1e-3).collect();
        assert_eq!(wrong_samples(&t_s, &position, 1e-5), []);
        position[1234] += 0.05;
        position[7000] -= 0.002;
        let found = wrong_samples(&t_s, &position, 1e-5);
        assert_eq!(found.iter().map(|one| one.0).collect::<Vec<_>>(), [1234, 7000]);
        assert!((found[0].1 - 0.05).abs() < 1e-4 && (found[1].1 + 0.002).abs() < 1e-4, "{found:?}");
        assert_eq!(wrong_samples(&t_s, &position, 1e-3).len(), 1, "two steps of the sensor are none");
        let late = t_s.iter().enumerate().map(|(row, t_s)| t_s + if row == 1233 { 5e-4 } else { 0.0 });
        assert_eq!(wrong_samples(&late.collect::<Vec<_>>(), &position, 1e-5).len(), 1, "beside a late stamp");
        assert_eq!(wrong_samples(&[0.0, 1.0], &[0.0, 1.0], 0.0), []);
    }
}
