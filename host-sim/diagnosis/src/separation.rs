//! What a motion would tell of two hypotheses: the columns of the likelihood on a recording that does not exist yet.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::confidence_set::LEVEL_OF_THE_SET;
use crate::hypothesis::{Hypothesis, columns, kept};
use crate::likelihood::Noise;
use crate::problem::Problem;

/// How far a motion brings a rival, refitted to it, from the hypothesis that is right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Separation {
    /// Norm of the whitened innovations that the rival leaves beside its own columns, 1: twice the expected log-likelihood by
    /// which it is worse is its square.
    pub distance: f64,
}

impl Separation {
    /// The same for a motion made `times` times.
    pub fn repeated(self, times: usize) -> Self {
        Self { distance: self.distance * (times as f64).sqrt() }
    }

    /// Probability that the rival is excluded at the level of the set: the log-likelihood's difference has mean d^2 / 2 and
    /// standard deviation d (Vuong 1989, for a motion that is given).
    pub fn power(self) -> f64 {
        let normal = Normal::standard();
        normal.cdf(0.5 * self.distance - normal.inverse_cdf(1.0 - LEVEL_OF_THE_SET))
    }
}

/// Whitened innovations that a rival with its values as they are would leave along the planned recordings, which are those of
/// `right` without noise; none where either cannot be followed.
pub fn signature(planned: &Problem, noise: &[Noise], right: &Hypothesis, rival: &Hypothesis) -> Option<Vec<f64>> {
    let path = kept(planned, &right.physics(&planned.nominal), noise, planned.fitted)?;
    Some(path.response(planned, &rival.physics(&planned.nominal))?.concat())
}

/// What the planned recordings would tell of a rival whose values are fitted to them, to first order; none where either cannot be
/// followed.
pub fn separation(planned: &Problem, noise: &[Noise], right: &Hypothesis, rival: &Hypothesis) -> Option<Separation> {
    let left = DVector::from_vec(signature(planned, noise, right, rival)?);
    let path = kept(planned, &rival.physics(&planned.nominal), noise, planned.fitted)?;
    let own: Vec<DVector<f64>> = columns(planned, rival, &path)
        .into_iter()
        .flatten()
        .map(|column| DVector::from_vec(column.concat()))
        .filter(|column| column.norm() > 0.0)
        .map(|column| column.normalize())
        .collect();
    if own.is_empty() {
        return Some(Separation { distance: left.norm() });
    }
    let own = DMatrix::from_columns(&own);
    let mut information = own.tr_mul(&own);
    for i in 0..information.nrows() {
        information[(i, i)] *= 1.0 + 1e-9;
    }
    let fitted = information.cholesky()?.solve(&own.tr_mul(&left));
    Some(Separation { distance: (left - own * fitted).norm() })
}
