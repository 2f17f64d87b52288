//! Positions that a drive keeps within a range: where they leave it at one end they come in at the other.

use super::mapping::Reading;

/// A jump is over this part of the travel, for it is from one end to the other,
const OF_TRAVEL: f64 = 0.8;
/// and no other change is over this part: the axis is not that fast. A range is passed in ten rows or more.
const OTHER_CHANGES: f64 = 0.1;
/// Widths that differ by more than this share are of no one range.
const SAME: f64 = 0.1;
/// A width is not told better than this share of it: 16 bits of range and some noise.
const FINE: f64 = 1e-3;
/// A glitch jumps there and back within so many rows.
const BACK_WITHIN: usize = 3;

/// What a position jumps by, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Wrap {
    /// Width of the range, rad (m).
    pub width: f64,
    /// How far off the width may be, rad (m): what the motion of a row changes by.
    pub within: f64,
    /// Rows before the jumps.
    pub rows: Vec<usize>,
}

/// The jumps of a position that wraps; none where it counts on.
pub fn wrap(positions: &[f64]) -> Option<Wrap> {
    let (low, high) = positions
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let travel = high - low;
    let changes: Vec<f64> = positions.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let rows: Vec<usize> = changes
        .iter()
        .enumerate()
        .filter(|(_, change)| change.abs() > OF_TRAVEL * travel)
        .map(|(row, _)| row)
        .collect();
    let is_jump = |row: &usize| rows.binary_search(row).is_ok();
    let fastest = (0..changes.len()).filter(|row| !is_jump(row)).map(|row| changes[row].abs()).fold(0.0, f64::max);
    if rows.is_empty() || travel <= 0.0 || fastest > OTHER_CHANGES * travel {
        return None;
    }
    // The motion goes on the other way than it jumps, by about the mean of the changes beside the jump.
    let beside = |row: usize| {
        let at = |row: usize| changes.get(row).filter(|_| !is_jump(&row)).copied();
        let (before, after) = (row.checked_sub(1).and_then(at), at(row + 1));
        [before.or(after).unwrap_or(0.0), after.or(before).unwrap_or(0.0)]
    };
    let motion = |row: usize| 0.5 * beside(row).iter().sum::<f64>();
    let goes_on = |row: &usize| motion(*row) * changes[*row] < 0.0;
    let there_and_back = rows.windows(2).any(|pair| {
        pair[1] - pair[0] <= BACK_WITHIN
            && changes[pair[0]] * changes[pair[1]] < 0.0
            && !(goes_on(&pair[0]) && goes_on(&pair[1]))
    });
    let widths: Vec<f64> = rows.iter().map(|row| (changes[*row] - motion(*row)).abs()).collect();
    let width = widths.iter().sum::<f64>() / widths.len() as f64;
    let alike = widths.iter().all(|other| (other - width).abs() < SAME * width);
    let changing =
        rows.iter().map(|row| beside(*row)).map(|[before, after]| (before - after).abs()).fold(0.0, f64::max);
    let within = changing.max(FINE * width);
    (rows.iter().all(goes_on) && alike && !there_and_back).then_some(Wrap { width, within, rows })
}

impl Wrap {
    /// Positions as if they counted on.
    pub fn undo(&self, positions: &mut [f64]) {
        Reading { factor: 1.0, wrap: Some(self.width) }.apply(positions, 0.0);
    }

    /// The width in a unit of which one is `factor`: the number a drive has as its range, which is round in that unit or a whole
    /// number of revolutions, where one is near enough.
    pub fn width_in(&self, factor: f64) -> f64 {
        let [width, within] = [self.width, self.within].map(|value| value / factor.abs());
        let turn = std::f64::consts::TAU / factor.abs();
        // Of many turns some number is near any width.
        let turns = (width / turn).round().clamp(1.0, 16.0) * turn;
        // Counts of a power of two, then numbers of ever more digits.
        let rounded = |digits: usize| format!("{width:.digits$e}").parse::<f64>().unwrap_or(width);
        let power = width.log2().round().exp2();
        let candidates = std::iter::once(turns).chain((power >= 256.0).then_some(power)).chain((0..6).map(rounded));
        candidates.into_iter().find(|candidate| (candidate - width).abs() <= within).unwrap_or(width)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A motion to and fro, kept within a range of this width about zero.
    fn wrapped(width: f64) -> Vec<f64> {
        let motion = (0..4000).map(|row| 1.4 * width * (0.006 * f64::from(row)).sin());
        motion.map(|value| value - width * (value / width).round()).collect()
    }

    #[test]
    fn the_width_of_a_range_that_is_left_is_found() {
        let found = wrap(&wrapped(25.0)).unwrap();
        assert!((found.width - 25.0).abs() < 0.01 && found.rows.len() > 3, "{found:?}");
        assert_eq!(found.width_in(1.0), 25.0);
        let turn = wrap(&wrapped(std::f64::consts::TAU)).unwrap();
        assert_eq!(turn.width_in(1.0), std::f64::consts::TAU);
        assert!((turn.width_in(1f64.to_radians()) - 360.0).abs() < 1e-9);
        assert!((turn.width_in(std::f64::consts::TAU / 4096.0) - 4096.0).abs() < 1e-9);
        assert_eq!(wrap(&wrapped(65536.0)).unwrap().width_in(1.0), 65536.0);
    }

    #[test]
    fn other_jumps_are_no_wraps() {
        let swing: Vec<f64> = (0..4000).map(|row| (0.006 * f64::from(row)).sin()).collect();
        assert_eq!(wrap(&swing), None);
        let mut glitch = swing.clone();
        glitch[1000] += 30.0;
        assert_eq!(wrap(&glitch), None);
        let at_rest: Vec<f64> = (0..400).map(|row| if row < 200 { 0.0 } else { 5.0 }).collect();
        assert_eq!(wrap(&at_rest), None);
        assert_eq!(wrap(&[]), None);
    }
}
