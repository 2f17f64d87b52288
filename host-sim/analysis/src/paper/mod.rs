//! The paper, reproduced and judged: every figure that can be made without its measurements, and every claim tested.

pub mod case;
pub mod claims;
pub mod figures;
pub mod scan;
pub mod table;

use claims::Claim;
use figures::NamedFigure;
use progress::Progress;
use recording::{Error, Recording};

/// What is left of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct Reproduction {
    /// Each claim with its test and verdict.
    pub claims: Vec<Claim>,
    /// Each figure that can be made.
    pub figures: Vec<NamedFigure>,
    /// Runs of the scan.
    pub runs: usize,
    /// Places of the scan that decide nothing: friction holds the rotor against the whole step.
    pub held: usize,
}

/// Reproduces the paper; some thousands of runs on all cores. A recording in `measured` is drawn into the figures that the
/// paper has a measured curve in.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take; none is known for the paper's.
pub fn reproduce(measured: Option<&Recording>) -> Result<Reproduction, Error> {
    let progress = Progress::new("the paper", scan::size() as u64 + claims::GROUPS);
    let scan = scan::scan(&progress)?;
    let joint = claims::joint_search(&scan)?;
    let claims = claims::test_all(&scan, joint.as_ref(), &progress)?;
    let figures = figures::all(joint.as_ref(), measured)?;
    Ok(Reproduction { claims, figures, runs: scan.runs, held: scan.held })
}
