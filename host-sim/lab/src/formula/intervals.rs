//! Coefficients with 95 % intervals that hold when neighbouring residuals are not independent.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::columns::Columns;
use super::terms::{Form, Term};
use super::words;
use crate::read::AxisKind;
use crate::report::{FormulaTerm, Interval};

/// A small change of a parameter, relative, for its derivative.
const SMALL: f64 = 1e-3;

/// Each term with its values; the parameter of a form or carrier has its interval too, and widens those of the rest.
pub(super) fn terms(columns: &Columns<'_>, terms: &[Term], axis: AxisKind) -> Vec<FormulaTerm> {
    let parts: Vec<Vec<DVector<f64>>> = terms.iter().map(|term| columns.of(term)).collect();
    let (found, _) = columns.solve(&parts.concat());
    let mut design = parts.concat();
    let mut first = 0;
    for (term, part) in terms.iter().zip(&parts) {
        if term.adjustable(axis) {
            let step = SMALL * term.parameter;
            let moved = columns.of(&Term { parameter: term.parameter + step, ..*term });
            let change = moved.iter().zip(part).enumerate();
            let zero = DVector::zeros(columns.residual.len());
            design
                .push(change.fold(zero, |sum, (at, (moved, here))| sum + (moved - here) * (found[first + at] / step)));
        }
        first += part.len();
    }
    let (covariance, reach) = covariance(columns, &design, &found);
    let (mut at, mut free) = (0, first);
    let each = terms.iter().map(|term| {
        let values = found.rows(at, term.columns()).into_owned();
        let errors = covariance.view((at, at), (term.columns(), term.columns())).into_owned();
        at += term.columns();
        let mut parameters = coefficient(term, &values, &errors, reach, axis);
        if term.adjustable(axis) {
            let half = reach * covariance[(free, free)].max(0.0).sqrt();
            free += 1;
            let (id, unit) = words::parameter(term, axis);
            parameters.push(interval(id, term.parameter, half, unit));
        }
        FormulaTerm { text: words::function(term, axis), parameters }
    });
    each.collect()
}

/// Covariance from the sums of each block (Liang and Zeger 1986) with its correction for few blocks, and how many standard
/// deviations an interval reaches.
fn covariance(columns: &Columns<'_>, design: &[DVector<f64>], found: &DVector<f64>) -> (DMatrix<f64>, f64) {
    let count = design.len();
    let dot = |i: usize, j: usize| design[i].rows(0, columns.fitted).dot(&design[j].rows(0, columns.fitted));
    let normal = DMatrix::from_fn(count, count, dot);
    let inverse = normal.pseudo_inverse(1e-12).unwrap_or_else(|_| DMatrix::zeros(count, count));
    let coefficients = &design[..found.len()];
    let (mut meat, mut blocks) = (DMatrix::zeros(count, count), 0.0);
    for rows in columns.fitted_blocks() {
        let left = columns.left(coefficients, found, rows);
        let pull = DVector::from_fn(count, |i, _| design[i].rows_range(rows.clone()).dot(&left));
        meat += &pull * pull.transpose();
        blocks += 1.0;
    }
    let freedom = (blocks - count as f64).max(1.0);
    let reach = StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975));
    (&inverse * meat * &inverse * (blocks / freedom), reach)
}

/// The coefficient, or amplitude and phase of a wave.
fn coefficient(term: &Term, values: &DVector<f64>, errors: &DMatrix<f64>, reach: f64, axis: AxisKind) -> Vec<Interval> {
    let unit = words::coefficient_unit(term, axis);
    if term.form != Form::Wave {
        return vec![interval("coefficient", values[0], reach * errors[(0, 0)].max(0.0).sqrt(), unit)];
    }
    let (sine, cosine) = (values[0], values[1]);
    let amplitude = sine.hypot(cosine).max(1e-300);
    let half = |by_sine: f64, by_cosine: f64| {
        let by = DVector::from_vec(vec![by_sine, by_cosine]);
        reach * (by.transpose() * errors * &by)[0].max(0.0).sqrt()
    };
    let of_phase = half(-cosine / amplitude.powi(2), sine / amplitude.powi(2));
    vec![
        interval("amplitude", amplitude, half(sine / amplitude, cosine / amplitude), unit),
        interval("phase_rad", cosine.atan2(sine), of_phase, "rad".to_owned()),
    ]
}

fn interval(id: &str, value: f64, half: f64, unit: String) -> Interval {
    Interval { id: id.to_owned(), value, low: value - half, high: value + half, unit }
}
