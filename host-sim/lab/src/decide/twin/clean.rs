//! The search on a twin, from which nothing is missing.

use rayon::prelude::*;

use super::{Noise, Path, twin};
use crate::Error;
use crate::decide::Request;
use crate::effects::Physics;
use crate::read::{AxisKind, Recording};
use crate::screen::{Motion, Problem, Search};

/// Seed of the twins that are searched; none of the floor's.
pub(super) const SEED: u64 = 1_000_000;

/// Effects that the first step of the search accepts on twins of the recordings, with the twins' own machine as the
/// nominal: none, if the tool is right. Best first.
///
/// # Errors
/// A machine that the plant refuses.
pub fn falsely_found(
    request: &Request<'_>,
    machine: &Physics,
    recordings: &[Recording],
    motions: &[Motion],
    noises: &[Noise],
) -> Result<Vec<&'static str>, Error> {
    let resolution = request.machine.axis.resolution;
    let each = (0..recordings.len()).into_par_iter().map(|index| {
        let seed = SEED + index as u64;
        let (recording, motion) = (&recordings[index], &motions[index]);
        let path = Path::of(motion, 0, recording.rows());
        let twin = twin(machine, index, recording, path, &noises[index], seed)?;
        Ok(Motion::new(&twin, machine, resolution).again(machine, index, resolution))
    });
    let problem = Problem::new(each.collect::<Result<_, Error>>()?, recordings.len(), machine.clone());
    if problem.equations.is_empty() {
        return Ok(Vec::new());
    }
    let linear = request.machine.axis.kind == AxisKind::Linear;
    let accepted = Search::new(&problem, request.vocabulary, linear).first_step();
    Ok(accepted.into_iter().map(|trial| trial.effect.id).collect())
}
