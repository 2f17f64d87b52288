//! Forward selection with refits of the few.

use rayon::prelude::*;

use crate::effects::Effect;
use crate::hypothesis::{Hypothesis, Refitted, kept, noise_of, refit};
use crate::likelihood::Noise;
use crate::problem::Problem;
use crate::score::{Candidate, score};

/// Noise to begin with.
pub fn first_noise(problem: &Problem) -> Noise {
    let torque = problem.excitation.torque_rms.max(f64::MIN_POSITIVE.sqrt());
    let begin = Noise {
        sensor_sd: problem.least_sensor_sd,
        torque_density: (0.1 * torque).powi(2) * problem.excitation.period_s,
        colour_sd: 0.03 * torque,
        colour_s: crate::hypothesis::COLOUR_S,
    };
    noise_of(problem, &problem.nominal, &begin, 4.0)
}

/// The nominal machine.
pub fn nominal(problem: &Problem) -> Option<Refitted> {
    refit(problem, &Hypothesis::default(), &first_noise(problem), 1)
}

/// Candidates beside a hypothesis, best start of each effect.
pub fn candidates(problem: &Problem, at: &Refitted, vocabulary: &[&'static Effect]) -> Vec<Candidate> {
    let physics = at.hypothesis.physics(&problem.nominal);
    let Some(path) = kept(problem, &physics, &at.noise, problem.fitted) else { return Vec::new() };
    score(problem, &at.hypothesis, &path, vocabulary)
}

/// The best of the refits of the first `many` effects.
pub fn extend(problem: &Problem, at: &Refitted, candidates: &[Candidate], many: usize) -> Vec<Refitted> {
    let mut seen: Vec<&'static str> = Vec::new();
    let mut starts = Vec::new();
    for candidate in candidates {
        let id = candidate.entry.effect.id;
        let times = seen.iter().filter(|other| **other == id).count();
        if times < 2 && (times == 0 || starts.len() < many) {
            let with = |values: &[f64]| at.hypothesis.with(candidate.entry.effect, values.to_vec());
            starts.push((with(&candidate.entry.values), with(&candidate.from)));
        }
        seen.push(id);
        if starts.len() == 2 * many {
            break;
        }
    }
    let short = |(start, from): &(Hypothesis, Hypothesis)| {
        let found = refit(problem, start, &at.noise, 2)?;
        // A step that leads astray is taken again from where it began.
        if found.log_likelihood > at.log_likelihood { Some(found) } else { refit(problem, from, &at.noise, 2) }
    };
    let mut found: Vec<Refitted> = starts.par_iter().filter_map(short).collect();
    found.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
    found.truncate(3);
    let mut found: Vec<Refitted> =
        found.par_iter().filter_map(|start| refit(problem, &start.hypothesis, &start.noise, 10)).collect();
    found.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
    found
}
