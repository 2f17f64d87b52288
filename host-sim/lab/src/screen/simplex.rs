//! Nelder and Mead's simplex, for effects whose residual has kinks: impacts come and go as the values move.

use nalgebra::DVector;

/// First edge of the simplex, in the unit of the coordinates.
const EDGE: f64 = 0.25;

/// The lowest point found from a start, with its value, after at most `evaluations`.
// Over 40 lines: one turn of the simplex, whose moves share all its corners.
pub(crate) fn minimise(
    start: &DVector<f64>,
    evaluations: usize,
    cost: impl Fn(&DVector<f64>) -> f64,
) -> (f64, DVector<f64>) {
    if evaluations <= 1 {
        return (cost(start), start.clone());
    }
    let size = start.len();
    let mut corners: Vec<(f64, DVector<f64>)> = (0..=size)
        .map(|corner| {
            let mut at = start.clone();
            if corner > 0 {
                at[corner - 1] += EDGE;
            }
            (cost(&at), at)
        })
        .collect();
    let mut used = corners.len();
    loop {
        corners.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (best, worst) = (corners[0].0, corners[size].0);
        if used >= evaluations || worst - best <= 1e-5 * best.abs() {
            return corners.swap_remove(0);
        }
        let centre = corners[..size].iter().fold(DVector::zeros(size), |sum, corner| sum + &corner.1) / size as f64;
        let along = |factor: f64| {
            let at = &centre + (&corners[size].1 - &centre) * factor;
            (cost(&at), at)
        };
        let reflected = along(-1.0);
        used += 1;
        let candidate = if reflected.0 < best {
            used += 1;
            let expanded = along(-2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < corners[size - 1].0 {
            reflected
        } else {
            used += 1;
            along(if reflected.0 < worst { -0.5 } else { 0.5 })
        };
        if candidate.0 < worst {
            corners[size] = candidate;
        } else {
            let towards = corners[0].1.clone();
            for corner in &mut corners[1..] {
                corner.1 = (&corner.1 + &towards) * 0.5;
                corner.0 = cost(&corner.1);
            }
            used += size;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bottom_of_a_valley_with_a_kink_is_found() {
        let cost = |at: &DVector<f64>| 1.0 + (at[0] - 2.0).abs() + 10.0 * (at[1] - at[0] * at[0] / 4.0).powi(2);
        let (value, at) = minimise(&DVector::from_vec(vec![0.0, 0.0]), 400, cost);
        assert!(value < 1.001 && (at[0] - 2.0).abs() < 1e-3, "{value} at {at}");
    }
}
