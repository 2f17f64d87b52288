//! Ranges of axes and the numbers along them.

use std::ops::Range;

/// The range that shows all of `values` with `margin` (a part of the span) on either side; 0 to 1 for no values.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    // A constant, or one with rounding noise on it, is shown amid a span of its own size.
    let size = low.abs().max(high.abs());
    if high - low <= 1e-9 * size || high == low {
        let half = if size > 0.0 { 0.1 * size } else { 1.0 };
        return low - half..high + half;
    }
    let margin = margin * (high - low);
    low - margin..high + margin
}

/// The number at a tick of an axis that spans `span`: the digits that tell ticks apart, and no more.
pub(super) fn tick_label(value: f64, span: f64) -> String {
    let resolution = span / 100.0;
    let value = if value.abs() < resolution { 0.0 } else { value };
    let (smallest, largest) = (1e-3, 1e5);
    if value != 0.0 && (span < smallest || value.abs() >= largest) {
        // A digit more than the order of the value over the resolution.
        let digits = (value.abs() / resolution).log10().floor().clamp(0.0, 12.0) as usize;
        let label = format!("{value:.digits$e}");
        return match label.split_once('e') {
            Some((mantissa, exponent)) => format!("{}e{exponent}", without_zeros(mantissa)),
            None => label,
        };
    }
    let decimals = (-resolution.log10()).ceil().clamp(0.0, 12.0) as usize;
    without_zeros(&format!("{value:.decimals$}")).to_owned()
}

fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_the_digits_that_tell_ticks_apart() {
        assert_eq!(tick_label(0.1 + 0.2, 1.0), "0.3");
        assert_eq!(tick_label(1e-18, 1.0), "0");
        assert_eq!(tick_label(250.0, 1000.0), "250");
        assert_eq!(tick_label(-2.5e-5, 1e-4), "-2.5e-5");
        assert_eq!(tick_label(0.002, 0.004), "0.002");
        assert_eq!(tick_label(1.2e6, 3e6), "1.2e6");
        assert_eq!(tick_label(1000.0, 1e-3), "1000");
    }

    #[test]
    fn ranges_are_never_empty() {
        for values in [vec![], vec![0.0], vec![3.0, 3.0], vec![-1e300, 1e300], vec![1.0, 1.0 + 1e-15]] {
            let range = range(values.iter().copied(), 0.05);
            assert!(range.end > range.start && (range.end - range.start).is_finite(), "{values:?}: {range:?}");
        }
    }
}
