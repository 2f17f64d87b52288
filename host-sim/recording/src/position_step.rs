//! The step of a recorded position: the spacing of the lattice that its values lie on.
//!
//! An axis that moves fast passes many steps from row to row, but comes back to places next to those it was at before. So
//! neighbours among the sorted values are looked at, not neighbours in time. Residues of their distances by the right step gather
//! about whole numbers; those of any other spread evenly. How well they gather is the length of their mean on the unit circle
//! (Rayleigh's test of directions; Mardia and Jupp, Directional Statistics, 2000, 6.3.1).

/// Fewer changes tell nothing.
const ENOUGH: usize = 100;
/// Fewer distances than this tell a lattice from chance only where the values repeat: with the mean of [`GATHERED`], 30 of
/// evenly spread residues would gather so with a probability of exp(-30 0.7^2) = 4e-7.
const ENOUGH_DISTANCES: usize = 30;
/// Distances of more steps than this each are left out: the first guess of a step is not that exact.
const AT_ONCE: f64 = 20.0;
/// The length of the mean residue, 1 for a lattice: steps that a log rounds to a tenth of them leave 0.8.
const GATHERED: f64 = 0.7;
/// A distance this many times the next smaller one may be the first that is no rounding.
const LEAP: f64 = 3.0;
/// Distances below this part of the travel are rounding of 64-bit numbers.
const ROUNDING: f64 = 1e-12;
/// Distances over this many values must still gather, or the step is one of chance.
const FARTHEST: usize = 8;

/// The largest step of which the distances of positions are multiples, rad (m); none where they lie on no lattice.
pub fn position_step(positions: &[f64]) -> Option<f64> {
    let changes = positions.windows(2).filter(|pair| pair[1] != pair[0]).count();
    let mut values: Vec<f64> = positions.iter().copied().filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let travel = values.last()? - values.first()?;
    if changes < ENOUGH || travel <= 0.0 {
        return None;
    }
    let mut distances: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    distances.retain(|distance| *distance > ROUNDING * travel);
    distances.sort_by(f64::total_cmp);
    // Below a leap are places that are the same but for rounding. The smallest of all comes last.
    let leaps = distances.windows(2).rev().filter(|pair| pair[1] > LEAP * pair[0]).map(|pair| pair[1]);
    let step = leaps.chain(distances.first().copied()).find_map(|first| {
        values_apart(&values, first / LEAP, changes).and_then(|places| step_near(first, &places, changes))
    });
    step.filter(|step| !is_of_one_speed(positions, *step))
}

/// Whether most rows move on by the same number of steps, other than none: places at one speed lie on a lattice of their own.
fn is_of_one_speed(positions: &[f64], step: f64) -> bool {
    let mut moves: Vec<f64> = positions.windows(2).map(|pair| ((pair[1] - pair[0]) / step).round()).collect();
    moves.sort_by(f64::total_cmp);
    let middle = moves[moves.len() / 2];
    let same = moves.iter().filter(|one| **one == middle).count();
    middle != 0.0 && 2 * same > moves.len()
}

/// The values, one of those closer than `least`; none where they go on from one to the next, so that nothing lies apart, or where too
/// few are left to tell anything.
fn values_apart(values: &[f64], least: f64, changes: usize) -> Option<Vec<f64>> {
    let mut places: Vec<f64> = Vec::new();
    let mut before = f64::NEG_INFINITY;
    for value in values {
        if places.last().is_none_or(|last| value - last > least) {
            if value - before < least {
                return None;
            }
            places.push(*value);
        }
        before = *value;
    }
    // Values that repeat are of a lattice, however few they are.
    (places.len() > ENOUGH_DISTANCES || (places.len() > 2 && 2 * places.len() < changes)).then_some(places)
}

/// The step near `first` that the distances of `places`, which rise, are multiples of: over one place, then over more.
fn step_near(first: f64, places: &[f64], changes: usize) -> Option<f64> {
    let over = |count: usize| places.iter().zip(&places[count..]).map(|(low, high)| high - low);
    let mut step = first;
    for most in [2.5, 5.0, 10.0, AT_ONCE] {
        step = refined(step, over(1).filter(|distance| *distance < most * step));
    }
    let mut count = 1;
    while count < places.len() {
        let distances: Vec<f64> = over(count).filter(|distance| *distance < AT_ONCE * count as f64 * step).collect();
        let enough = distances.len() >= ENOUGH_DISTANCES || 2 * places.len() < changes;
        if distances.is_empty() || !enough || gathered(&distances, step) < GATHERED {
            break;
        }
        step = refined(step, distances.into_iter());
        count *= 2;
    }
    // Of few places the farthest are as good.
    (count >= FARTHEST.min(places.len())).then_some(step)
}

/// The step by least squares, from distances that are about multiples of it.
fn refined(step: f64, distances: impl Iterator<Item = f64>) -> f64 {
    let (product, square) = distances.fold((0.0, 0.0), |(product, square), distance| {
        let steps = (distance / step).round();
        (product + steps * distance, square + steps * steps)
    });
    if square > 0.0 { product / square } else { step }
}

/// The length of the mean of the residues by a step, 0 to 1.
fn gathered(distances: &[f64], step: f64) -> f64 {
    let turns = distances.iter().map(|distance| std::f64::consts::TAU * distance / step);
    let (sine, cosine) = turns.fold((0.0, 0.0), |(sine, cosine), turn| (sine + turn.sin(), cosine + turn.cos()));
    sine.hypot(cosine) / distances.len() as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A swing with a growing amplitude: no place is reached twice but by chance.
    fn swing(rows: usize, speed: f64) -> impl Iterator<Item = f64> {
        (0..rows).map(move |row| (1.0 + 1e-4 * row as f64) * (speed * row as f64).sin())
    }

    fn on_lattice(step: f64, values: impl Iterator<Item = f64>) -> Vec<f64> {
        values.map(|value| (value / step).round() * step).collect()
    }

    fn near(found: Option<f64>, step: f64) {
        assert!(found.is_some_and(|found| (found / step - 1.0).abs() < 1e-3), "{found:?} instead of {step}");
    }

    #[test]
    fn steps_are_found_and_none_where_there_are_none() {
        let step = std::f64::consts::TAU / 4096.0;
        let coarse = on_lattice(step, swing(4000, 0.004));
        near(position_step(&coarse), step);
        // As a log with six decimals has it.
        near(position_step(&on_lattice(1e-6, coarse.iter().copied())), step);
        assert_eq!(position_step(&swing(4000, 0.004).collect::<Vec<_>>()), None);
        assert_eq!(position_step(&swing(4000, 0.17).collect::<Vec<_>>()), None);
        assert_eq!(position_step(&coarse[..50]), None);
        assert_eq!(position_step(&[]), None);
    }

    #[test]
    fn an_axis_that_passes_hundreds_of_steps_a_row_has_its_step() {
        for step in [1e-4, 25.0 / 65535.0, std::f64::consts::TAU / 10000.0] {
            near(position_step(&on_lattice(step, swing(3000, 0.17))), step);
        }
        // Steps that the log rounds to a ninth of them, and to a thirtieth.
        for step in [8.8e-5, std::f64::consts::TAU / 20000.0] {
            let rounded = on_lattice(1e-5, on_lattice(step, swing(3000, 0.17)).into_iter());
            near(position_step(&rounded), step);
        }
    }

    #[test]
    fn places_at_one_speed_are_no_steps() {
        let ramp = |row: u32| 0.27 * f64::from(row) + 0.01 * (f64::from(row) * 0.7).sin();
        assert_eq!(position_step(&(0..500).map(ramp).collect::<Vec<_>>()), None);
        // But a sensor that a slow axis counts up one by one has them.
        near(position_step(&on_lattice(1e-3, (0..3000).map(|row| 3e-4 * f64::from(row)))), 1e-3);
    }

    #[test]
    fn places_that_are_one_but_for_rounding_count_once() {
        let step = 25.0 / 65535.0;
        let turned = on_lattice(step, swing(3000, 0.17)).into_iter().enumerate();
        let fuzzy = turned.map(|(row, value)| value + if row % 3 == 0 { 1e-8 } else { 0.0 });
        near(position_step(&fuzzy.collect::<Vec<_>>()), step);
    }

    #[test]
    fn a_sensor_with_few_steps_in_its_travel_has_them() {
        near(position_step(&on_lattice(0.1, swing(3000, 0.17))), 0.1);
    }
}
