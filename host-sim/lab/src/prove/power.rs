//! How large an effect must be to be found: a logistic curve over the logarithm of its strength, in the unit of its
//! leading parameter; on drawn machines, whose units differ, in multiples of the detectable size.

use std::collections::BTreeMap;

use conceal::catalogue;
use conceal::plan::Arm;
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::Outcome;

/// Prior of the curve's height at the middle of the strengths and of its slope: mean and standard deviation. Weak, and
/// what keeps the curve finite where every size is found, or none.
const PRIOR: [(f64, f64); 2] = [(0.0, 3.0), (2.0, 1.5)];
/// Rounds of Newton's method.
const ROUNDS: usize = 60;

/// One case on the curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Of the case.
    pub seed: u64,
    /// In the unit of the leading parameter (or one over it).
    pub strength: f64,
    /// The first name was right.
    pub found: bool,
}

/// A strength with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Detectable {
    /// Estimate.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The curve of one effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Effect.
    pub id: String,
    /// Parameter that tells its strength, unit last.
    pub parameter: String,
    /// Its value without the effect; none where the effect grows as it falls.
    pub origin: Option<f64>,
    /// Cases by strength.
    pub points: Vec<Point>,
    /// ln of the strength at which the curve is centred, height there, slope.
    pub curve: [f64; 3],
    /// Found in half of the cases.
    pub at_50: Detectable,
    /// Found in nine of ten.
    pub at_90: Detectable,
}

impl Curve {
    /// Chance of the first name to be right at a strength.
    pub fn chance(&self, strength: f64) -> f64 {
        let [centre, height, slope] = self.curve;
        chance(height + slope * (strength.ln() - centre))
    }

    /// A strength as a value of the parameter, in words.
    pub fn words(&self, strength: f64) -> String {
        match self.origin {
            None => format!("{:.4}", 1.0 / strength),
            Some(0.0) => format!("{strength:.4}"),
            Some(origin) => format!("{origin} +- {strength:.4}"),
        }
    }

    /// A detectable size with its interval, and whether it lies outside the strengths that were tried.
    pub fn size_words(&self, size: &Detectable) -> String {
        let tried = self.points.iter().map(|point| point.strength);
        let (low, high) = (tried.clone().fold(f64::INFINITY, f64::min), tried.fold(0.0, f64::max));
        if size.value < low {
            return format!("weaker than tried ({})", self.words(low));
        }
        if size.value > high {
            return format!("stronger than tried ({})", self.words(high));
        }
        format!("{} [{}, {}]", self.words(size.value), self.words(size.low), self.words(size.high))
    }
}

fn chance(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// The curves of every effect that was concealed alone.
pub fn curves(outcomes: &[Outcome]) -> Vec<Curve> {
    let mut by_effect: BTreeMap<(&str, bool), Vec<Point>> = BTreeMap::new();
    for outcome in outcomes.iter().filter(|outcome| outcome.arm() == Arm::Single) {
        if let [effect] = &outcome.truth.effects[..] {
            let drawn = outcome.truth.machine.is_some();
            let (seed, strength) = (outcome.truth.seed, if drawn { effect.size } else { effect.strength });
            by_effect.entry((&effect.id, drawn)).or_default().push(Point {
                seed,
                strength,
                found: outcome.first_right,
            });
        }
    }
    by_effect.into_iter().filter_map(|((id, drawn), points)| curve(id, points, drawn)).collect()
}

/// What the strength of an effect on a drawn machine is counted in.
const MULTIPLES: (&str, Option<f64>) = ("times the detectable size", Some(0.0));

fn curve(id: &str, mut points: Vec<Point>, drawn: bool) -> Option<Curve> {
    points.sort_by(|a, b| a.strength.total_cmp(&b.strength));
    let (parameter, origin) = if drawn { MULTIPLES } else { catalogue::find(id)?.leading() };
    let centre = points.iter().map(|point| point.strength.ln()).sum::<f64>() / points.len() as f64;
    let (fitted, covariance) = fit(&points, centre)?;
    let size = |logit: f64| {
        let (height, slope) = (fitted[0], fitted[1]);
        let ln = (logit - height) / slope;
        let gradient = Vector2::new(-1.0 / slope, -ln / slope);
        let deviation = (gradient.dot(&(covariance * gradient))).max(0.0).sqrt();
        let at = |deviations: f64| (centre + ln + deviations * deviation).exp();
        Detectable { value: at(0.0), low: at(-1.96), high: at(1.96) }
    };
    Some(Curve {
        id: id.to_owned(),
        parameter: parameter.to_owned(),
        origin,
        curve: [centre, fitted[0], fitted[1]],
        at_50: size(0.0),
        at_90: size(9.0_f64.ln()),
        points,
    })
}

/// Most probable height and slope, and their covariance.
fn fit(points: &[Point], centre: f64) -> Option<(Vector2<f64>, Matrix2<f64>)> {
    let mut at = Vector2::new(PRIOR[0].0, PRIOR[1].0);
    let mut covariance = Matrix2::identity();
    for _ in 0..ROUNDS {
        let precision = Matrix2::from_diagonal(&Vector2::new(PRIOR[0].1.powi(-2), PRIOR[1].1.powi(-2)));
        let mut slope = precision * (Vector2::new(PRIOR[0].0, PRIOR[1].0) - at);
        let mut curvature = precision;
        for point in points {
            let x = Vector2::new(1.0, point.strength.ln() - centre);
            let p = chance(at.dot(&x));
            slope += x * (f64::from(u8::from(point.found)) - p);
            curvature += x * x.transpose() * (p * (1.0 - p));
        }
        covariance = curvature.try_inverse()?;
        // A step of bounded length: far from the optimum the curve is flat.
        let step = covariance * slope;
        at += step / (step.norm() / 1.0).max(1.0);
        // Falling chances are no model of finding things.
        at[1] = at[1].max(0.1);
    }
    Some((at, covariance))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn points(found: impl Fn(f64) -> bool) -> Vec<Point> {
        let strengths = (1..=40).map(|k| f64::from(k) * 0.01);
        strengths.map(|strength| Point { seed: 0, strength, found: found(strength) }).collect()
    }

    #[test]
    fn half_of_the_cases_are_found_where_the_step_is() {
        let curve = curve("coulomb_friction", points(|strength| strength > 0.1), false).unwrap();
        assert!((curve.at_50.value - 0.1).abs() < 0.03, "{:?}", curve.at_50);
        assert!(curve.at_50.low < curve.at_50.value && curve.at_50.value < curve.at_50.high);
        assert!(curve.at_90.value > curve.at_50.value && (curve.chance(curve.at_50.value) - 0.5).abs() < 1e-6);
        assert_eq!((curve.parameter.as_str(), curve.origin), ("coulomb_nm", Some(0.763)));
        assert!(curve.size_words(&curve.at_50).starts_with("0.763 +- 0."));
    }

    #[test]
    fn what_is_always_or_never_found_lies_outside_what_was_tried() {
        let always = curve("compliance", points(|_| true), false).unwrap();
        assert!(always.size_words(&always.at_50).starts_with("weaker than tried (100"), "{:?}", always.at_50);
        let never = curve("compliance", points(|_| false), false).unwrap();
        assert!(never.size_words(&never.at_50).starts_with("stronger than tried"), "{:?}", never.at_50);
    }
}
