//! The search on a twin, from which nothing is missing.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Noise, Path, twin};
use crate::Error;
use crate::budget::Budget;
use crate::decide::Request;
use crate::decide::confirmed::missed;
use crate::decide::prepare::searcher;
use crate::effects::Physics;
use crate::read::Recording;
use crate::refit::TimeFit;
use crate::screen::{Motion, Problem, Trial};

/// So many of the best phantoms are asked for in the time domain, and those that the answer names.
const CONFIRMED: usize = 2;

/// Seed of the twins that are searched; none of the floor's.
pub(super) const SEED: u64 = 1_000_000;

/// Effects that the first step of the search accepts, and the time domain confirms, on twins of the recordings, with the
/// twins' own machine as the nominal: none, if the tool is right. Best first. Of those accepted, the best and those `answered`
/// are confirmed; the others are not told of.
///
/// # Errors
/// A machine that the plant refuses.
pub fn falsely_found(
    request: &Request<'_>,
    machine: &Physics,
    recordings: &[Recording],
    motions: &[Motion],
    noises: &[Noise],
    (answered, budget): (&[&str], &Arc<Budget>),
) -> Result<Vec<&'static str>, Error> {
    let resolution = request.machine.axis.resolution;
    let each = (0..recordings.len()).into_par_iter().map(|index| {
        let seed = SEED + index as u64;
        let (recording, motion) = (&recordings[index], &motions[index]);
        let path = Path::of(motion, 0, recording.rows());
        let twin = twin(machine, index, recording, path, &noises[index], seed)?;
        let motion = Motion::new(&twin, machine, resolution).again(machine, index, resolution);
        Ok((twin, motion))
    });
    let (twins, motions): (Vec<Recording>, Vec<Motion>) = each.collect::<Result<Vec<_>, Error>>()?.into_iter().unzip();
    let problem = Problem::new(motions, twins.len(), machine.clone()).within(budget);
    if problem.equations.is_empty() {
        return Ok(Vec::new());
    }
    let accepted = searcher(request, &problem).first_step();
    let asked =
        accepted.iter().enumerate().filter(|(rank, trial)| *rank < CONFIRMED || answered.contains(&trial.effect.id));
    let asked: Vec<&Trial> = asked.map(|(_, trial)| trial).collect();
    // One after the other: each runs its windows in parallel, and looks at the budget between.
    let confirmed = asked.into_iter().filter(|trial| {
        let with = TimeFit::new(&problem, &twins, &trial.fit.active, resolution);
        // What cannot be simulated cannot be taken back either.
        with.and_then(|with| Ok(missed(&with.without(&problem, &twins, 0)?, &with))).unwrap_or(true)
    });
    Ok(confirmed.map(|trial| trial.effect.id).collect())
}
