//! The log-likelihood of a hypothesis, block by block, and the noise that goes with it.

use rayon::prelude::*;

use crate::likelihood::filter::{Driven, Innovations, Path, Prepared};
use crate::likelihood::{Acting, Noise};
use crate::physics::Physics;
use crate::problem::Problem;

/// What the recordings leave under one hypothesis.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// One a recording.
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

/// The log-likelihood of a machine under a noise; none for a machine the plant refuses or a pass that is not finite.
pub fn evaluate(problem: &Problem, physics: &Physics, noise: &Noise) -> Option<Evaluation> {
    let all: Option<Vec<(Innovations, Vec<f64>)>> = (0..problem.recordings.len())
        .into_par_iter()
        .map(|index| {
            let acting = Acting::new(physics, index, &problem.recordings[index], &problem.grids[index])?;
            let prepared = Prepared::new(physics, index);
            problem.spend(problem.grids[index].substeps());
            let innovations = prepared.run(driven(problem, index, &acting), noise);
            let blocks = blocks(problem, index, &innovations);
            blocks.iter().all(|block| block.is_finite()).then_some((innovations, blocks))
        })
        .collect();
    let (innovations, blocks) = all?.into_iter().unzip();
    Some(Evaluation { innovations, blocks })
}

pub(crate) fn driven<'a>(problem: &'a Problem, index: usize, acting: &'a Acting) -> Driven<'a> {
    let recorded = &problem.recordings[index];
    Driven { recorded, grid: &problem.grids[index], acting, rows: 0..recorded.rows() }
}

/// A pass over the recordings to fit that can be linearised along.
pub(crate) struct Kept {
    pub(crate) physics: Physics,
    pub(crate) noise: Noise,
    pub(crate) recordings: Vec<KeptRecording>,
}

pub(crate) struct KeptRecording {
    pub(crate) prepared: Prepared,
    pub(crate) acting: Acting,
    pub(crate) innovations: Innovations,
    pub(crate) path: Path,
}

/// Runs over the first `many` recordings and keeps the paths.
pub(crate) fn kept(problem: &Problem, physics: &Physics, noise: &Noise, many: usize) -> Option<Kept> {
    let recordings: Option<Vec<KeptRecording>> = (0..many)
        .into_par_iter()
        .map(|index| {
            let acting = Acting::new(physics, index, &problem.recordings[index], &problem.grids[index])?;
            let prepared = Prepared::new(physics, index);
            problem.spend(problem.grids[index].substeps());
            let (innovations, path) = prepared.run_kept(driven(problem, index, &acting), noise);
            Some(KeptRecording { prepared, acting, innovations, path })
        })
        .collect();
    Some(Kept { physics: physics.clone(), noise: *noise, recordings: recordings? })
}

impl Kept {
    /// Log-likelihood of the recordings.
    pub(crate) fn log_likelihood(&self) -> f64 {
        self.recordings.iter().flat_map(|kept| &kept.innovations.log_likelihood).sum()
    }

    /// Response of the whitened innovations of every row of every recording to another machine; none where the plant refuses it.
    pub(crate) fn response(&self, problem: &Problem, other: &Physics) -> Option<Vec<Vec<f64>>> {
        let same = same_actuation(&self.physics, other);
        let one = |(index, kept): (usize, &KeptRecording)| {
            let acting = if same {
                None
            } else {
                Some(Acting::new(other, index, &problem.recordings[index], &problem.grids[index])?)
            };
            let prepared = Prepared::new(other, index);
            let driven = driven(problem, index, acting.as_ref().unwrap_or(&kept.acting));
            problem.spend(problem.grids[index].substeps());
            let column = prepared.response(&kept.prepared, &kept.path, driven);
            column.iter().all(|value| value.is_finite()).then_some(column)
        };
        self.recordings.iter().enumerate().map(one).collect()
    }
}

/// Whether the same acts on the rotor in both.
fn same_actuation(one: &Physics, other: &Physics) -> bool {
    let drive = |p: &Physics| {
        let m = &p.model;
        (
            (m.torque_gain, m.torque_offset, m.torque_limit, m.torque_deadband),
            (m.torque_delay_s, m.torque_lag_s, m.sensor.latency_s, p.skew_s, p.torque_filter_s),
        )
    };
    drive(one) == drive(other)
        && one.model.er == other.model.er
        && one.pushes == other.pushes
        && one.tone == other.tone
        && other.model.validate().is_ok()
}

/// Memory of the coloured torque noise, s. What is slower than a few of these is motion the model must explain.
pub(crate) const COLOUR_S: f64 = 0.02;

/// The noise under which a machine is most likely on the recordings to fit, searched from `from` in steps of ln 2^`octaves`
/// downwards.
pub fn noise_of(problem: &Problem, physics: &Physics, from: &Noise, octaves: f64) -> Noise {
    let prepared: Option<Vec<(Acting, Prepared)>> = (0..problem.fitted)
        .map(|index| {
            let acting = Acting::new(physics, index, &problem.recordings[index], &problem.grids[index])?;
            Some((acting, Prepared::new(physics, index)))
        })
        .collect();
    let Some(prepared) = prepared else { return *from };
    let score = |noise: &Noise| {
        let one = |(index, rows): &(usize, std::ops::Range<usize>)| -> f64 {
            let (acting, prepared) = &prepared[*index];
            let driven = Driven { rows: rows.clone(), ..driven(problem, *index, acting) };
            problem.spend(rows.len() * problem.grids[*index].substeps() / problem.recordings[*index].rows().max(1));
            prepared.run(driven, noise).log_likelihood.iter().sum()
        };
        let sum: f64 = problem.excerpt.par_iter().map(one).collect::<Vec<f64>>().iter().sum();
        if sum.is_finite() { sum } else { f64::NEG_INFINITY }
    };
    let mut best = *from;
    let mut top = score(&best);
    let mut step = octaves;
    while step > 0.1 {
        let before = top;
        for which in 0..3 {
            // A direction that helps is followed in steps that double.
            for sign in [1.0, -1.0] {
                let mut along = sign * step;
                let began = top;
                loop {
                    let tried = changed(&best, which, along, problem.least_sensor_sd);
                    let found = if tried == best { top } else { score(&tried) };
                    if found <= top + 1e-3 {
                        break;
                    }
                    (best, top) = (tried, found);
                    along *= 2.0;
                }
                if top > began {
                    break;
                }
            }
        }
        if top - before < 0.5 {
            step *= 0.5;
        }
    }
    best
}

/// With the standard deviation at `which` larger by `octaves` powers of two.
fn changed(noise: &Noise, which: usize, octaves: f64, least_sensor_sd: f64) -> Noise {
    let factor = octaves.exp2();
    match which {
        0 => Noise { torque_density: noise.torque_density * factor * factor, ..*noise },
        1 => Noise { sensor_sd: (noise.sensor_sd * factor).max(least_sensor_sd), ..*noise },
        _ => Noise { colour_sd: noise.colour_sd * factor, ..*noise },
    }
}
