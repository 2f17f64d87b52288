//! The few functions core lacks, in single precision with stated bounds.
//!
//! `libm::expf` and `libm::sinf` compute in software doubles on a Cortex-M4F; these do not.

/// A value held within `low..=high`, and whether it was outside. NaN is outside and becomes 0.
///
/// `f32::clamp` panics on a reversed pair of bounds and `max().min()` turns NaN into the lower bound, which would be
/// full negative torque.
pub(crate) fn limit(value: f32, low: f32, high: f32) -> (f32, Bounded) {
    if value.is_nan() {
        (0.0, Bounded::NotFinite)
    } else if value > high {
        (high, Bounded::Above)
    } else if value < low {
        (low, Bounded::Below)
    } else {
        (value, Bounded::Inside)
    }
}

/// What [`limit`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bounded {
    Inside,
    Above,
    Below,
    NotFinite,
}

/// Square root, correctly rounded; 0 for negative values and NaN.
pub(crate) fn sqrt(value: f32) -> f32 {
    if value > 0.0 { libm::sqrtf(value) } else { 0.0 }
}

/// e^x within 2 ulp for -87..88; 0 below, the largest finite value above, 0 for NaN.
pub(crate) fn exp(x: f32) -> f32 {
    if x.is_nan() || x < -87.0 {
        return 0.0;
    }
    if x > 88.0 {
        return f32::MAX;
    }
    // x = k ln 2 + r with |r| <= ln 2 / 2; ln 2 in two parts, the first with trailing zeros so that k times it is exact.
    const LN2_HIGH: f32 = 0.693_359_4;
    const LN2_LOW: f32 = -2.121_944_4e-4;
    let scaled = x * core::f32::consts::LOG2_E;
    let k = (scaled + if scaled < 0.0 { -0.5 } else { 0.5 }) as i32;
    let r = (x - k as f32 * LN2_HIGH) - k as f32 * LN2_LOW;
    // Taylor to the seventh power: the first term left out is 5e-9 at |r| = 0.347, below rounding.
    let p = 1.0 / 5_040.0;
    let p = p * r + 1.0 / 720.0;
    let p = p * r + 1.0 / 120.0;
    let p = p * r + 1.0 / 24.0;
    let p = p * r + 1.0 / 6.0;
    let p = p * r + 0.5;
    let p = p * r + 1.0;
    let p = p * r + 1.0;
    p * f32::from_bits(((k + 127) as u32) << 23)
}

/// sin of a phase in units of 2^-32 turn, within 1e-6; a phase that wraps is exact, so a long chirp does not drift.
pub(crate) fn sin_phase(phase: u32) -> f32 {
    // Fold to a quarter turn; the sign comes from the upper half.
    let half = phase & 0x7fff_ffff;
    let folded = if half > 0x4000_0000 { 0x8000_0000 - half } else { half };
    let x = folded as f32 * (core::f32::consts::FRAC_PI_2 / 1_073_741_824.0);
    let x2 = x * x;
    // Taylor to x^11: the first term left out is 6e-8 at a quarter turn.
    let p = -1.0 / 39_916_800.0;
    let p = p * x2 + 1.0 / 362_880.0;
    let p = p * x2 - 1.0 / 5_040.0;
    let p = p * x2 + 1.0 / 120.0;
    let p = p * x2 - 1.0 / 6.0;
    let sine = x + x * x2 * p;
    if phase >= 0x8000_0000 { -sine } else { sine }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn exp_is_within_two_ulp_on_a_dense_grid() {
        let mut worst: f64 = 0.0;
        for i in -870_000..=880_000 {
            let x = i as f32 * 1e-4;
            let exact = f64::from(x).exp();
            worst = worst.max((f64::from(exp(x)) - exact).abs() / exact);
        }
        assert!(worst < 2.4e-7, "worst relative error {worst:e}");
    }

    #[test]
    fn sine_is_within_a_millionth() {
        for i in 0..1_000_000_u32 {
            let phase = i.wrapping_mul(4_294_967);
            let exact = (f64::from(phase) / 4_294_967_296.0 * core::f64::consts::TAU).sin();
            assert!((f64::from(sin_phase(phase)) - exact).abs() < 1e-6, "{phase}");
        }
    }

    proptest! {
        #[test]
        fn every_bit_pattern_gives_a_finite_value(bits: u32) {
            let x = f32::from_bits(bits);
            prop_assert!(exp(x).is_finite());
            prop_assert!(sqrt(x.min(f32::MAX)).is_finite());
            let (y, _) = limit(x, -3.0, 2.0);
            prop_assert!((-3.0..=2.0).contains(&y));
        }
    }
}
