//! The step of a recorded position, where it moves in steps.

/// Fewer changes tell nothing.
const ENOUGH: usize = 100;
/// A position that moves in steps moves by fewer than this many of them at a time, mostly.
const AT_ONCE: f64 = 20.0;
/// A change this near to whole steps is whole; logs round.
const WHOLE: f64 = 0.05;

/// The smallest step of positions, of which nearly all changes are multiples, rad (m); none where they do not move in steps.
pub fn position_step(positions: &[f64]) -> Option<f64> {
    let changes = || positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|change| *change > 0.0);
    let (count, smallest) = changes().fold((0, f64::INFINITY), |(count, least), change| (count + 1, least.min(change)));
    let small: Vec<f64> = changes().map(|change| change / smallest).filter(|steps| *steps < AT_ONCE).collect();
    let whole = small.iter().filter(|steps| (*steps - steps.round()).abs() < WHOLE).count();
    let steps = count >= ENOUGH && 2 * small.len() >= count && 50 * whole >= 49 * small.len();
    steps.then_some(smallest)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn swing(rows: usize) -> impl Iterator<Item = f64> {
        (0..rows).map(|row| (0.004 * row as f64).sin())
    }

    #[test]
    fn steps_are_found_and_none_where_there_are_none() {
        let step = std::f64::consts::TAU / 4096.0;
        let coarse: Vec<f64> = swing(4000).map(|q| (q / step).round() * step).collect();
        assert!((position_step(&coarse).unwrap() / step - 1.0).abs() < 1e-6);
        // As a log with six decimals has it.
        let logged: Vec<f64> = coarse.iter().map(|q| (q * 1e6).round() * 1e-6).collect();
        assert!((position_step(&logged).unwrap() / step - 1.0).abs() < 2e-3);
        assert_eq!(position_step(&swing(4000).collect::<Vec<_>>()), None);
        assert_eq!(position_step(&coarse[..50]), None);
        assert_eq!(position_step(&[]), None);
    }
}
