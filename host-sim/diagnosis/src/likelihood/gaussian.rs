//! Closed forms of a normal variable behind a dead zone.
//!
//! Dry friction over one step is the soft threshold S(x) = x - s beyond the level s, 0 within it: the implicit (proximal)
//! step of the set-valued law. Each side of a gap of backlash is half of it. For x ~ N(m, v) the mean, the slope
//! (the probability to be beyond) and the variance have closed forms, so that a belief passes a kink smoothly.
//!
//! Torques that are larger than the friction turn the rotor round within the step, and the friction turns with it: the
//! proximal step lets it pull the old way to the step's end. Under constant torques the turn has a closed form too, which is
//! linear in the free speed.

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
    /// d mean / d push at the same m: of a threshold that does not know what pushes, 0.
    pub(crate) per_push: f64,
    /// Variance of S(x) that the slope does not pass on: Var S(x) - slope^2 v.
    pub(crate) rest: f64,
}

/// The speed behind a step of dry friction that takes `up` (`down`) of a speed upwards (downwards). `free` is the mean of the
/// speed without it, with standard deviation `sd`; `push` what the torques add to it within the step.
#[inline]
pub(crate) fn dry_friction(free: f64, sd: f64, push: f64, up: f64, down: f64) -> Thresholded {
    if push < -down {
        turned(free, sd, push, up, down)
    } else if push > up {
        let mirrored = turned(-free, sd, -push, down, up);
        Thresholded { mean: -mirrored.mean, ..mirrored }
    } else {
        soft_threshold(free, sd, up, down)
    }
}

/// Where the push is downwards and beyond what friction holds: a speed that is still upwards after it loses `up`; one that was
/// downwards before it loses `down`; between them the rotor turns at the time at which push and friction have used its speed up.
#[inline]
fn turned(mean: f64, sd: f64, push: f64, up: f64, down: f64) -> Thresholded {
    let both = up - push;
    let share = (-push - down) / both;
    let share_per_push = -(up + down) / (both * both);
    if mean - up >= FAR * sd {
        return Thresholded { mean: mean - up, slope: 1.0, per_push: 0.0, rest: 0.0 };
    }
    if push - mean >= FAR * sd {
        return Thresholded { mean: mean + down, slope: 1.0, per_push: 0.0, rest: 0.0 };
    }
    let below = up - mean;
    if below >= FAR * sd && mean - push >= FAR * sd {
        return Thresholded { mean: -share * below, slope: share, per_push: -share_per_push * below, rest: 0.0 };
    }
    // T(x) = (x - up)+ - share (up - x)+ - (1 - share) (push - x)+, whose pieces meet at up and push.
    let (high, low) = (below / sd, (push - mean) / sd);
    let ((p_high, f_high), (p_low, f_low)) = (below_and_at(high), below_and_at(low));
    let under_up = sd * (high * p_high + f_high);
    let under_push = sd * (low * p_low + f_low);
    let over_up = under_up - below;
    let first = over_up - share * under_up - (1.0 - share) * under_push;
    // E (x - c)^2 below the knot at z standard deviations.
    let square_below = |c: f64, z: f64, p: f64, f: f64| {
        let m = mean - c;
        m * m * p - 2.0 * m * sd * f + sd * sd * (p - z * f)
    };
    let under = square_below(up, high, p_high, f_high);
    let second = below * below + sd * sd - under
        + share * share * (under - square_below(up, low, p_low, f_low))
        + square_below(-down, low, p_low, f_low);
    let slope = 1.0 - p_high + share * (p_high - p_low) + p_low;
    let per_push = -share_per_push * (under_up - under_push) - (1.0 - share) * p_low;
    let rest = (second - first * first - slope * slope * sd * sd).max(0.0);
    Thresholded { mean: first, slope, per_push, rest }
}

/// S of N(`mean`, `sd`^2) with the levels `up` and `down` (both at least 0) in the two directions.
#[inline]
fn soft_threshold(mean: f64, sd: f64, up: f64, down: f64) -> Thresholded {
    if mean - up >= FAR * sd {
        return Thresholded { mean: mean - up, slope: 1.0, per_push: 0.0, rest: 0.0 };
    }
    if -mean - down >= FAR * sd {
        return Thresholded { mean: mean + down, slope: 1.0, per_push: 0.0, rest: 0.0 };
    }
    if up - mean >= FAR * sd && mean + down >= FAR * sd {
        return Thresholded { mean: 0.0, slope: 0.0, per_push: 0.0, rest: 0.0 };
    }
    let (above, below) = ((mean - up) / sd, (-mean - down) / sd);
    let ((p_above, f_above), (p_below, f_below)) = (below_and_at(above), below_and_at(below));
    let first = sd * ((above * p_above + f_above) - (below * p_below + f_below));
    let square = |x: f64, p: f64, f: f64| (x * x + 1.0) * p + x * f;
    let second = sd * sd * (square(above, p_above, f_above) + square(below, p_below, f_below));
    let slope = p_above + p_below;
    let rest = (second - first * first - slope * slope * sd * sd).max(0.0);
    Thresholded { mean: first, slope, per_push: 0.0, rest }
}

/// Mean of the part above 0 of N(`mean`, `sd`^2), and the probability to be there, which is its slope over the mean.
#[inline]
pub(crate) fn beyond(mean: f64, sd: f64) -> (f64, f64) {
    if mean >= FAR * sd {
        return (mean, 1.0);
    }
    if -mean >= FAR * sd {
        return (0.0, 0.0);
    }
    let (probability, density) = below_and_at(mean / sd);
    (mean * probability + sd * density, probability)
}

/// Probability of a standard normal variable to be below x, and its density there.
#[inline]
fn below_and_at(x: f64) -> (f64, f64) {
    if x >= FAR {
        (1.0, 0.0)
    } else if x <= -FAR {
        (0.0, 0.0)
    } else {
        (0.5 * erfc(-x * std::f64::consts::FRAC_1_SQRT_2), density(x))
    }
}

fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments by the midpoint rule over +-9 standard deviations.
    fn summed(mean: f64, sd: f64, of: impl Fn(f64) -> f64) -> (f64, f64) {
        let steps = 200_000;
        let (mut first, mut second) = (0.0, 0.0);
        for step in 0..steps {
            let z = -9.0 + 18.0 * (f64::from(step) + 0.5) / f64::from(steps);
            let s = of(mean + sd * z);
            let weight = density(z) * 18.0 / f64::from(steps);
            first += weight * s;
            second += weight * s * s;
        }
        (first, second - first * first)
    }

    fn check(name: &str, sd: f64, found: &Thresholded, (first, variance): (f64, f64)) {
        assert!((found.mean - first).abs() < 1e-7 * sd, "{name}: {} {first}", found.mean);
        let total = found.rest + found.slope * found.slope * sd * sd;
        assert!((total - variance).abs() < 1e-6 * sd * sd, "{name}: {total} {variance}");
    }

    #[test]
    fn moments_are_those_of_the_sum() {
        for (mean, sd, up, down) in
            [(0.3, 1.0, 0.5, 0.2), (-2.0, 0.4, 1.0, 1.5), (0.0, 1.0, 0.0, 0.0), (0.1, 0.02, 0.1, 3.0)]
        {
            let found = soft_threshold(mean, sd, up, down);
            let threshold = |x: f64| (x - up).max(0.0) - (-x - down).max(0.0);
            check(&format!("{mean} {sd}"), sd, &found, summed(mean, sd, threshold));
            let h = 1e-5 * sd;
            let slope =
                (soft_threshold(mean + h, sd, up, down).mean - soft_threshold(mean - h, sd, up, down).mean) / (2.0 * h);
            assert!((found.slope - slope).abs() < 1e-6, "{} {slope}", found.slope);
        }
    }

    #[test]
    fn the_part_beyond_a_level_is_its_sum() {
        for (mean, sd) in [(0.3, 1.0), (-2.0, 0.4), (0.0, 1e-3), (7.0, 1.0), (-7.0, 1.0)] {
            let (found, slope) = beyond(mean, sd);
            let (expected, _) = summed(mean, sd, |x| x.max(0.0));
            let (probability, _) = summed(mean, sd, |x| f64::from(x > 0.0));
            assert!((found - expected).abs() < 1e-7 * sd, "{mean} {sd}: {found} {expected}");
            assert!((slope - probability).abs() < 1e-4, "{mean} {sd}: {slope} {probability}");
        }
    }

    /// The speed after a step of length 1 under a constant push and dry friction, by ten thousand small steps.
    fn stepped(speed: f64, push: f64, up: f64, down: f64) -> f64 {
        let steps = 10_000.0;
        let mut speed = speed;
        for _ in 0..10_000 {
            let free = speed + push / steps;
            speed = (free - up / steps).max(0.0) - (-free - down / steps).max(0.0);
        }
        speed
    }

    #[test]
    fn a_turn_within_a_step_is_that_of_many_small_steps() {
        for (speed, push, up, down) in [
            (0.5, -2.0, 0.7, 0.4),
            (-0.5, 2.0, 0.7, 0.4),
            (1.5, -2.0, 0.7, 0.4),
            (0.5, -0.6, 0.7, 0.7),
            (0.1, 1.0, 0.2, 0.3),
        ] {
            let found = dry_friction(speed + push, 1e-9, push, up, down).mean;
            let expected = stepped(speed, push, up, down);
            assert!((found - expected).abs() < 1e-3, "{speed} {push}: {found} {expected}");
        }
    }

    #[test]
    fn a_belief_turns_as_the_sum_of_its_speeds_does() {
        for (mean, sd, push, up, down) in [
            (-1.0, 0.4, -1.5, 0.5, 0.3),
            (0.2, 1.0, 2.0, 0.5, 0.3),
            (-1.6, 0.05, -1.5, 0.5, 0.3),
            (0.4, 0.02, -1.5, 0.5, 0.3),
            (-0.5, 0.02, -1.5, 0.5, 0.3),
        ] {
            let found = dry_friction(mean, sd, push, up, down);
            let alone = |x: f64| dry_friction(x, 1e-12, push, up, down).mean;
            check(&format!("{mean} {sd} {push}"), sd, &found, summed(mean, sd, alone));
            let h = 1e-6;
            let at = |mean: f64, push: f64| dry_friction(mean, sd, push, up, down).mean;
            let slope = (at(mean + h, push) - at(mean - h, push)) / (2.0 * h);
            let per_push = (at(mean, push + h) - at(mean, push - h)) / (2.0 * h);
            assert!((found.slope - slope).abs() < 1e-5, "{mean}: {} {slope}", found.slope);
            assert!((found.per_push - per_push).abs() < 1e-5, "{mean}: {} {per_push}", found.per_push);
        }
    }
}
