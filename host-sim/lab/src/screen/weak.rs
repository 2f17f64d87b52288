//! The weak form: the torque balance times a smooth bump, integrated by parts, so that only the position is needed.
//!
//! J int phi'' q dt = int phi T dt. The bump phi(s) = (1 - s^2)^4 over a half-width W has integral one. The position is
//! the cubic through its neighbouring samples, whatever their spacing; torques are exact means over the cells.

use super::motion::Motion;

/// Gauss's five-point rule on [0, 1]: places and weights. The bump's second derivative times the cubic is of degree nine, for
/// which it is exact; with three points what a bump read depended on where it stood between two samples.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];
/// Integral of (1 - s^2)^4 over [-1, 1].
const AREA: f64 = 256.0 / 315.0;
/// Rows for one recording and width at most; longer recordings get a wider spacing, so that memory stays bounded.
const MAX_ROWS: f64 = 2500.0;
/// Rows are this many half-widths apart,
const SPACING: f64 = 0.5;
/// and where they would have to be further apart than this many, they stand in groups of three with that spacing and a wide
/// one between: what neighbours do not share is noise, and only neighbours tell it.
const APART: f64 = 0.6;

/// One test function on one recording.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Centre, s.
    pub centre_s: f64,
    /// First cell under the bump.
    pub first_cell: usize,
    /// Weight of each cell's mean.
    pub cell: Vec<f64>,
    /// First sample that the second derivative reads.
    pub first_sample: usize,
    /// Weight of each sample in the second derivative.
    pub second: Vec<f64>,
}

impl Row {
    /// Weighted mean of something given by its cell means.
    pub(crate) fn mean(&self, cells: &[f64]) -> f64 {
        dot(&self.cell, &cells[self.first_cell..self.first_cell + self.cell.len()])
    }

    /// Weighted mean of the acceleration of something sampled.
    pub(crate) fn acceleration(&self, samples: &[f64]) -> f64 {
        let under = &samples[self.first_sample..self.first_sample + self.second.len()];
        let origin = under[0];
        self.second.iter().zip(under).map(|(weight, value)| weight * (value - origin)).sum()
    }

    /// Standard deviation of the acceleration under unit noise of the samples.
    pub(crate) fn noise_gain(&self) -> f64 {
        self.second.iter().map(|weight| weight * weight).sum::<f64>().sqrt()
    }
}

/// Sum of products. Four sums side by side: the order of a single one forbids the processor to take several at a time, and
/// half of a search is spent here.
fn dot(weights: &[f64], values: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (fours, rest) = (weights.chunks_exact(4), weights.chunks_exact(4).remainder());
    let others = values.chunks_exact(4);
    let tail: f64 = rest.iter().zip(others.remainder()).map(|(weight, value)| weight * value).sum();
    for (weight, value) in fours.zip(others) {
        for lane in 0..4 {
            sums[lane] += weight[lane] * value[lane];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + tail
}

fn primitive(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    let s2 = s * s;
    s * (1.0 + s2 * (-4.0 / 3.0 + s2 * (6.0 / 5.0 + s2 * (-4.0 / 7.0 + s2 / 9.0)))) / AREA
}

fn second_derivative(s: f64) -> f64 {
    let inside = 1.0 - s * s;
    if inside <= 0.0 { 0.0 } else { (48.0 * s * s * inside * inside - 8.0 * inside.powi(3)) / AREA }
}

/// Rows of one half-width on one recording; none touches rest, a gap, or the first `settle_s`.
pub(crate) fn rows(motion: &Motion, half_width_s: f64, settle_s: f64) -> Vec<Row> {
    let t_s = &motion.t_s;
    let (first_s, last_s) = (t_s[0] + settle_s, t_s[t_s.len() - 1]);
    let (near_s, even_s) = (SPACING * half_width_s, (last_s - first_s) / MAX_ROWS);
    let grouped = even_s > APART * half_width_s;
    let after_s = |number: u32| match grouped {
        true => f64::from(number / 3 * 3) * even_s + f64::from(number % 3) * near_s,
        false => f64::from(number) * near_s.max(even_s),
    };
    let mut rows = Vec::new();
    let mut from = 0;
    for number in 0.. {
        let centre_s = first_s + half_width_s + after_s(number);
        if centre_s + half_width_s > last_s {
            break;
        }
        while t_s[from + 1] <= centre_s - half_width_s {
            from += 1;
        }
        let mut to = from;
        while t_s[to] < centre_s + half_width_s {
            to += 1;
        }
        let usable = to - from >= 8
            && from >= 1
            && to + 1 < t_s.len()
            && !(from - 1..=to).any(|cell| motion.broken[cell])
            && !(from..to).any(|cell| motion.at_rest[cell]);
        if usable {
            rows.push(row(t_s, centre_s, half_width_s, from, to));
        }
    }
    rows
}

/// The row over cells `from..to`; one sample more on each side feeds the cubic.
fn row(t_s: &[f64], centre_s: f64, half_width_s: f64, from: usize, to: usize) -> Row {
    let mut cell = Vec::with_capacity(to - from);
    let mut second = vec![0.0; to - from + 3];
    for index in from..to {
        let (left_s, right_s) = (t_s[index], t_s[index + 1]);
        cell.push(primitive((right_s - centre_s) / half_width_s) - primitive((left_s - centre_s) / half_width_s));
        let nodes = &t_s[index - 1..index + 3];
        // A bump that ends within a cell is no polynomial over all of it.
        let (from_s, to_s) = (left_s.max(centre_s - half_width_s), right_s.min(centre_s + half_width_s));
        for (place, weight) in GAUSS {
            let at_s = from_s + place * (to_s - from_s);
            let bump = second_derivative((at_s - centre_s) / half_width_s) * weight * (to_s - from_s)
                / (half_width_s * half_width_s * half_width_s);
            for (offset, lagrange) in cubic(nodes, at_s).into_iter().enumerate() {
                second[index - from + offset] += bump * lagrange;
            }
        }
    }
    Row { centre_s, first_cell: from, cell, first_sample: from - 1, second }
}

/// Lagrange's weights of four nodes at a time.
fn cubic(nodes: &[f64], at_s: f64) -> [f64; 4] {
    let mut weights = [1.0; 4];
    for i in 0..4 {
        for j in 0..4 {
            if i != j {
                weights[i] *= (at_s - nodes[j]) / (nodes[i] - nodes[j]);
            }
        }
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constants, lines, parabolas and cubics have the acceleration they have, wherever the bump stands between the samples.
    #[test]
    fn the_acceleration_of_a_cubic_is_exact_at_any_sampling() {
        for period_s in [0.0005, 0.001, 0.005, 0.05] {
            let t_s: Vec<f64> = (0..40).map(|row| f64::from(row) * period_s).collect();
            for part in [0.0, 0.13, 0.5, 0.77] {
                let half_width_s = 5.3 * period_s;
                let centre_s = (15.0 + part) * period_s;
                let from = ((centre_s - half_width_s) / period_s) as usize;
                let to = ((centre_s + half_width_s) / period_s).ceil() as usize;
                let row = row(&t_s, centre_s, half_width_s, from, to);
                let cubic = |t: f64| 3.0 - 2.0 * t + 40.0 * t * t + 7.0 * t * t * t;
                let samples: Vec<f64> = t_s.iter().map(|&t| cubic(t)).collect();
                let found = row.acceleration(&samples);
                let truth = 80.0 + 42.0 * centre_s;
                assert!((found / truth - 1.0).abs() < 1e-8, "{period_s} {part}: {found}, not {truth}");
            }
        }
    }
}
