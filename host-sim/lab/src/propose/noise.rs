//! What noise leaves of a window, and what it does to a difference between two models.

use nalgebra::{DMatrix, DVector};

/// Noise of the sensor, white, and of the torque, held over each sample and integrated twice by the machine: within a
/// window the second is smooth and hides smooth differences, whatever its root mean square.
#[derive(Debug, Clone)]
pub(super) struct Noise {
    rows: usize,
    period_s: f64,
    /// Standard deviation of the position's noise, rad (m).
    sensor: f64,
    /// Standard deviation of the acceleration in one sample, rad/s2 (m/s2).
    acceleration: f64,
    /// Mean of a window's sum of squares, rad2 (m2), its best start taken out.
    pub energy: f64,
    /// Freedom of the chi-squared distribution with that sum's mean and variance.
    pub freedom: f64,
}

impl Noise {
    /// Noise whose windows of `rows` samples leave `floor` root mean square, of which the sensor has `sensor`; rad (m).
    pub(super) fn new(sensor: f64, floor: f64, rows: usize, period_s: f64) -> Self {
        // A continuous sensor without torque noise would make every difference infinite.
        let sensor = sensor.max(1e-9);
        let (of_sensor, of_torque) = shapes(rows, period_s);
        let beyond = rows as f64 * floor * floor - of_sensor.trace() * sensor * sensor;
        let acceleration = (beyond / of_torque.trace()).max(0.0).sqrt();
        Self::of_shapes(sensor, acceleration, period_s, &of_sensor, &of_torque)
    }

    /// Noise of known sources: of the position, rad (m), and of the acceleration in each sample, rad/s2 (m/s2).
    pub(super) fn of_sources(sensor: f64, acceleration: f64, rows: usize, period_s: f64) -> Self {
        let (of_sensor, of_torque) = shapes(rows, period_s);
        Self::of_shapes(sensor, acceleration, period_s, &of_sensor, &of_torque)
    }

    fn of_shapes(
        sensor: f64,
        acceleration: f64,
        period_s: f64,
        of_sensor: &DMatrix<f64>,
        of_torque: &DMatrix<f64>,
    ) -> Self {
        let covariance = of_sensor * (sensor * sensor) + of_torque * (acceleration * acceleration);
        let energy = covariance.trace();
        let freedom = energy * energy / covariance.norm_squared();
        Self { rows: covariance.nrows(), period_s, sensor, acceleration, energy, freedom }
    }

    /// Variance of the noise along a difference that is `difference` over the rows of a window.
    pub(super) fn variance_along(&self, difference: &[f64]) -> f64 {
        let white: f64 = difference.iter().map(|d| d * d).sum();
        // Sum over later rows of the difference times the way that a push at this row makes until then.
        let (mut pushed, mut later, mut moment) = (0.0, 0.0, 0.0);
        for &d in difference.iter().rev() {
            moment += later;
            let way = moment - 0.5 * later;
            pushed += way * way;
            later += d;
        }
        let dt2 = self.period_s * self.period_s;
        self.sensor * self.sensor * white + (self.acceleration * dt2).powi(2) * pushed
    }

    /// Root mean square of a window of noise, rad (m).
    pub(super) fn rms(&self) -> f64 {
        (self.energy / self.rows as f64).sqrt()
    }
}

/// Covariances of a window under unit noise of the sensor and of the acceleration, the best line taken out.
fn shapes(rows: usize, period_s: f64) -> (DMatrix<f64>, DMatrix<f64>) {
    let take_line = without_line(rows);
    let dt2 = period_s * period_s;
    let response = |row: usize, tick: usize| if row > tick { dt2 * ((row - tick) as f64 - 0.5) } else { 0.0 };
    let pushed = &take_line * DMatrix::from_fn(rows, rows, response);
    let of_torque = &pushed * pushed.transpose();
    (take_line, of_torque)
}

/// The projection that takes the best line, start position and speed, out of a window.
fn without_line(rows: usize) -> DMatrix<f64> {
    let count = rows as f64;
    let constant = DVector::from_element(rows, 1.0 / count.sqrt());
    let slope = DVector::from_fn(rows, |row, _| row as f64 - 0.5 * (count - 1.0)).normalize();
    DMatrix::identity(rows, rows) - &constant * constant.transpose() - &slope * slope.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_is_kept_and_the_variance_is_that_of_the_covariance() {
        let noise = Noise::new(3.7e-6, 2e-5, 100, 5e-4);
        assert!((noise.rms() / 2e-5 - 1.0).abs() < 1e-9, "{:e}", noise.rms());
        assert!(noise.freedom < 5.0, "torque noise has few shapes: {}", noise.freedom);
        let again = Noise::of_sources(3.7e-6, noise.acceleration, 100, 5e-4);
        assert!((again.rms() / 2e-5 - 1.0).abs() < 1e-9);
        let white = Noise::new(3.7e-6, 3.6e-6, 100, 5e-4);
        assert!((white.freedom - 98.0).abs() < 1e-6 && white.acceleration == 0.0);
        // Along one pushed sample, by the response itself.
        let difference: Vec<f64> = (0..100).map(|row| ((row as f64) * 0.1).sin()).collect();
        let mut expected = 3.7e-6_f64.powi(2) * difference.iter().map(|d| d * d).sum::<f64>();
        for tick in 0..100 {
            let along: f64 = (tick + 1..100).map(|row| difference[row] * ((row - tick) as f64 - 0.5)).sum();
            expected += (noise.acceleration * 2.5e-7 * along).powi(2);
        }
        assert!((noise.variance_along(&difference) / expected - 1.0).abs() < 1e-9);
    }
}
