//! Orders over position at which the missing torque stands out.

use crate::effects::Excitation;

/// How many of what stands out are tried.
pub(super) const MOST: usize = 4;
/// Lowest order that is looked at: what comes back once in a revolution or a travel is hardly told from a slope.
const LOWEST_ORDER: usize = 2;
/// Highest order over a revolution that is looked at.
pub(super) const HIGHEST_ORDER: usize = 128;
/// Neighbours on either side that a peak of a spectrum is measured by.
const NEIGHBOURS: usize = 12;
/// Parts of what a travel tells apart that orders of a linear axis, which has no whole ones, are looked at in: between two of them a
/// peak of the spectrum is a parabola.
const PARTS: usize = 4;

/// Orders at which a torque over position stands out of its neighbours, best first; the torque with its position, row by row.
pub(super) fn orders(torques: impl Iterator<Item = (f64, f64)>, excitation: &Excitation) -> Vec<f64> {
    if excitation.travel <= 0.0 {
        return Vec::new();
    }
    let parts = if excitation.linear { PARTS } else { 1 };
    let apart = excitation.orders_apart() / parts as f64;
    let mut phasors = vec![(0.0, 0.0); parts * HIGHEST_ORDER + 1];
    for (torque, position) in torques {
        // Each order is the one before turned on by the first.
        let (s1, c1) = (apart * position).sin_cos();
        let (mut s, mut c) = (0.0, torque);
        for (sine, cosine) in &mut phasors {
            (*sine, *cosine) = (*sine + s, *cosine + c);
            (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
        }
    }
    let lowest = LOWEST_ORDER * parts;
    let power: Vec<f64> = phasors[lowest..].iter().map(|(sine, cosine)| sine * sine + cosine * cosine).collect();
    let highest = (parts * HIGHEST_ORDER) as f64;
    // Where the travel hardly tells one order from the next, the likelihood chooses among neighbours.
    let mut found: Vec<f64> = Vec::new();
    for peak in peaks(&power, parts) {
        let between = if parts > 1 { top_between(&power, peak) } else { 0.0 };
        let at = (lowest + peak) as f64 + between;
        for order in [at, at - parts as f64, at + parts as f64] {
            if order >= lowest as f64 && order <= highest && !found.contains(&order) {
                found.push(order);
            }
        }
    }
    found.into_iter().map(|order| order * apart).collect()
}

/// Where the parabola through a local maximum and its neighbours has its top, from the maximum, in their distance.
fn top_between(power: &[f64], at: usize) -> f64 {
    let (Some(before), Some(behind)) = (at.checked_sub(1).map(|at| power[at]), power.get(at + 1)) else { return 0.0 };
    let bent = 2.0 * power[at] - before - behind;
    if bent > 0.0 { 0.5 * (behind - before) / bent } else { 0.0 }
}

/// Places of the largest local maxima over the median of their neighbourhood, best first, of a spectrum in so many `parts` of what
/// is told apart.
pub(super) fn peaks(power: &[f64], parts: usize) -> Vec<usize> {
    let neighbours = NEIGHBOURS * parts;
    let mut found: Vec<(f64, usize)> = (0..power.len())
        .filter(|&i| power[i] > 0.0)
        .filter(|&i| (i == 0 || power[i] >= power[i - 1]) && (i + 1 == power.len() || power[i] >= power[i + 1]))
        .map(|i| {
            let mut near: Vec<f64> =
                power[i.saturating_sub(neighbours)..(i + neighbours + 1).min(power.len())].to_vec();
            let middle = near.len() / 2;
            let median = *near.select_nth_unstable_by(middle, f64::total_cmp).1;
            (power[i] / median.max(f64::MIN_POSITIVE), i)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().take(MOST).map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Orders of a torque that swings over position, on an axis that goes to and fro twice.
    fn found(order: f64, travel: f64, linear: bool) -> Vec<f64> {
        let positions = (0..4000).map(|row| travel * (0.5 - 0.5 * (f64::from(row) / 318.0).cos()));
        let torques = positions.map(|position| ((order * position + 0.4).sin(), position));
        orders(torques, &Excitation { travel, linear, ..Excitation::default() })
    }

    #[test]
    fn an_order_of_a_linear_axis_is_found_between_those_that_its_travel_tells_apart() {
        let travel = 0.4;
        let apart = TAU / travel;
        for order in [4.3 * apart, 7.61 * apart, 40.2 * apart] {
            let first = found(order, travel, true)[0];
            println!("{order} is found as {first}, {:.3} of what the travel tells apart", (first - order) / apart);
            assert!((first - order).abs() < 0.1 * apart, "{first} {order}");
        }
    }

    #[test]
    fn an_order_of_a_revolution_is_whole() {
        assert_eq!(found(17.0, 3.0 * TAU, false)[0], 17.0);
        assert!(found(17.3, 3.0 * TAU, false).iter().all(|order| order.fract() == 0.0));
    }

    #[test]
    fn a_parabola_has_its_top_where_it_is() {
        let power: Vec<f64> = (0..5).map(|at| 9.0 - (f64::from(at) - 2.3).powi(2)).collect();
        assert!((top_between(&power, 2) - 0.3).abs() < 1e-12);
        assert_eq!(top_between(&[1.0, 0.5], 0), 0.0);
        assert_eq!(top_between(&[1.0, 1.0, 1.0], 1), 0.0);
    }
}
