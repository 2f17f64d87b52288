//! All zeros of a smooth function of frequency: a graded scan, then bisection.

/// The frequencies a scan visits, rad/s: a constant ratio at first, so that slow crossings are seen, then a constant
/// step that resolves the fastest phase.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scan {
    /// First frequency, above 0.
    pub from_rad_s: f64,
    /// Last frequency.
    pub to_rad_s: f64,
    /// Largest step.
    pub step_rad_s: f64,
}

/// Growth of the step while it is below the constant one.
const RATIO: f64 = 0.03;
/// Phase of the fastest term between two frequencies of a scan, rad.
const PHASE_STEP_RAD: f64 = 0.05;

impl Scan {
    /// From (almost) zero up to `to_rad_s` for terms that turn `delay_s` rad for each rad/s.
    pub fn new(to_rad_s: f64, delay_s: f64) -> Self {
        let step_rad_s = PHASE_STEP_RAD / delay_s;
        Self { from_rad_s: 1e-7 * to_rad_s.min(step_rad_s), to_rad_s, step_rad_s }
    }

    /// The frequencies.
    pub fn frequencies(self) -> impl Iterator<Item = f64> {
        let next = move |&w: &f64| (w < self.to_rad_s).then(|| (w + self.step_rad_s.min(RATIO * w)).min(self.to_rad_s));
        std::iter::successors(Some(self.from_rad_s), next)
    }
}

/// A frequency at which a function changes sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Zero {
    /// Where, rad/s.
    pub omega_rad_s: f64,
    /// From below zero to above, with frequency.
    pub rising: bool,
}

/// Zeros of `f` over the scan, in order. A pair that lies between two neighbouring frequencies is found at the
/// extremum between them.
pub(super) fn zeros(f: impl Fn(f64) -> f64, scan: Scan) -> Vec<Zero> {
    let mut found = Vec::new();
    let mut before: Option<(f64, f64)> = None;
    let mut last: Option<(f64, f64)> = None;
    for w in scan.frequencies() {
        let here = (w, f(w));
        if let Some(last) = last {
            if (last.1 < 0.0) != (here.1 < 0.0) {
                found.push(Zero { omega_rad_s: bisect(&f, last, here), rising: last.1 < 0.0 });
            } else if let Some(before) = before
                && last.1.abs() < before.1.abs()
                && last.1.abs() < here.1.abs()
                && (before.1 < 0.0) == (last.1 < 0.0)
            {
                found.extend(double_zero(&f, before, here));
            }
        }
        (before, last) = (last, Some(here));
    }
    found
}

/// The two zeros at an extremum between `a` and `b` that just reaches over zero, or none.
fn double_zero(f: impl Fn(f64) -> f64, a: (f64, f64), b: (f64, f64)) -> Vec<Zero> {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let sign = a.1.signum();
    let (mut low, mut high) = (a.0, b.0);
    for _ in 0..60 {
        let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (at_left, at_right) = (sign * f(left), sign * f(right));
        for (w, value) in [(left, at_left), (right, at_right)] {
            if value < 0.0 {
                let rising = sign < 0.0;
                return vec![
                    Zero { omega_rad_s: bisect(&f, a, (w, sign * value)), rising },
                    Zero { omega_rad_s: bisect(&f, (w, sign * value), b), rising: !rising },
                ];
            }
        }
        if at_left < at_right { high = right } else { low = left }
    }
    Vec::new()
}

/// The zero between two points of opposite sign, to the last bits.
fn bisect(f: impl Fn(f64) -> f64, a: (f64, f64), b: (f64, f64)) -> f64 {
    let (mut low, mut high) = (a.0, b.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (f(middle) < 0.0) == (a.1 < 0.0) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_every_zero_and_its_direction() {
        let found = zeros(f64::sin, Scan::new(100.0, 1.0));
        assert_eq!(found.len(), 31);
        for (k, zero) in (1_u32..).zip(&found) {
            assert!((zero.omega_rad_s - f64::from(k) * std::f64::consts::PI).abs() < 1e-12);
            assert_eq!(zero.rising, k % 2 == 0);
        }
    }

    #[test]
    fn finds_a_close_pair_and_none_where_the_curve_stays_clear() {
        let parabola = |clear: f64| move |w: f64| (w - 3.0).powi(2) + clear;
        let pair = zeros(parabola(-1e-8), Scan::new(10.0, 1.0));
        assert_eq!(pair.len(), 2);
        assert!((pair[0].omega_rad_s - 2.9999).abs() < 1e-9 && (pair[1].omega_rad_s - 3.0001).abs() < 1e-9);
        assert!(zeros(parabola(1e-8), Scan::new(10.0, 1.0)).is_empty());
    }
}
