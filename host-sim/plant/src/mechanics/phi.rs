//! Integrals of exponentials that stay accurate when exponents are small.

/// Below this the series of twelve terms is exact to the last bit and the closed form loses digits.
const SERIES_BELOW: f64 = 0.1;

/// Up to this exponent the joint series of twenty terms is exact to the last bit.
const SERIES_CONVERGES: f64 = 0.5;

/// phi1(z) = (1 - exp(-z)) / z, the mean of exp(-z u) over u in 0..1.
#[inline]
pub(crate) fn phi1(z: f64) -> f64 {
    if z == 0.0 { 1.0 } else { -(-z).exp_m1() / z }
}

/// phi2(z) = (1 - phi1(z)) / z, the integral of (1 - u) exp(-z u) over u in 0..1, with phi1(z) known.
#[inline]
fn phi2(z: f64, phi1: f64) -> f64 {
    if z < SERIES_BELOW {
        // Sum of (-z)^n / (n + 2)!, Horner from the far end; the first term left out is 1e-17.
        let mut sum = 1.0;
        for n in (3..=11).rev() {
            sum = 1.0 - z * sum / f64::from(n);
        }
        0.5 * sum
    } else {
        (1.0 - phi1) / z
    }
}

/// phi1 and phi2 of z and of 2 z at the price of one exponential: a decaying field and its square.
#[inline]
pub(crate) fn field_moments(z: f64) -> [(f64, f64); 2] {
    if z == 0.0 {
        return [(1.0, 0.5); 2];
    }
    let gone = -(-z).exp_m1();
    let single = gone / z;
    // 1 - x^2 = (1 - x)(1 + x)
    let double = single * (1.0 - 0.5 * gone);
    [(single, phi2(z, single)), (double, phi2(2.0 * z, double))]
}

/// Speed and distance gained in a time h by a unit of acceleration that decays at `a / h` against a viscous rate `b / h`:
/// w = h first, theta = h^2 second. Both exponents are not negative, of any size.
#[inline]
pub(crate) fn moments(a: f64, b: f64) -> (f64, f64) {
    if b == 0.0 {
        if a == 0.0 {
            return (1.0, 0.5);
        }
        let first = phi1(a);
        return (first, phi2(a, first));
    }
    if a == 0.0 {
        let first = phi1(b);
        return (first, phi2(b, first));
    }
    let larger = a.max(b);
    if larger > SERIES_CONVERGES {
        // Divided differences of exp(-z) over (a, b) and (0, a, b); the larger exponent divides, which loses no digits.
        let first = (-a.min(b)).exp() * phi1((a - b).abs());
        let second = (phi1(a.min(b)) - first) / larger;
        return (first, second);
    }
    // Divided differences of exp(-z) as series in the complete homogeneous polynomials h_n(a, b), with
    // h_n = a^n + b h_(n-1): first over (a, b), second over (0, a, b).
    let (mut power, mut homogeneous, mut inverse_factorial, mut sign) = (1.0, 1.0, 1.0, 1.0);
    let (mut first, mut second) = (1.0, 0.5);
    for n in 1..=20 {
        power *= a;
        homogeneous = power + b * homogeneous;
        let n = f64::from(n);
        inverse_factorial /= n + 1.0;
        sign = -sign;
        let term = sign * homogeneous * inverse_factorial;
        first += term;
        second += term / (n + 2.0);
        if term.abs() < 1e-18 {
            break;
        }
    }
    (first, second)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gauss-Legendre on 64 panels of the defining integrals.
    fn integral(f: impl Fn(f64) -> f64) -> f64 {
        let panels = 64;
        let node = (3.0_f64 / 5.0).sqrt() / 2.0;
        (0..panels)
            .map(|panel| {
                let mid = (f64::from(panel) + 0.5) / f64::from(panels);
                let d = node / f64::from(panels);
                (5.0 * f(mid - d) + 8.0 * f(mid) + 5.0 * f(mid + d)) / 18.0 / f64::from(panels)
            })
            .sum()
    }

    #[test]
    fn phi_functions_equal_their_integrals() {
        for z in [0.0, 1e-9, 1e-3, 0.099_999, 0.100_001, 0.3, 1.0, 5.0] {
            assert!((phi1(z) - integral(|u| (-z * u).exp())).abs() < 1e-11, "phi1({z})");
            assert!((phi2(z, phi1(z)) - integral(|u| (1.0 - u) * (-z * u).exp())).abs() < 1e-11, "phi2({z})");
        }
    }

    #[test]
    fn field_moments_are_the_phi_functions() {
        for z in [0.0, 1e-9, 1e-3, 0.06, 0.3, 5.0] {
            for (factor, (first, second)) in [1.0, 2.0].into_iter().zip(field_moments(z)) {
                let expected = phi1(factor * z);
                assert!((first - expected).abs() < 1e-15 && (second - phi2(factor * z, expected)).abs() < 1e-14, "{z}");
            }
        }
    }

    /// Far beyond what the quadrature resolves: the speed settles at the push over the drag, the way follows it.
    #[test]
    fn stiff_moments_are_their_limits() {
        for (a, b) in [(1e3, 1e9), (1e9, 1e3), (1e9, 1e-3), (1e-3, 1e9), (1e300, 1e300)] {
            let (first, second) = moments(a, b);
            let exact = if a.max(b) > 1e200 { 0.0 } else { (-a.min(b)).exp() / (a.max(b) - a.min(b)) };
            assert!((first - exact).abs() <= 1e-15 * exact.max(1e-12), "first({a}, {b}) = {first:e}, not {exact:e}");
            let exact = if a.max(b) > 1e200 { 0.0 } else { (phi1(a.min(b)) - exact) / a.max(b) };
            assert!((second - exact).abs() <= 1e-12 * exact, "second({a}, {b}) = {second:e}, not {exact:e}");
        }
    }

    #[test]
    fn moments_equal_their_integrals() {
        for a in [0.0, 1e-6, 0.2, 0.999, 5.0] {
            for b in [0.0, 1e-7, 0.2, 0.200_000_1, 0.501, 1.0, 5.000_000_1, 9.0] {
                let (first, second) = moments(a, b);
                let speed = |u: f64| (-b * (1.0 - u) - a * u).exp();
                assert!((first - integral(speed)).abs() < 1e-11, "first({a}, {b})");
                let distance = |u: f64| (-a * u).exp() * (1.0 - u) * phi1(b * (1.0 - u));
                assert!((second - integral(distance)).abs() < 1e-11, "second({a}, {b})");
            }
        }
    }
}
