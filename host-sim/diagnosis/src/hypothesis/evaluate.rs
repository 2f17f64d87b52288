//! The log-likelihood of a hypothesis, block by block, and the noise that goes with it.

use std::ops::Range;

use rayon::prelude::*;

use crate::likelihood::filter::{Driven, HUBER, Innovations, Path, Prepared};
use crate::likelihood::inverse::{Motion, Residual};
use crate::likelihood::{Acting, Noise, Window};
use crate::physics::Physics;
use crate::problem::Problem;

/// What the recordings leave under one hypothesis.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// One a recording looked at.
    pub innovations: Vec<Innovations>,
    /// Log-likelihood of each block of each recording.
    pub blocks: Vec<Vec<f64>>,
}

impl Evaluation {
    /// Log-likelihood of the recordings to fit.
    pub fn fitted(&self, problem: &Problem) -> f64 {
        self.blocks[..problem.fitted].iter().flatten().sum()
    }
}

fn blocks(problem: &Problem, recording: usize, innovations: &Innovations) -> Vec<f64> {
    problem.blocks[recording].iter().map(|block| innovations.log_likelihood[block.clone()].iter().sum()).collect()
}

/// The log-likelihood of some recordings under a machine and the noise of each, one behind the other; none for a machine the plant
/// refuses or a pass that is not finite.
pub fn evaluate(problem: &Problem, physics: &Physics, noise: &[Noise], which: Range<usize>) -> Option<Evaluation> {
    let one = |index: usize| {
        let (prepared, acting) = prepare(problem, physics, index)?;
        let (innovations, _) = pass(problem, index, &prepared, &acting, &noise[index], Keep::Innovations);
        let blocks = blocks(problem, index, &innovations);
        blocks.iter().all(|block| block.is_finite()).then_some((innovations, blocks))
    };
    let all: Option<Vec<(Innovations, Vec<f64>)>> = which.into_par_iter().map(one).collect();
    let (innovations, blocks) = all?.into_iter().unzip();
    Some(Evaluation { innovations, blocks })
}

pub(super) fn prepare(problem: &Problem, physics: &Physics, index: usize) -> Option<(Prepared, Acting)> {
    Some((Prepared::new(physics, index, problem.step), acting(problem, physics, index)?))
}

/// What is kept of a pass.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keep {
    Innovations,
    Path,
}

/// What one recording leaves; with the filter's path where that is kept and the motion is not given.
fn pass(
    problem: &Problem,
    index: usize,
    prepared: &Prepared,
    acting: &Acting,
    noise: &Noise,
    keep: Keep,
) -> (Innovations, Option<Path>) {
    if let Some(motion) = problem.motions.get(index) {
        let residual = residual(problem, index, motion, prepared, acting);
        return (prepared.whiten(motion, &problem.recordings[index], &residual, noise), None);
    }
    problem.spend(prepared.cost(noise) * problem.grids[index].substeps());
    let driven = driven(problem, index, acting);
    if keep == Keep::Innovations {
        return (prepared.run(driven, noise), None);
    }
    let (innovations, path) = prepared.run_kept(driven, noise);
    (innovations, Some(path))
}

/// What acts in a recording.
fn acting(problem: &Problem, physics: &Physics, index: usize) -> Option<Acting> {
    let (recorded, grid) = (&problem.recordings[index], &problem.grids[index]);
    Acting::new(physics, index, recorded, grid, problem.early_s[index], &problem.lately[index])
}

/// What a look along a given motion costs of a filter's substep: measured, a row against four substeps.
const OF_A_SUBSTEP: usize = 10;

pub(super) fn residual(
    problem: &Problem,
    index: usize,
    motion: &Motion,
    prepared: &Prepared,
    acting: &Acting,
) -> Residual {
    problem.spend(problem.grids[index].substeps() / OF_A_SUBSTEP);
    prepared.residual(motion, &problem.recordings[index], &problem.grids[index], acting)
}

pub(crate) fn driven<'a>(problem: &'a Problem, index: usize, acting: &'a Acting) -> Driven<'a> {
    let recorded = &problem.recordings[index];
    Driven { recorded, grid: &problem.grids[index], acting, rows: 0..recorded.rows() }
}

/// A pass over the recordings to fit that can be linearised along.
pub(crate) struct Kept {
    pub(crate) physics: Physics,
    pub(crate) noise: Vec<Noise>,
    pub(crate) recordings: Vec<KeptRecording>,
}

pub(crate) struct KeptRecording {
    pub(crate) prepared: Prepared,
    pub(crate) acting: Acting,
    pub(crate) innovations: Innovations,
    /// None where the motion is given.
    path: Option<Path>,
}

/// Runs over the first `many` recordings and keeps the paths.
pub(crate) fn kept(problem: &Problem, physics: &Physics, noise: &[Noise], many: usize) -> Option<Kept> {
    let one = |index: usize| {
        let (prepared, acting) = prepare(problem, physics, index)?;
        let (innovations, path) = pass(problem, index, &prepared, &acting, &noise[index], Keep::Path);
        Some(KeptRecording { prepared, acting, innovations, path })
    };
    let recordings: Option<Vec<KeptRecording>> = (0..many).into_par_iter().map(one).collect();
    Some(Kept { physics: physics.clone(), noise: noise.to_vec(), recordings: recordings? })
}

/// Product of two columns under the weights of their rows.
pub(crate) fn product(weight: &[f64], one: &[f64], other: &[f64]) -> f64 {
    weight.iter().zip(one).zip(other).map(|((weight, one), other)| weight * one * other).sum()
}

impl Kept {
    /// The whitened innovation of every row and its weight in a regression, 0 where it does not count and Huber's else; recordings one
    /// behind the other.
    pub(crate) fn weighted(&self) -> (Vec<f64>, Vec<f64>) {
        let rows = self.recordings.iter().map(|kept| &kept.innovations);
        let pairs = rows.flat_map(|found| found.whitened.iter().zip(&found.counted));
        let weight = |whitened: f64, counted: bool| if counted { (HUBER / whitened.abs()).min(1.0) } else { 0.0 };
        pairs.map(|(whitened, counted)| (*whitened, weight(*whitened, *counted))).unzip()
    }

    /// Response of the whitened innovations of every row of every recording to another machine; none where the plant refuses it.
    pub(crate) fn response(&self, problem: &Problem, other: &Physics) -> Option<Vec<Vec<f64>>> {
        let one = |(index, kept): (usize, &KeptRecording)| {
            let (prepared, acting) = prepare(problem, other, index)?;
            let column = match (&kept.path, problem.motions.get(index)) {
                (None, Some(motion)) => {
                    let residual = residual(problem, index, motion, &prepared, &acting);
                    let recorded = &problem.recordings[index];
                    prepared.difference(&kept.innovations, motion, recorded, &residual, &self.noise[index])
                }
                (path, _) => {
                    problem.spend(prepared.cost(&self.noise[index]) * problem.grids[index].substeps());
                    prepared.response(&kept.prepared, path.as_ref()?, driven(problem, index, &acting))
                }
            };
            column.iter().all(|value| value.is_finite()).then_some(column)
        };
        self.recordings.iter().enumerate().map(one).collect()
    }

    /// Response of the whitened innovations of one recording to a torque beside those of the machine, N m (N), one a row.
    pub(crate) fn response_to_torque(&self, problem: &Problem, index: usize, torques: &[f64]) -> Vec<f64> {
        let kept = &self.recordings[index];
        match (&kept.path, problem.motions.get(index)) {
            (None, Some(motion)) => {
                let recorded = &problem.recordings[index];
                kept.prepared.response_to_torque_along(motion, recorded, &self.noise[index], torques)
            }
            (Some(path), _) => {
                problem.spend(kept.prepared.cost(&self.noise[index]) * problem.grids[index].substeps());
                kept.prepared.response_to_torque(path, driven(problem, index, &kept.acting), torques)
            }
            (None, None) => vec![0.0; torques.len()],
        }
    }

    /// Windows of `horizon` rows of one recording, each simulated from the state that was estimated at its start.
    pub(crate) fn windows(&self, problem: &Problem, index: usize, horizon: usize) -> Vec<Window> {
        let kept = &self.recordings[index];
        let driven = driven(problem, index, &kept.acting);
        if kept.path.is_some() {
            problem.spend(kept.prepared.cost(&self.noise[index]) * driven.grid.substeps());
        }
        match (&kept.path, problem.motions.get(index)) {
            (Some(path), _) => kept.prepared.windows(path, driven, &self.noise[index], horizon),
            (None, Some(motion)) => kept.prepared.windows_along(motion, driven, &self.noise[index], horizon),
            (None, None) => Vec::new(),
        }
    }

    /// The torque that is missing in each substep of one recording, as [`Prepared::missing_torque`] has it.
    pub(crate) fn missing_torque(&self, problem: &Problem, index: usize) -> Vec<f64> {
        let kept = &self.recordings[index];
        let grid = &problem.grids[index];
        match (&kept.path, problem.motions.get(index)) {
            (Some(path), _) => kept.prepared.missing_torque(path, &kept.innovations, grid),
            (None, Some(motion)) => kept.prepared.missing_along(motion, grid, &kept.innovations, &self.noise[index]),
            (None, None) => vec![0.0; grid.substeps()],
        }
    }
}
