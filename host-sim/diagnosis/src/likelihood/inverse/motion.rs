//! The motion of a recording, given: smoothed position and speed, and the test functions that turn positions into accelerations.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use statrs::function::erf::erf;

use crate::recorded::Recorded;

/// Half the support of a test function, s: force is judged flat up to about 7 Hz, above most disturbances that control leaves and
/// below most flexibility and ripple (an identification by inverse dynamics filters to 5 to 10 times the control's bandwidth).
const HALF_S: f64 = 0.05;
/// ... but no fewer rows than this to either side.
const FEWEST_ROWS: usize = 4;

/// One test function: the mean of the acceleration under a bump of area one, seen in positions and in forces.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Test {
    /// Rows of its support.
    pub(crate) rows: Range<usize>,
    /// The row in its middle.
    pub(crate) middle: usize,
    /// Weights of the positions of the support that make the acceleration, 1/s2.
    pub(crate) acceleration: Vec<f64>,
    /// The acceleration that the positions make as they were measured, rad/s2 (m/s2).
    pub(crate) accelerates: f64,
    /// Weights of what acts in each interval of the support, 1.
    pub(crate) force: Vec<f64>,
    /// Integral of the squared bump, 1/s: what white torque noise of density one leaves.
    pub(crate) per_density: f64,
    /// Sum of squares of the acceleration's weights, 1/s4: what white sensor noise of variance one leaves.
    pub(crate) per_sensor: f64,
}

impl Test {
    /// Over some rows of a recording, whose positions make the acceleration by these weights.
    fn new(recorded: &Recorded, rows: Range<usize>, middle: usize, acceleration: Vec<f64>) -> Self {
        let t_s = &recorded.t_s[rows.clone()];
        let force = forces(&acceleration, t_s);
        let intervals = force.iter().zip(t_s.windows(2));
        let per_density = intervals.map(|(weight, ends)| weight * weight / (ends[1] - ends[0])).sum();
        let per_sensor = acceleration.iter().map(|weight| weight * weight).sum();
        let accelerates = weighted(&acceleration, &recorded.position[rows.clone()]);
        Self { rows, middle, acceleration, accelerates, force, per_density, per_sensor }
    }

    /// The acceleration that positions of all rows make, rad/s2 (m/s2).
    pub(crate) fn acceleration_of(&self, position: &[f64]) -> f64 {
        weighted(&self.acceleration, &position[self.rows.clone()])
    }
}

/// Sum of positions under weights whose own sum is zero, against the first: a position far from zero keeps its digits.
fn weighted(weights: &[f64], position: &[f64]) -> f64 {
    let first = position[0];
    weights.iter().zip(position).map(|(weight, position)| weight * (position - first)).sum()
}

/// A recording's motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Smoothed position of each row, rad (m).
    pub(crate) position: Vec<f64>,
    /// Smoothed speed of each row, rad/s (m/s).
    pub(crate) speed: Vec<f64>,
    /// Its standard deviation, rad/s (m/s).
    pub(crate) speed_sd: f64,
    /// In the interval behind each row but the last, the probability that the rotor slides the way the speed says, less that of the
    /// other way, 0 to 1.
    pub(crate) slides: Vec<f64>,
    /// Standard deviation of a position sample, rad (m).
    pub(crate) sensor_sd: f64,
    pub(crate) tests: Vec<Test>,
    support_s: f64,
}

impl Motion {
    /// Number of residual torques that it gives.
    pub fn residuals(&self) -> usize {
        self.tests.len()
    }

    /// Frequency up to which its test functions pass 70 % of a force, Hz: the transform of the bump, 15 j2(x) / x^2, is that at 2.2.
    pub fn band_hz(&self) -> f64 {
        2.2 / (std::f64::consts::PI * self.support_s)
    }

    /// Support of its longest test function, s.
    pub(crate) fn support_s(&self) -> f64 {
        self.support_s
    }

    /// Of a recording whose sensor has steps of that size, rad (m).
    pub fn new(recorded: &Recorded, step: f64) -> Self {
        let segments = segments(recorded);
        // Half a row more: rows that come a little late are in.
        let least_s = (FEWEST_ROWS as f64 + 0.5) * recorded.period_s();
        let half_s = HALF_S.max(least_s);
        let rounding_sd = (step / 12.0_f64.sqrt()).max(f64::MIN_POSITIVE.sqrt());
        let mut smooth = smoothed(recorded, &segments, least_s);
        // As long as it leaves no more than the sensor's noise: what is longer bends reversals.
        let most = SMOOTHING_BIAS * smooth.left.max(rounding_sd);
        let mut speed_half_s = 2.0 * least_s;
        while speed_half_s <= 0.5 * half_s {
            let longer = smoothed(recorded, &segments, speed_half_s);
            if longer.left > most {
                break;
            }
            smooth = longer;
            speed_half_s *= 2.0;
        }
        let sensor_sd = smooth.left.max(rounding_sd);
        let tests = segments.iter().flat_map(|segment| tests(recorded, segment, half_s)).collect();
        let speed_sd = sensor_sd * smooth.slope;
        let slides = |ends: &[f64]| erf((0.5 * (ends[0] + ends[1])).abs() / (std::f64::consts::SQRT_2 * speed_sd));
        Self {
            slides: smooth.speed.windows(2).map(slides).collect(),
            position: smooth.position,
            speed: smooth.speed,
            speed_sd,
            sensor_sd,
            tests,
            support_s: 2.0 * half_s,
        }
    }
}

/// A smoothing may leave this many times what the shortest leaves: its bias is then less than the noise.
const SMOOTHING_BIAS: f64 = 1.25;

/// Rows of a parabola: three numbers from 64 rows have a quarter of a row's noise.
const MOST_IN_A_FIT: usize = 64;

/// Parabolas through the rows near each row.
struct Smoothed {
    position: Vec<f64>,
    speed: Vec<f64>,
    /// Standard deviation of a sample about its parabola, rad (m).
    left: f64,
    /// Largest standard deviation of a speed for samples of standard deviation one, 1/s.
    slope: f64,
}

fn smoothed(recorded: &Recorded, segments: &[Range<usize>], half_s: f64) -> Smoothed {
    let (mut position, mut speed) = (recorded.position.clone(), vec![0.0; recorded.rows()]);
    let (mut squares, mut count, mut slope) = (0.0, 0_usize, 0.0_f64);
    for segment in segments {
        for row in segment.clone() {
            let near = around(&recorded.t_s, segment, recorded.t_s[row], half_s);
            // The cost of a row may not grow with the sampling rate.
            let apart = near.len().div_ceil(MOST_IN_A_FIT);
            let of = |column: &[f64]| column[near.clone()].iter().step_by(apart).copied().collect::<Vec<f64>>();
            let Some(fit) = Parabola::over(&of(&recorded.t_s), recorded.t_s[row], half_s) else { continue };
            let values = of(&recorded.position);
            (position[row], speed[row]) = (fit.at(&values, 0), fit.at(&values, 1) / half_s);
            // A row is fitted by its own share of the parabola: what it leaves is less than its noise by that.
            let own = (1.0 - fit.variance(0)).max(0.1);
            squares += (recorded.position[row] - position[row]).powi(2) / own;
            count += 1;
            slope = slope.max(fit.variance(1).sqrt() / half_s);
        }
    }
    Smoothed { position, speed, left: (squares / count.max(1) as f64).sqrt(), slope }
}

/// Runs of rows without a gap and without rows behind one.
fn segments(recorded: &Recorded) -> Vec<Range<usize>> {
    let mut all: Vec<Range<usize>> = Vec::new();
    for row in 0..recorded.rows() {
        match all.last_mut().filter(|last| last.end == row && !recorded.after_gap[row]) {
            Some(last) if !recorded.skipped[row] => last.end = row + 1,
            _ if !recorded.skipped[row] => all.push(row..row + 1),
            _ => {}
        }
    }
    all
}

/// Rows of a segment within `half_s` of a time.
fn around(t_s: &[f64], segment: &Range<usize>, at_s: f64, half_s: f64) -> Range<usize> {
    let within = &t_s[segment.clone()];
    // A thousandth more, so that rounding of times drops no row.
    let reach_s = 1.001 * half_s;
    let from = within.partition_point(|t| *t < at_s - reach_s);
    let to = within.partition_point(|t| *t <= at_s + reach_s);
    segment.start + from..segment.start + to
}

/// Test functions side by side, each half over the next: less apart they tell the same noise twice.
fn tests(recorded: &Recorded, segment: &Range<usize>, half_s: f64) -> Vec<Test> {
    let t_s = &recorded.t_s;
    let mut all = Vec::new();
    let Some(last_s) = segment.clone().last().map(|row| t_s[row]) else { return all };
    let mut middle_s = t_s[segment.start] + half_s;
    while middle_s + half_s <= last_s + 1e-9 * half_s {
        let rows = around(t_s, segment, middle_s, half_s);
        if let Some(fit) = Parabola::over(&t_s[rows.clone()], middle_s, half_s).filter(|_| rows.len() > 2 * FEWEST_ROWS)
        {
            let acceleration: Vec<f64> =
                (0..rows.len()).map(|row| 2.0 * fit.weight(row, 2) / (half_s * half_s)).collect();
            let middle = rows.start + t_s[rows.clone()].partition_point(|t| *t < middle_s);
            let last = rows.end - 1;
            all.push(Test::new(recorded, rows, middle.min(last), acceleration));
        }
        middle_s += half_s;
    }
    all
}

/// The weight of an acceleration held over each interval, if these weights of the positions make the acceleration: the Peano
/// kernel k(s) = sum over t_j > s of c_j (t_j - s), which is straight between rows.
fn forces(acceleration: &[f64], t_s: &[f64]) -> Vec<f64> {
    let (mut kernel, mut slope) = (0.0, 0.0);
    let mut weights = vec![0.0; t_s.len() - 1];
    for row in (0..t_s.len() - 1).rev() {
        slope += acceleration[row + 1];
        let before = kernel + slope * (t_s[row + 1] - t_s[row]);
        weights[row] = 0.5 * (kernel + before) * (t_s[row + 1] - t_s[row]);
        kernel = before;
    }
    weights
}

/// A parabola through rows by least squares, as weights of the rows.
struct Parabola {
    inverse: Matrix3<f64>,
    basis: Vec<Vector3<f64>>,
}

impl Parabola {
    /// In (t - middle) / scale; none where the rows do not fix one.
    fn over(t_s: &[f64], middle_s: f64, scale_s: f64) -> Option<Self> {
        let basis: Vec<Vector3<f64>> = t_s
            .iter()
            .map(|t| {
                let at = (t - middle_s) / scale_s;
                Vector3::new(1.0, at, at * at)
            })
            .collect();
        if basis.len() < 4 {
            return None;
        }
        let normal: Matrix3<f64> = basis.iter().map(|one| one * one.transpose()).sum();
        Some(Self { inverse: normal.cholesky()?.inverse(), basis })
    }

    /// Weight of a row in a coefficient.
    fn weight(&self, row: usize, coefficient: usize) -> f64 {
        self.inverse.row(coefficient).transpose().dot(&self.basis[row])
    }

    /// A coefficient for values of the rows.
    fn at(&self, values: &[f64], coefficient: usize) -> f64 {
        // Against the first value: a position far from zero keeps its digits.
        let first = values[0];
        let sum: f64 =
            values.iter().enumerate().map(|(row, value)| self.weight(row, coefficient) * (value - first)).sum();
        if coefficient == 0 { first + sum } else { sum }
    }

    /// Variance of a coefficient for rows of variance one.
    fn variance(&self, coefficient: usize) -> f64 {
        self.inverse[(coefficient, coefficient)]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn uneven() -> Recorded {
        let t_s: Vec<f64> = (0..400).map(|row| f64::from(row) * 2e-3 + 4e-4 * f64::from(row % 3)).collect();
        let rows = t_s.len();
        let position = t_s.iter().map(|t| 100.0 + 3.0 * t - 2.0 * t * t).collect();
        Recorded {
            name: String::new(),
            commands: vec![plant::Command::default(); rows],
            skipped: vec![false; rows],
            after_gap: vec![false; rows],
            t_s,
            position,
        }
    }

    #[test]
    fn a_parabola_keeps_its_speed_and_acceleration_on_uneven_rows() {
        let recorded = uneven();
        let motion = Motion::new(&recorded, 0.0);
        for row in 0..recorded.rows() {
            assert!((motion.speed[row] - (3.0 - 4.0 * recorded.t_s[row])).abs() < 1e-8, "{row}");
        }
        for test in &motion.tests {
            let found: f64 = test
                .acceleration
                .iter()
                .zip(test.rows.clone())
                .map(|(weight, row)| weight * recorded.position[row])
                .sum();
            assert!((found + 4.0).abs() < 1e-6, "{found}");
            assert!((test.force.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        }
        assert!(motion.tests.len() > 12);
    }

    #[test]
    fn a_force_held_over_each_interval_is_found_exactly() {
        let mut recorded = uneven();
        // Position under an acceleration that jumps every row.
        let (mut x, mut w) = (0.3, -0.2);
        let held = |row: usize| ((row * 7919) % 13) as f64 - 6.0;
        for row in 0..recorded.rows() {
            recorded.position[row] = x;
            if row + 1 < recorded.rows() {
                let dt_s = recorded.t_s[row + 1] - recorded.t_s[row];
                x += w * dt_s + 0.5 * held(row) * dt_s * dt_s;
                w += held(row) * dt_s;
            }
        }
        for test in Motion::new(&recorded, 0.0).tests {
            let seen: f64 = test
                .acceleration
                .iter()
                .zip(test.rows.clone())
                .map(|(weight, row)| weight * recorded.position[row])
                .sum();
            let acted: f64 = test.force.iter().zip(test.rows.clone()).map(|(weight, row)| weight * held(row)).sum();
            assert!((seen - acted).abs() < 1e-8, "{seen} {acted}");
        }
    }
}
