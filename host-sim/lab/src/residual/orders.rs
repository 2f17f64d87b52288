//! Whether the residual repeats with the position: orders per revolution, as cogging and eccentricity leave them.

use nalgebra::{DMatrix, DVector};

use super::window::{Residual, Window};
use crate::read::{AxisKind, Recording};

/// Orders named at most.
const NAMED: usize = 5;

/// One order of the residual torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Periods a revolution.
    pub per_rev: u32,
    /// N m.
    pub amplitude_nm: f64,
}

/// The orders that explain most, the strongest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Orders {
    /// At most five.
    pub orders: Vec<Order>,
    /// Share of the residual torque's squares about its mean that they explain, less what as many free coefficients would
    /// by chance.
    pub explained: f64,
}

impl Orders {
    /// Picks orders one at a time, each the best beside those before it. None for a linear axis, less than one revolution,
    /// or too few windows.
    pub fn of(residual: &Residual, recording: &Recording) -> Option<Self> {
        if recording.axis != AxisKind::Rotary {
            return None;
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let windows: Vec<&Window> = residual.usual().collect();
        let angles: Vec<f64> = windows.iter().map(|w| mean(&recording.position[w.start..w.end])).collect();
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let revolutions = (high - low) / std::f64::consts::TAU;
        // Three windows a period at least, and coefficients for a small share of the windows.
        let highest = (windows.len() as f64 / revolutions.max(1.0) / 3.0) as u32;
        if revolutions < 0.9 || windows.len() < 8 * NAMED || highest < 2 {
            return None;
        }
        let torque = DVector::from_iterator(windows.len(), windows.iter().map(|w| w.torque));
        let centred = torque.add_scalar(-torque.mean());
        let mut picked: Vec<u32> = Vec::new();
        let mut fit = Fit { coefficients: DVector::zeros(0), left: centred.norm_squared() };
        while picked.len() < NAMED {
            let candidates = (1..=highest.min(128)).filter(|order| !picked.contains(order));
            let fits = candidates.filter_map(|order| {
                let orders: Vec<u32> = picked.iter().copied().chain([order]).collect();
                Fit::new(&angles, &centred, &orders).map(|fit| (order, fit))
            });
            let (order, best) = fits.min_by(|a, b| a.1.left.total_cmp(&b.1.left))?;
            picked.push(order);
            fit = best;
        }
        Some(fit.describe(&picked, &centred, highest))
    }
}

struct Fit {
    coefficients: DVector<f64>,
    left: f64,
}

impl Fit {
    fn new(angles: &[f64], values: &DVector<f64>, orders: &[u32]) -> Option<Self> {
        let columns = DMatrix::from_fn(angles.len(), 2 * orders.len(), |row, column| {
            let phase = f64::from(orders[column / 2]) * angles[row];
            if column % 2 == 0 { phase.sin() } else { phase.cos() }
        });
        let coefficients = (columns.transpose() * &columns).cholesky()?.solve(&(columns.transpose() * values));
        let left = (values - &columns * &coefficients).norm_squared();
        Some(Self { coefficients, left })
    }

    fn describe(&self, picked: &[u32], values: &DVector<f64>, highest: u32) -> Orders {
        let mut orders: Vec<Order> = picked
            .iter()
            .zip(self.coefficients.as_slice().chunks(2))
            .map(|(per_rev, pair)| Order { per_rev: *per_rev, amplitude_nm: pair[0].hypot(pair[1]) })
            .collect();
        orders.sort_by(|a, b| b.amplitude_nm.total_cmp(&a.amplitude_nm));
        let total = values.norm_squared();
        // The best of many orders fits noise better than one order would: about ln of their number times.
        let chance = 2.0 * picked.len() as f64 * (1.0 + f64::from(highest).ln()) / values.len() as f64;
        let explained =
            if total > 0.0 { ((1.0 - self.left / total) - chance * self.left / total).max(0.0) } else { 0.0 };
        Orders { orders, explained }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::residual::testing::{recording, residual};

    /// `revolutions` at constant speed in 600 windows.
    fn turning(revolutions: f64) -> Recording {
        let t_s: Vec<f64> = (0..6000).map(|row| f64::from(row) * 5e-4).collect();
        let position = t_s.iter().map(|t| t / 3.0 * revolutions * std::f64::consts::TAU).collect();
        recording(t_s, position)
    }

    fn middle(position: &[f64]) -> f64 {
        position.iter().sum::<f64>() / position.len() as f64
    }

    #[test]
    fn orders_and_amplitudes_are_found() {
        let recording = turning(2.3);
        let torque = |p: &[f64], _| 0.1 + 0.05 * (7.0 * middle(p) + 0.4).sin() + 0.02 * (31.0 * middle(p) + 2.0).cos();
        let found = Orders::of(&residual(&recording, torque), &recording).unwrap();
        assert_eq!((found.orders[0].per_rev, found.orders[1].per_rev), (7, 31));
        assert!(
            (found.orders[0].amplitude_nm - 0.05).abs() < 1e-3 && (found.orders[1].amplitude_nm - 0.02).abs() < 1e-3
        );
        assert!(found.explained > 0.99, "{}", found.explained);
    }

    #[test]
    fn chance_has_no_orders_worth_the_name() {
        let recording = turning(2.3);
        let chance = |p: &[f64], _| (p[3] * 1e6).rem_euclid(1.0) - 0.5;
        let found = Orders::of(&residual(&recording, chance), &recording).unwrap();
        assert!(found.explained < 0.03, "{}", found.explained);
    }

    #[test]
    fn without_a_revolution_or_on_a_linear_axis_there_are_none() {
        let part = turning(0.8);
        assert_eq!(Orders::of(&residual(&part, |p, _| p[0].sin()), &part), None);
        let linear = Recording { axis: AxisKind::Linear, ..turning(3.0) };
        assert_eq!(Orders::of(&residual(&linear, |p, _| p[0].sin()), &linear), None);
    }
}
