//! Closed forms of a normal variable behind a dead zone.
//!
//! Dry friction over one step is the soft threshold S(x) = x - s beyond the level s, 0 within it: the implicit (proximal)
//! step of the set-valued law. A gap of backlash is the same function of the twist. For x ~ N(m, v) the mean, the slope
//! (the probability to be beyond) and the variance have closed forms, so that a belief passes a kink smoothly.

use statrs::function::erf::erfc;

/// Beyond this many standard deviations the other side of a kink has a probability below 1e-9.
const FAR: f64 = 6.0;

/// A normal variable behind the soft threshold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Thresholded {
    /// Mean of S(x).
    pub(crate) mean: f64,
    /// Probability to be beyond either threshold, which is d mean / d m.
    pub(crate) slope: f64,
    /// Variance of S(x) that the slope does not pass on: Var S(x) - slope^2 v.
    pub(crate) rest: f64,
}

/// S of N(`mean`, `sd`^2) with the levels `up` and `down` (both at least 0) in the two directions.
#[inline]
pub(crate) fn soft_threshold(mean: f64, sd: f64, up: f64, down: f64) -> Thresholded {
    if mean - up >= FAR * sd {
        return Thresholded { mean: mean - up, slope: 1.0, rest: 0.0 };
    }
    if -mean - down >= FAR * sd {
        return Thresholded { mean: mean + down, slope: 1.0, rest: 0.0 };
    }
    if up - mean >= FAR * sd && mean + down >= FAR * sd {
        return Thresholded { mean: 0.0, slope: 0.0, rest: 0.0 };
    }
    let (above, below) = ((mean - up) / sd, (-mean - down) / sd);
    let (p_above, f_above) = (probability(above), density(above));
    let (p_below, f_below) = (probability(below), density(below));
    let first = sd * ((above * p_above + f_above) - (below * p_below + f_below));
    let square = |x: f64, p: f64, f: f64| (x * x + 1.0) * p + x * f;
    let second = sd * sd * (square(above, p_above, f_above) + square(below, p_below, f_below));
    let slope = p_above + p_below;
    let rest = (second - first * first - slope * slope * sd * sd).max(0.0);
    Thresholded { mean: first, slope, rest }
}

fn probability(x: f64) -> f64 {
    0.5 * erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments by the midpoint rule over +-9 standard deviations.
    fn summed(mean: f64, sd: f64, up: f64, down: f64) -> (f64, f64) {
        let steps = 200_000;
        let (mut first, mut second) = (0.0, 0.0);
        for step in 0..steps {
            let z = -9.0 + 18.0 * (f64::from(step) + 0.5) / f64::from(steps);
            let x = mean + sd * z;
            let s = if x > up {
                x - up
            } else if x < -down {
                x + down
            } else {
                0.0
            };
            let weight = density(z) * 18.0 / f64::from(steps);
            first += weight * s;
            second += weight * s * s;
        }
        (first, second - first * first)
    }

    #[test]
    fn moments_are_those_of_the_sum() {
        for (mean, sd, up, down) in
            [(0.3, 1.0, 0.5, 0.2), (-2.0, 0.4, 1.0, 1.5), (0.0, 1.0, 0.0, 0.0), (0.1, 0.02, 0.1, 3.0)]
        {
            let found = soft_threshold(mean, sd, up, down);
            let (first, variance) = summed(mean, sd, up, down);
            assert!((found.mean - first).abs() < 1e-7 * sd, "{mean} {sd}: {} {first}", found.mean);
            let total = found.rest + found.slope * found.slope * sd * sd;
            assert!((total - variance).abs() < 1e-6 * sd * sd, "{mean} {sd}: {total} {variance}");
            let h = 1e-5 * sd;
            let slope =
                (soft_threshold(mean + h, sd, up, down).mean - soft_threshold(mean - h, sd, up, down).mean) / (2.0 * h);
            assert!((found.slope - slope).abs() < 1e-6, "{} {slope}", found.slope);
        }
    }
}
