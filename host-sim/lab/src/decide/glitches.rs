//! Isolated wrong samples, as an effect: how many there are and how wrong, from those that are seen.
//!
//! A sample is seen to be wrong where it is further from its neighbours than the motion and the noise of its recording may
//! make it. Of errors about as large as that only the larger ones are seen, and in recordings with harder motion none: so the
//! size is that of a normal distribution cut off below each recording's limit, and the count is of the samples in which an
//! error of that size is seen.

use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use super::Request;
use super::named::parameters;
use crate::read::vocabulary;
use crate::report::{EffectAnswer, Evidence};
use crate::screen::{Motion, Problem};

/// Fewer isolated wrong samples are accidents.
const MANY: usize = 5;
/// A position's distance from the cubic through its four neighbours scatters by this many times the noise of a sample: one, and
/// the weights -1/6, 2/3, 2/3, -1/6.
const SCATTER: f64 = 1.394;
/// An error that is this many standard deviations below a limit is never seen above it.
const NEVER: f64 = 6.0;
/// Bisections of the size: to a part in 1e12 of its bracket.
const HALVINGS: usize = 40;

/// In words, that there are isolated wrong samples where they may not be named: a recording that is clean only without them
/// is not clean.
pub(super) fn unnamed_glitches(request: &Request<'_>, problem: &Problem) -> Option<String> {
    let count = problem.wrong_samples();
    let barred = !request.vocabulary.iter().any(|effect| effect.id == "sensor_glitch");
    (barred && count >= MANY)
        .then(|| format!("{count} isolated position samples are wrong, and nothing in the vocabulary makes them so"))
}

/// Isolated wrong samples, as an effect.
pub(super) fn glitches(request: &Request<'_>, problem: &Problem) -> Option<EffectAnswer> {
    let kind = request.vocabulary.iter().find(|effect| effect.id == "sensor_glitch")?;
    if problem.wrong_samples() < MANY {
        return None;
    }
    let rounding = request.machine.axis.resolution / 12.0_f64.sqrt();
    let seen: Vec<Seen> = problem.motions.iter().map(|motion| Seen::of(motion, rounding)).collect();
    let names = vocabulary::effect(kind.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    Some(EffectAnswer {
        id: kind.id.to_owned(),
        text: kind.sentence.to_owned(),
        equivalent: Vec::new(),
        parameters: parameters(names, &share_and_size(&seen), request.machine.axis.kind),
        evidence: Evidence { heldout_gain: 0.0, p_value: 0.0, excess_explained: 1.0 },
        recording: None,
    })
}

/// What is seen in one recording.
#[derive(Debug)]
struct Seen {
    /// Distances from the neighbours without their signs, rad (m).
    sizes: Vec<f64>,
    samples: f64,
    /// The least that is seen, rad (m).
    limit: f64,
    /// Standard deviation about the true size, rad (m).
    scatter: f64,
}

impl Seen {
    fn of(motion: &Motion, rounding: f64) -> Self {
        Self {
            sizes: motion.glitches.iter().map(|glitch| glitch.size.abs()).collect(),
            samples: (motion.cells() + 1) as f64,
            limit: motion.glitch_limit,
            scatter: SCATTER * motion.noise.max(rounding).max(f64::MIN_POSITIVE),
        }
    }

    /// The limit in standard deviations above a size.
    fn above(&self, size: f64) -> f64 {
        (self.limit - size) / self.scatter
    }

    /// How far above a size, in standard deviations and on average, what is seen of it is.
    fn mean_beyond(&self, size: f64) -> f64 {
        let (normal, limit) = (Normal::standard(), self.above(size));
        // Beyond the reach of the functions, by the first two terms of the continued fraction.
        if limit > NEVER { limit + 1.0 / limit } else { normal.pdf(limit) / normal.sf(limit) }
    }
}

/// Share of samples that are wrong, 1, and their size, rad (m), each with the half-width of its 95 % interval.
fn share_and_size(seen: &[Seen]) -> [(f64, f64); 2] {
    let count: usize = seen.iter().map(|seen| seen.sizes.len()).sum();
    let all = || seen.iter().flat_map(|seen| seen.sizes.iter().map(move |size| (seen, *size)));
    // Slope of the logarithm of the likelihood.
    let slope = |at: f64| {
        all().map(|(seen, size)| ((size - at) / seen.scatter - seen.mean_beyond(at)) / seen.scatter).sum::<f64>()
    };
    let mut high = all().map(|(_, size)| size).fold(0.0, f64::max);
    let mut low = all().map(|(seen, _)| seen.limit - NEVER * seen.scatter).fold(high, f64::min).max(0.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { low = middle } else { high = middle }
    }
    let size = 0.5 * (low + high);
    let information = all().map(|(seen, _)| {
        let beyond = seen.mean_beyond(size);
        (1.0 - beyond * (beyond - seen.above(size))).max(0.0) / (seen.scatter * seen.scatter)
    });
    let expected = information.sum::<f64>().recip().sqrt();
    let mean = all().map(|(_, size)| size).sum::<f64>() / count as f64;
    let scatter = all().map(|(_, size)| (size - mean).powi(2)).sum::<f64>() / (count as f64 - 1.0);
    let half_size = 1.96 * expected.max((scatter / count as f64).sqrt());
    let share = |size: f64| {
        let could = seen.iter().map(|seen| seen.samples * Normal::standard().sf(seen.above(size))).sum::<f64>();
        count as f64 / could.max(count as f64)
    };
    // A count is Poisson, and how many were not seen is known as well as the size is.
    let counted = 1.96 * share(size) / (count as f64).sqrt();
    let unseen = 0.5 * (share(size - half_size) - share(size + half_size));
    [(share(size), counted.hypot(unseen)), (size, half_size)]
}

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    use super::*;

    /// Three in a thousand samples of each recording are wrong by 1.
    fn seen(limits: [f64; 3], seed: u64) -> Vec<Seen> {
        let mut random = StdRng::seed_from_u64(seed);
        let each = limits.into_iter().map(|limit| {
            let sizes = (0..16_000).filter_map(|_| {
                let wrong = random.random_bool(0.003);
                wrong.then(|| 1.0 + 0.1 * random.sample::<f64, _>(StandardNormal))
            });
            Seen { sizes: sizes.filter(|size| *size > limit).collect(), samples: 16_000.0, limit, scatter: 0.1 }
        });
        each.collect()
    }

    #[test]
    fn share_and_size_are_found_where_all_are_seen_and_where_few_are() {
        for limits in [[0.1; 3], [0.95; 3], [0.6, 1.05, 3.0]] {
            let mut held = [0, 0];
            for seed in 0..100 {
                let found = share_and_size(&seen(limits, seed));
                for ((value, half), (held, truth)) in found.into_iter().zip(held.iter_mut().zip([0.003, 1.0])) {
                    *held += u32::from((value - truth).abs() <= half);
                }
            }
            assert!(held.iter().all(|held| *held >= 88), "{limits:?}: {held:?} of 100");
        }
    }
}
