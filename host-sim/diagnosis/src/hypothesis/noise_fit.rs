//! The noise of each recording by maximum likelihood.

use std::ops::Range;

use rayon::prelude::*;

use super::evaluate::{driven, prepare, residual};
use crate::likelihood::filter::{Driven, Prepared};
use crate::likelihood::{Acting, Colour, Noise};
use crate::physics::Physics;
use crate::problem::Problem;

/// The noise of each recording under which a machine is most likely, searched from `from` in steps of 2^`octaves` downwards for
/// those of `which` and as it is for the others. Noise without a memory gets none.
pub fn noise_of(problem: &Problem, physics: &Physics, from: &[Noise], octaves: f64, which: Range<usize>) -> Vec<Noise> {
    each(from, which, |index, from| {
        let (prepared, acting) = prepare(problem, physics, index)?;
        if let Some(motion) = problem.motions.get(index) {
            let residual = residual(problem, index, motion, &prepared, &acting);
            return Some(prepared.likeliest_noise(motion, &residual));
        }
        Some(Stretches::excerpt(problem, index, &prepared, &acting).likeliest(*from, octaves).0)
    })
}

/// The same from near by, on all rows and in small steps: what is left over among numbers that an excerpt hardly tells apart was
/// worth eight units of a held-out recording between two hypotheses that predict the same. Where the motion is given it stays, for all rows have
/// told it.
pub(super) fn noise_on_all_rows(
    problem: &Problem,
    physics: &Physics,
    from: &[Noise],
    which: Range<usize>,
) -> Vec<Noise> {
    each(from, which, |index, from| {
        if problem.motions.get(index).is_some() {
            return None;
        }
        let (prepared, acting) = prepare(problem, physics, index)?;
        let all = 0..problem.recordings[index].rows();
        let rows = std::slice::from_ref(&all);
        let stretches = Stretches { rows, ..Stretches::excerpt(problem, index, &prepared, &acting) };
        Some(stretches.likeliest(*from, FINEST_OCTAVES).0)
    })
}

/// What `estimate` makes of the noise of each of `which`; the others, and where it makes nothing, as they are.
fn each(from: &[Noise], which: Range<usize>, estimate: impl Fn(usize, &Noise) -> Option<Noise> + Sync) -> Vec<Noise> {
    let one = |(index, from): (usize, &Noise)| {
        let found = which.contains(&index).then(|| estimate(index, from));
        found.flatten().unwrap_or(*from)
    };
    from.par_iter().enumerate().map(one).collect()
}

/// Memories that are tried first, s: from what a current loop has to what ripple and bearings have. Each is a factor of four from
/// the next, and a search goes on between them.
const FIRST_MEMORIES_S: [f64; 3] = [0.002, 0.008, 0.03];
/// The longest memory of noise, s: a fifth of a block, so that blocks tell independent things; what is remembered longer is physics.
const LONGEST_MEMORY_S: f64 = 0.05;
/// Share of the noise at low frequencies that stays without a memory at first.
const WHITE_AT_FIRST: f64 = 0.25;

/// The same with a memory for the torque noise of each recording in which that makes a machine likelier by more than two numbers
/// are worth (Schwarz 1978). Where the motion is given, whole test functions average over it, and it stays white.
pub fn coloured_noise(problem: &Problem, physics: &Physics, from: &[Noise]) -> Vec<Noise> {
    each(from, 0..from.len(), |index, from| coloured_one(problem, physics, index, from))
}

fn coloured_one(problem: &Problem, physics: &Physics, index: usize, from: &Noise) -> Option<Noise> {
    if !problem.motions.is_empty() || from.colour.is_some() {
        return None;
    }
    let (prepared, acting) = prepare(problem, physics, index)?;
    let excerpt = Stretches::excerpt(problem, index, &prepared, &acting);
    let period_s = problem.recordings[index].period_s();
    let start = |memory_s: f64| {
        let sd = ((1.0 - WHITE_AT_FIRST) * from.torque_density / (2.0 * memory_s)).sqrt();
        Noise { torque_density: WHITE_AT_FIRST * from.torque_density, colour: Some(Colour { sd, memory_s }), ..*from }
    };
    let starts = FIRST_MEMORIES_S.into_iter().filter(|memory_s| *memory_s > period_s).map(start);
    let scored = starts.map(|noise| (excerpt.score(&noise), noise));
    let (_, first) = scored.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (found, top) = excerpt.likeliest(first, 1.0);
    let rows = excerpt.many();
    (top > excerpt.score(from) + (rows.max(2) as f64).ln()).then_some(found)
}

/// The log-likelihood of the recordings to fit as a look at the excerpts has it, scaled to all rows: enough to rank by. None for a
/// machine the plant refuses or a pass that is not finite.
pub(crate) fn over_excerpts(problem: &Problem, physics: &Physics, noise: &[Noise]) -> Option<f64> {
    let one = |index: usize| {
        let (prepared, acting) = prepare(problem, physics, index)?;
        let excerpt = Stretches::excerpt(problem, index, &prepared, &acting);
        let scale = problem.recordings[index].rows() as f64 / excerpt.many().max(1) as f64;
        Some(scale * excerpt.score(&noise[index])).filter(|score| score.is_finite())
    };
    (0..problem.fitted).into_par_iter().map(one).sum()
}

/// Log-likelihood that is worth another look at the same step.
const RISEN: f64 = 0.5;
/// A step over which the likelihood is a parabola: a quarter of a number's logarithm is off by a fiftieth at its top.
const FINE_OCTAVES: f64 = 0.5;
/// Half of that, for noise that is near its top.
const FINEST_OCTAVES: f64 = 0.25;

/// Where a parabola that is 0 at 0 and falls to `up` at 1 and to `down` at -1 has its top.
fn top_of_parabola(up: f64, down: f64) -> f64 {
    let bent = up + down;
    if bent < 0.0 && bent.is_finite() { (0.5 * (down - up) / bent).clamp(-0.5, 0.5) } else { 0.0 }
}

/// The rows of a recording that its noise is estimated on, under one machine.
struct Stretches<'a> {
    problem: &'a Problem,
    index: usize,
    prepared: &'a Prepared,
    acting: &'a Acting,
    rows: &'a [Range<usize>],
}

impl<'a> Stretches<'a> {
    /// The excerpt.
    fn excerpt(problem: &'a Problem, index: usize, prepared: &'a Prepared, acting: &'a Acting) -> Self {
        Self { problem, index, prepared, acting, rows: &problem.excerpts[index] }
    }

    /// Number of rows.
    fn many(&self) -> usize {
        self.rows.iter().map(Range::len).sum()
    }

    fn score(&self, noise: &Noise) -> f64 {
        let Self { problem, index, prepared, acting, rows } = *self;
        let substeps = problem.grids[index].substeps() / problem.recordings[index].rows().max(1);
        let of = |rows: &Range<usize>| -> f64 {
            let driven = Driven { rows: rows.clone(), ..driven(problem, index, acting) };
            problem.spend(prepared.cost(noise) * rows.len() * substeps);
            prepared.run(driven, noise).log_likelihood.iter().sum()
        };
        let sum: f64 = rows.iter().map(of).sum();
        if sum.is_finite() { sum } else { f64::NEG_INFINITY }
    }

    /// The likeliest noise near another, and its score: along each number while the likelihood rises, in steps of 2^`octaves`, and where
    /// it falls either way to the top of the parabolas through what was scored.
    fn likeliest(&self, from: Noise, octaves: f64) -> (Noise, f64) {
        let mut best = from;
        let mut top = self.score(&best);
        let mut step = octaves;
        loop {
            let before = top;
            let mut tops = Vec::new();
            for which in Which::of(&from) {
                let sides = self.followed(&mut best, &mut top, *which, step);
                tops.extend(sides.map(|[up, down]| (*which, step * top_of_parabola(up - top, down - top))));
            }
            if top - before >= RISEN {
                continue;
            }
            let between = tops.iter().fold(best, |noise, (which, octaves)| self.changed(&noise, *which, *octaves));
            let found = if between == best { top } else { self.score(&between) };
            if found > top {
                (best, top) = (between, found);
            }
            if step <= FINE_OCTAVES {
                return (best, top);
            }
            step = (step / 4.0).max(FINE_OCTAVES);
        }
    }

    /// Follows one number of it up or down, in steps that double, as long as that helps; the scores on both sides, one step up and one
    /// down, where neither does.
    fn followed(&self, best: &mut Noise, top: &mut f64, which: Which, step: f64) -> Option<[f64; 2]> {
        let mut sides = [*top; 2];
        for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
            let mut along = sign * step;
            let began = *top;
            loop {
                let tried = self.changed(best, which, along);
                let found = if tried == *best { *top } else { self.score(&tried) };
                if found <= *top + 1e-3 {
                    *side = found;
                    break;
                }
                (*best, *top) = (tried, found);
                along *= 2.0;
            }
            if *top > began {
                return None;
            }
        }
        Some(sides)
    }

    /// With a standard deviation, or a memory, larger by `octaves` powers of two.
    fn changed(&self, noise: &Noise, which: Which, octaves: f64) -> Noise {
        let factor = octaves.exp2();
        let coloured = |change: &dyn Fn(Colour) -> Colour| Noise { colour: noise.colour.map(change), ..*noise };
        match which {
            Which::Torque => Noise { torque_density: noise.torque_density * factor * factor, ..*noise },
            Which::Sensor => {
                Noise { sensor_sd: (noise.sensor_sd * factor).max(self.problem.least_sensor_sd), ..*noise }
            }
            Which::Coloured => coloured(&|colour| Colour { sd: colour.sd * factor, ..colour }),
            Which::Memory => coloured(&|colour| {
                let shortest_s = self.problem.recordings[self.index].period_s().min(LONGEST_MEMORY_S);
                Colour { memory_s: (colour.memory_s * factor).clamp(shortest_s, LONGEST_MEMORY_S), ..colour }
            }),
        }
    }
}

/// A number of the noise.
#[derive(Clone, Copy)]
enum Which {
    Torque,
    Sensor,
    Coloured,
    Memory,
}

impl Which {
    /// Those that a noise has.
    fn of(noise: &Noise) -> &'static [Self] {
        match noise.colour {
            None => &[Self::Torque, Self::Sensor],
            Some(_) => &[Self::Torque, Self::Sensor, Self::Coloured, Self::Memory],
        }
    }
}
