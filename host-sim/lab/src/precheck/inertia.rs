//! A first estimate of the inertia: robust least squares with friction, gravity and the fluid in it.

use nalgebra::{DMatrix, DVector};

use super::windows::{Window, windows};
use crate::read::{Machine, Recording};

/// Lengths of the windows that are tried, s: from the fastest motion of such axes to the noise of a coarse sensor.
const LENGTHS_S: [f64; 6] = [0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
/// Fewer windows for each unknown tell nothing.
const WINDOWS_EACH: usize = 5;
/// Rounds of the robust fit; weights change little after.
const ROUNDS: usize = 6;
/// Residuals beyond this many standard deviations count less (Huber 1964: 95 % efficient where all is normal).
const HUBER: f64 = 1.345;
/// Standard deviation of a normal distribution over its median absolute deviation.
const SIGMA_PER_MAD: f64 = 1.4826;
/// Below this partial correlation other torques may be what relates torque and acceleration: the speed of a slow axis ripples
/// with a cogging that the torque works against (0.64 on a real one), where a motion that tells the inertia has 0.83 and more.
const RELATED: f64 = 0.75;
/// Columns whose common part is all but this share of them, squared, are one column.
const ALIKE: f64 = 1e-9;
/// Rotations at most for the eigenvalues of eight columns; thirty are usual, and what is not a number would take for ever.
const MOST_ROTATIONS: usize = 1000;
/// Share of the windows that may be wrong, at the top of a speed or an acceleration.
const WRONG: f64 = 0.005;

/// What the data say of the inertia.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Inertia {
    /// Partial correlation of torque and acceleration, -1 to 1.
    pub correlation: f64,
    /// The least the inertia may be: the slope of the torque over the acceleration, which noise in the latter makes smaller.
    pub low: f64,
    /// The most it may be: one over the slope of the acceleration over the torque, which other torques make larger.
    pub high: f64,
}

/// A first look at the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Estimate {
    /// Highest speed, rad/s (m/s), the share that may be wrong set aside.
    pub speed: f64,
    /// Highest acceleration, rad/s2 (m/s2), likewise, of the longest windows that still have it half.
    pub acceleration: f64,
    /// None where torque and acceleration have nothing to do with each other.
    pub inertia: Option<Inertia>,
}

/// A first look at a recording; windows of the length that relates torque and acceleration best.
pub(super) fn estimate(machine: &Machine, recording: &Recording, period_s: f64) -> Estimate {
    let mut found = Estimate { speed: 0.0, acceleration: 0.0, inertia: None };
    for length_s in LENGTHS_S {
        let windows = windows(machine, recording, period_s, length_s);
        if windows.is_empty() {
            continue;
        }
        found.speed = found.speed.max(high(windows.iter().map(|window| window.speed.abs())));
        if let Some(inertia) = fitted(&windows)
            && found.inertia.is_none_or(|best| inertia.correlation.abs() > best.correlation.abs())
        {
            found.inertia = Some(inertia);
            found.acceleration = high(windows.iter().map(|window| window.acceleration.abs()));
        }
    }
    found
}

/// The largest value but for the share that may be wrong.
fn high(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    let at = ((1.0 - WRONG) * (values.len() - 1) as f64) as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

fn fitted(windows: &[Window]) -> Option<Inertia> {
    let columns = windows.first()?.others.len();
    if windows.len() < WINDOWS_EACH * (columns + 1) {
        return None;
    }
    let others = DMatrix::from_fn(windows.len(), columns, |row, column| windows[row].others[column]);
    let effort = DVector::from_iterator(windows.len(), windows.iter().map(|window| window.effort));
    let acceleration = DVector::from_iterator(windows.len(), windows.iter().map(|window| window.acceleration));
    let mut weights = DVector::repeat(windows.len(), 1.0);
    let mut inertia = None;
    for _ in 0..ROUNDS {
        let [effort, acceleration] = without([&effort, &acceleration], &others, &weights)?;
        let weighted = |one: &DVector<f64>, other: &DVector<f64>| -> f64 {
            one.iter().zip(other).zip(&weights).map(|((one, other), weight)| weight * one * other).sum()
        };
        let both = weighted(&effort, &acceleration);
        let (of_effort, of_acceleration) = (weighted(&effort, &effort), weighted(&acceleration, &acceleration));
        let correlation = both / (of_effort * of_acceleration).sqrt();
        if !correlation.is_finite() || both == 0.0 {
            return None;
        }
        let slope = both / of_acceleration;
        inertia = Some(Inertia { correlation, low: slope.abs(), high: (of_effort / both).abs() });
        weights = huber(&(effort - acceleration * slope));
    }
    inertia.filter(|inertia| inertia.correlation.abs() >= RELATED)
}

/// What is left of both values once the others are taken out by weighted least squares; none where these are not finite.
fn without(values: [&DVector<f64>; 2], others: &DMatrix<f64>, weights: &DVector<f64>) -> Option<[DVector<f64>; 2]> {
    let roots = weights.map(f64::sqrt);
    let mut scaled = others.clone();
    scaled.column_iter_mut().for_each(|mut column| column.component_mul_assign(&roots));
    // Columns of very different size become one size, and those that are others of them in disguise are left out.
    let sizes =
        DVector::from_iterator(scaled.ncols(), scaled.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)));
    scaled.column_iter_mut().zip(&sizes).for_each(|(mut column, size)| column /= *size);
    let eigen = scaled.tr_mul(&scaled).try_symmetric_eigen(f64::EPSILON, MOST_ROTATIONS)?;
    let least = ALIKE * eigen.eigenvalues.max();
    let inverse = eigen.eigenvalues.map(|value| if value > least { value.recip() } else { 0.0 });
    Some(values.map(|values| {
        let along = eigen.eigenvectors.tr_mul(&scaled.tr_mul(&values.component_mul(&roots)));
        let factors = (&eigen.eigenvectors * along.component_mul(&inverse)).component_div(&sizes);
        values - others * factors
    }))
}

/// Weights of a robust fit from its residuals; all the same where most of these are zero.
fn huber(residuals: &DVector<f64>) -> DVector<f64> {
    let mut sizes: Vec<f64> = residuals.iter().map(|residual| residual.abs()).collect();
    let middle = sizes.len() / 2;
    let limit = HUBER * SIGMA_PER_MAD * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    residuals.map(|residual| if residual.abs() <= limit || limit == 0.0 { 1.0 } else { limit / residual.abs() })
}
