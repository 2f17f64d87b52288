//! What is left of each sample, looked at as noise: its autocorrelation, spectrum and histogram, each with the band in which noise
//! alone would be.

use diagnosis::confidence_set::TWO_SIDED_95;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use serde::Serialize;
use statrs::distribution::{Continuous, ContinuousCDF, Gamma, Normal};

use super::markup::{Section, table};
use super::words::short;
use crate::conclude::Whitened;
use crate::report::text::per_cent;

/// Lags of the autocorrelation, at most.
const LAGS: usize = 200;
/// Values of one segment of the spectrum, at most, ...
const LONGEST_SEGMENT: usize = 1024;
/// ... and at least.
const SHORTEST_SEGMENT: usize = 32;
/// Segments whose mean is a spectrum that says something.
const FEWEST_SEGMENTS: usize = 8;
/// Standard deviations that the histogram reaches either way, and its bins over each of them.
const REACH: f64 = 5.0;
const BINS_OF_ONE: f64 = 4.0;
/// Recordings whose usual steps differ by less than this share are sampled alike.
const ALIKE: f64 = 0.01;

/// A curve of what both machines leave, with the band of noise alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Curve {
    pub title: &'static str,
    pub x_label: &'static str,
    pub y_label: &'static str,
    /// Whether both axes are logarithmic.
    pub log: bool,
    pub x: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub nominal: Vec<f64>,
    /// None where no physics was added.
    pub improved: Option<Vec<f64>>,
}

/// The three curves; fewer where too little is left to draw.
pub(super) fn curves(all: &[Whitened], improved: bool) -> Vec<Curve> {
    // The period that most values have.
    let period_s = all.iter().max_by_key(|one| values(&one.nominal)).map_or(0.0, |one| one.period_s);
    let alike: Vec<&Whitened> = all.iter().filter(|one| (one.period_s - period_s).abs() <= ALIKE * period_s).collect();
    let stretches = |of: fn(&Whitened) -> &Vec<Vec<f64>>| -> Vec<&[f64]> {
        alike.iter().flat_map(|one| of(one).iter().map(Vec::as_slice)).filter(|one| one.len() > 1).collect()
    };
    let nominal = stretches(|one| &one.nominal);
    let improved = improved.then(|| stretches(|one| &one.improved));
    if period_s <= 0.0 || nominal.is_empty() {
        return Vec::new();
    }
    let both = (nominal.as_slice(), improved.as_deref());
    [autocorrelation(both, period_s), spectrum(both, period_s), histogram(both)].into_iter().flatten().collect()
}

/// Stretches of the nominal and of the improved machine.
type Both<'a> = (&'a [&'a [f64]], Option<&'a [&'a [f64]]>);

fn values(stretches: &[Vec<f64>]) -> usize {
    stretches.iter().map(Vec::len).sum()
}

/// To four decimals of `of`: no screen shows more.
fn rounded(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values.map(|value| (1e4 * value).round() / 1e4).collect()
}

fn autocorrelation((nominal, improved): Both<'_>, period_s: f64) -> Option<Curve> {
    let longest = nominal.iter().map(|one| one.len()).max()?;
    let lags = LAGS.min(longest / 4);
    let of = |stretches: &[&[f64]]| {
        let product = |lag: usize| -> f64 {
            stretches.iter().map(|one| one.iter().zip(one.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()).sum()
        };
        let squares = product(0).max(f64::MIN_POSITIVE);
        rounded((1..=lags).map(|lag| product(lag) / squares))
    };
    let count: usize = nominal.iter().map(|one| one.len()).sum();
    // Bartlett (1946): white noise correlates with itself by one over the root of its length.
    let half = TWO_SIDED_95 / (count as f64).sqrt();
    (lags > 1).then(|| Curve {
        title: "Autocorrelation",
        x_label: "lag (ms)",
        y_label: "correlation (1)",
        log: false,
        x: rounded((1..=lags).map(|lag| 1e3 * period_s * lag as f64)),
        low: vec![-half; lags],
        high: vec![half; lags],
        nominal: of(nominal),
        improved: improved.map(of),
    })
}

/// The mean of the periodograms of segments that do not overlap, under Hann's window (Welch 1967); 1 for white noise.
fn spectrum((nominal, improved): Both<'_>, period_s: f64) -> Option<Curve> {
    let count: usize = nominal.iter().map(|one| one.len()).sum();
    let mut length = LONGEST_SEGMENT;
    while length >= SHORTEST_SEGMENT && segments(nominal, length) < FEWEST_SEGMENTS {
        length /= 2;
    }
    if length < SHORTEST_SEGMENT || count == 0 {
        return None;
    }
    let averaged = segments(nominal, length) as f64;
    // Each periodogram of white noise is exponential, so their mean is a gamma variable.
    let gamma = Gamma::new(averaged, averaged).ok()?;
    let bins = 1..length / 2;
    Some(Curve {
        title: "Spectrum",
        x_label: "frequency (Hz)",
        y_label: "power (white noise 1)",
        log: true,
        x: rounded(bins.clone().map(|bin| bin as f64 / (length as f64 * period_s))),
        low: vec![gamma.inverse_cdf(0.025); bins.len()],
        high: vec![gamma.inverse_cdf(0.975); bins.len()],
        nominal: powers(nominal, length),
        improved: improved.map(|improved| powers(improved, length)),
    })
}

fn segments(stretches: &[&[f64]], length: usize) -> usize {
    stretches.iter().map(|one| one.len() / length).sum()
}

fn powers(stretches: &[&[f64]], length: usize) -> Vec<f64> {
    let fft = FftPlanner::new().plan_fft_forward(length);
    let hann = |at: usize| 0.5 - 0.5 * (std::f64::consts::TAU * at as f64 / length as f64).cos();
    let window: Vec<f64> = (0..length).map(hann).collect();
    let weight: f64 = window.iter().map(|one| one * one).sum();
    let mut sums = vec![0.0; length / 2];
    let mut count = 0.0;
    for segment in stretches.iter().flat_map(|one| one.chunks_exact(length)) {
        let mut line: Vec<Complex<f64>> = segment.iter().zip(&window).map(|(v, w)| Complex::from(v * w)).collect();
        fft.process(&mut line);
        sums.iter_mut().zip(&line).for_each(|(sum, bin)| *sum += bin.norm_sqr() / weight);
        count += 1.0;
    }
    let smallest = 1e-4; // A logarithmic axis has no zero.
    rounded(sums.iter().skip(1).map(|sum| (sum / f64::max(count, 1.0)).max(smallest)))
}

fn histogram((nominal, improved): Both<'_>) -> Option<Curve> {
    let bins = (2.0 * REACH * BINS_OF_ONE) as usize;
    let normal = Normal::new(0.0, 1.0).ok()?;
    let count: usize = nominal.iter().map(|one| one.len()).sum();
    let of = |stretches: &[&[f64]]| {
        let mut counts = vec![0.0; bins];
        let all: usize = stretches.iter().map(|one| one.len()).sum();
        for value in stretches.iter().flat_map(|one| one.iter()).filter(|value| value.is_finite()) {
            // What is further out stands in the outermost bins.
            let bin = ((value + REACH) * BINS_OF_ONE).floor().clamp(0.0, (bins - 1) as f64);
            counts[bin as usize] += BINS_OF_ONE / all.max(1) as f64;
        }
        rounded(counts.into_iter())
    };
    let middle = |bin: usize| (bin as f64 + 0.5) / BINS_OF_ONE - REACH;
    let expected = |bin: usize| normal.pdf(middle(bin));
    // Counts are binomial.
    let half = |bin: usize| TWO_SIDED_95 * (BINS_OF_ONE * expected(bin) / count.max(1) as f64).sqrt();
    Some(Curve {
        title: "Histogram",
        x_label: "what is left, over its standard deviation (1)",
        y_label: "density (1)",
        log: false,
        x: (0..bins).map(middle).collect(),
        low: rounded((0..bins).map(|bin| (expected(bin) - half(bin)).max(0.0))),
        high: rounded((0..bins).map(|bin| expected(bin) + half(bin))),
        nominal: of(nominal),
        improved: improved.map(of),
    })
}

/// The curves, which the script draws, and what they say in figures.
pub(super) fn section(curves: &[Curve]) -> Option<Section> {
    if curves.is_empty() {
        return None;
    }
    let rows = curves.iter().map(|curve| {
        let mut row = vec![
            format!("{}, values outside the band of noise", curve.title.to_lowercase()),
            outside(curve, &curve.nominal),
        ];
        row.extend(curve.improved.as_ref().map(|improved| outside(curve, improved)));
        row.push("5 %".to_owned());
        row
    });
    let largest = curves.iter().find(|curve| curve.title == "Autocorrelation").map(|curve| {
        let mut row = vec!["largest autocorrelation".to_owned(), largest(curve, &curve.nominal)];
        row.extend(curve.improved.as_ref().map(|improved| self::largest(curve, improved)));
        row.push(format!("{} at each lag", short(curve.high[0])));
        row
    });
    let mut head = vec!["measure", "nominal"];
    head.extend(curves[0].improved.as_ref().map(|_| "improved"));
    head.push("noise alone");
    let figures = table("What is left, as noise", &head, rows.chain(largest).collect());
    let places = curves.iter().enumerate().map(|(index, curve)| {
        format!(
            "<figure><figcaption>{}</figcaption><div class=\"left\" data-index=\"{index}\"></div></figure>",
            curve.title
        )
    });
    let body = format!(
        "<p class=\"quiet\">Of each sample, what the likelihood did not predict from those before it, over the standard deviation that \
         it expects. A complete model leaves white noise: no correlation, a flat spectrum, a normal distribution. The shaded bands hold \
         95 % of what noise alone would give.</p>{figures}<div class=\"grid\">{}</div>",
        places.collect::<String>()
    );
    Some(Section::new("noise", "Is what is left noise?", body))
}

/// The share of the values that lie outside the band.
fn outside(curve: &Curve, values: &[f64]) -> String {
    let beyond = values.iter().zip(curve.low.iter().zip(&curve.high));
    let beyond = beyond.filter(|(value, (low, high))| !(**low..=**high).contains(*value)).count();
    format!("{} %", per_cent(beyond as f64 / values.len().max(1) as f64))
}

/// The value that is largest either way, and where.
fn largest(curve: &Curve, values: &[f64]) -> String {
    let largest = values.iter().zip(&curve.x).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    largest.map_or_else(String::new, |(value, at)| format!("{value:.2} at {} ms", short(*at)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::SeedableRng;
    use rand::rngs::StdRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    fn noise(count: usize) -> Vec<f64> {
        StandardNormal.sample_iter(StdRng::seed_from_u64(1)).take(count).collect()
    }

    fn share_outside(curve: &Curve, values: &[f64]) -> f64 {
        outside(curve, values).trim_end_matches(" %").parse::<f64>().unwrap()
    }

    #[test]
    fn white_noise_is_in_the_bands_and_a_random_walk_is_not() {
        let white = noise(20_000);
        let walk: Vec<f64> = white
            .iter()
            .scan(0.0, |sum, step| {
                *sum = 0.99 * *sum + 0.14 * step;
                Some(*sum)
            })
            .collect();
        let all = [Whitened { recording: "a".to_owned(), period_s: 1e-3, nominal: vec![walk], improved: vec![white] }];
        let curves = curves(&all, true);
        let titles: Vec<&str> = curves.iter().map(|curve| curve.title).collect();
        assert_eq!(titles, ["Autocorrelation", "Spectrum", "Histogram"]);
        for curve in &curves[..2] {
            let (nominal, improved) =
                (share_outside(curve, &curve.nominal), share_outside(curve, curve.improved.as_ref().unwrap()));
            assert!(nominal > 60.0 && improved < 12.0, "{}: {nominal} {improved}", curve.title);
        }
        let improved = curves[2].improved.as_ref().unwrap();
        assert!(share_outside(&curves[2], improved) < 15.0);
        // All of it is somewhere.
        assert!((improved.iter().sum::<f64>() / BINS_OF_ONE - 1.0).abs() < 1e-2);
    }

    #[test]
    fn nothing_left_draws_nothing() {
        assert_eq!(curves(&[], true), []);
        let short =
            Whitened { recording: "a".to_owned(), period_s: 1e-3, nominal: vec![vec![1.0]], improved: Vec::new() };
        assert_eq!(curves(&[short], true), []);
    }
}
