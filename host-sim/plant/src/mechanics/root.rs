//! Where a function changes sign.

/// Where `f` changes sign between two points whose values are given, to a part in 1e14 of the farther one. Chandrupatla's
/// method keeps the bracket: inverse quadratic interpolation where the last three points allow it, bisection where not
/// (Advances in Engineering Software 28, 145, 1997); begun with the line between the two points, for what is nearly straight.
pub(super) fn root(f: impl Fn(f64) -> f64, low: (f64, f64), high: (f64, f64)) -> f64 {
    let tolerance = 1e-14 * high.0.abs() + 1e-18;
    let (mut near, mut far) = if low.1.abs() < high.1.abs() { (low, high) } else { (high, low) };
    let mut part = near.1 / (near.1 - far.1);
    for _ in 0..80 {
        let least = tolerance / (far.0 - near.0).abs();
        if near.1 == 0.0 || least > 0.5 {
            break;
        }
        // Not `clamp`, which panics where a wild machine has led to no number.
        let x = near.0 + part.max(least).min(1.0 - least) * (far.0 - near.0);
        let new = (x, f(x));
        let old = if (new.1 < 0.0) == (near.1 < 0.0) { near } else { std::mem::replace(&mut far, near) };
        near = new;
        part = interpolated(near, far, old).unwrap_or(0.5);
    }
    if near.1.abs() < far.1.abs() { near.0 } else { far.0 }
}

/// Where the parabola through three points, as a function of the value, is zero, as a part of the way from `near` to `far`;
/// none where it is not monotone between them.
fn interpolated(near: (f64, f64), far: (f64, f64), old: (f64, f64)) -> Option<f64> {
    let along = (near.0 - far.0) / (old.0 - far.0);
    let up = (near.1 - far.1) / (old.1 - far.1);
    let monotone = up * up < along && (1.0 - up) * (1.0 - up) < 1.0 - along;
    monotone.then(|| {
        near.1 / (far.1 - near.1) * (old.1 / (far.1 - old.1))
            + (old.0 - near.0) / (far.0 - near.0) * (near.1 / (old.1 - near.1)) * (far.1 / (old.1 - far.1))
    })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn roots_are_found_in_few_evaluations_to_the_last_digits() {
        type Case = (&'static str, fn(f64) -> f64, f64, u32);
        let cases: [Case; 6] = [
            ("line", |x| 3.0 * x - 1.2, 0.4, 4),
            ("parabola", |x| x * x - 0.09, 0.3, 9),
            ("cosine", |x| (40.0 * x).cos(), std::f64::consts::FRAC_PI_2 / 40.0, 10),
            ("ninth power", |x| x.powi(9) - 1e-9, 0.1, 22),
            ("step", |x| if x < 0.37 { 1.0 } else { -1e-3 }, 0.37, 60),
            ("at the end", |x| x - 1.0, 1.0, 1),
        ];
        for (name, f, at, most) in cases {
            let count = Cell::new(0);
            let f = |x: f64| {
                count.set(count.get() + 1);
                f(x)
            };
            let to = if name == "cosine" { 0.06 } else { 1.0 };
            let found = root(f, (0.0, f(0.0)), (to, f(to)));
            println!("{name}: {:e} off after {}", found - at, count.get() - 2);
            assert!((found - at).abs() < 2e-14 && count.get() - 2 <= most, "{name}: {found} {}", count.get() - 2);
        }
    }

    #[test]
    fn what_is_no_number_has_a_root_that_is_none_and_no_panic() {
        assert!(root(|_| f64::NAN, (0.0, 1.0), (f64::NAN, -1.0)).is_nan());
        root(|_| f64::NAN, (0.0, f64::NAN), (1.0, f64::NAN));
        root(|x| x, (0.0, -1.0), (f64::INFINITY, f64::INFINITY));
    }

    #[test]
    fn a_tiny_step_is_bracketed_too() {
        let at = 3.3e-12;
        let found = root(|x| 1e-9 * (at - x), (0.0, 1e-9 * at), (1e-11, 1e-9 * (at - 1e-11)));
        assert!((found - at).abs() < 2e-18, "{found:e}");
    }
}
