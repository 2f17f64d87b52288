//! All that the twins say of a diagnosis.

use rayon::prelude::*;

use super::{Floor, Noise, estimate, falsely_found, noise_floor};
use crate::Error;
use crate::decide::Request;
use crate::decide::prepare::Searched;
use crate::effects::Physics;
use crate::refit::TimeFit;

/// What the twins of the recordings say.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Twins {
    /// What noise alone leaves; none where no twin could be made.
    pub floor: Option<Floor>,
    /// Effects that the search finds in a machine from which nothing is missing; none, if the tool is right.
    pub falsely_found: Vec<&'static str>,
    /// In words, what failed.
    pub warnings: Vec<String>,
}

impl Twins {
    /// Makes twins of the improved machine, measures the floor on them and searches one set of them.
    /// `time` is the fit in the time domain, if it is the one that is reported.
    pub(in crate::decide) fn of(
        request: &Request<'_>,
        searched: &Searched,
        (improved, time): (&Physics, Option<&TimeFit>),
    ) -> Self {
        let (problem, outcome) = (&searched.problem, &searched.outcome);
        let resolution = request.machine.axis.resolution;
        let each = (0..problem.motions.len()).into_par_iter();
        let noise = |index| {
            let balance = estimate(problem, &outcome.fit, &outcome.weights, index, resolution);
            // The torque balance of a machine with a memory has errors of its own, at impacts above all; the windows have
            // those of their start states.
            let windows = time.filter(|_| improved.remembers()).map_or(f64::INFINITY, |time| {
                time.torque_noise(index, improved.inertia, problem.motions[index].period_s)
            });
            Noise { torque: balance.torque.min(windows), ..balance }
        };
        let noises: Vec<Noise> = each.map(noise).collect();
        if problem.budget.check() {
            return Self::default();
        }
        match Self::made(request, searched, improved, &noises) {
            Ok(twins) => twins,
            Err(error) => Self {
                warnings: vec![format!("no clean synthetic twin could be made, so the floor is an estimate: {error}")],
                ..Self::default()
            },
        }
    }

    fn made(request: &Request<'_>, searched: &Searched, improved: &Physics, noises: &[Noise]) -> Result<Self, Error> {
        let problem = &searched.problem;
        let floor = noise_floor(improved, &searched.recordings, &problem.motions, noises)?;
        problem.budget.spend(floor.work);
        if problem.budget.check() {
            return Ok(Self { warnings: floor.warnings.clone(), floor: Some(floor), falsely_found: Vec::new() });
        }
        let answered: Vec<&str> = searched.outcome.fit.active.iter().map(|entry| entry.effect.id).collect();
        let falsely_found = falsely_found(
            request,
            improved,
            searched.fitted(),
            &problem.motions,
            noises,
            (&answered, &problem.budget),
        )?;
        let mut warnings = floor.warnings.clone();
        if !falsely_found.is_empty() {
            warnings.push(format!(
                "self-check failed: in a clean synthetic twin of these recordings, from which nothing is missing (seed {}), \
                 the search found {}; the same in the answer may be the tool's own making",
                super::clean::SEED,
                falsely_found.join(", ")
            ));
        }
        Ok(Self { floor: Some(floor), falsely_found, warnings })
    }
}
