//! From recordings to the answer.

use super::{Covariance, equivalents, intervals};
use rayon::prelude::*;

use crate::Error;
use crate::effects::{Effect, Physics};
use crate::read::vocabulary;
use crate::refit::{HORIZON_S, Windows};
use crate::read::{AxisKind, Machine, Recording};
use crate::report::{Answer, EffectAnswer, Evidence, FitAnswer, Interval, Rejected, Verdict};
use crate::screen::{Fit, MAX_P, MIN_GAIN, Motion, Outcome, Problem, Refitter, Search};

/// What is to be diagnosed.
#[derive(Debug)]
pub struct Request<'a> {
    /// The nominal model, with the effects it already has.
    pub machine: &'a Machine,
    /// Recordings to fit.
    pub recordings: &'a [Recording],
    /// Recordings that are only predicted; none to hold out blocks of the others.
    pub holdout: &'a [Recording],
    /// Effects that may be named.
    pub vocabulary: &'a [&'static Effect],
}

/// The answer with what it was drawn from.
#[derive(Debug)]
pub struct Diagnosis {
    /// As written to JSON.
    pub answer: Answer,
    /// The nominal machine.
    pub nominal: Physics,
    /// The improved machine.
    pub improved: Physics,
}

/// Diagnoses recordings.
///
/// # Errors
/// Recordings too short to say anything.
pub fn diagnose(request: &Request<'_>) -> Result<Diagnosis, Error> {
    let nominal = Physics::nominal(request.machine);
    let resolution = request.machine.axis.resolution;
    let motions = request.recordings.par_iter().map(|r| Motion::new(r, &nominal, resolution)).collect();
    let mut problem = Problem::new(motions, nominal.clone());
    let linear = request.machine.axis.kind == AxisKind::Linear;
    let mut outcome = Search::new(&problem, request.vocabulary, linear).run(&[]);
    if !outcome.fit.active.is_empty() {
        // The smoother knew the nominal torques only; with those of the improved machine the reversals are where they were.
        let found = problem.machine(&outcome.fit.active);
        let motions = problem.motions.par_iter().enumerate().map(|(index, m)| m.again(&found, index, resolution)).collect();
        problem = Problem::new(motions, nominal.clone());
        outcome = Search::new(&problem, request.vocabulary, linear).run(&outcome.fit.active);
    }
    if std::env::var("DIAG").is_ok() {
        for (i, m) in problem.motions.iter().enumerate() {
            let rest = m.at_rest.iter().filter(|r| **r).count();
            eprintln!("{} cells {} rest {} broken {} noise {:.3e} glitches {}", m.name, m.cells(), rest, m.broken.iter().filter(|b| **b).count(), m.noise, m.glitches.len());
            for w in 0..3 {
                let rows: Vec<f64> = problem.equations.iter().enumerate().filter(|(_, e)| e.recording == i && e.width == w).map(|(k, _)| outcome.nominal.residual[k] / outcome.weights[k]).collect();
                let weights: Vec<f64> = problem.equations.iter().enumerate().filter(|(_, e)| e.recording == i && e.width == w).map(|(k, _)| 1.0 / outcome.weights[k]).collect();
                let after: Vec<f64> = problem.equations.iter().enumerate().filter(|(_, e)| e.recording == i && e.width == w).map(|(k, _)| outcome.fit.residual[k] / outcome.weights[k]).collect();
                let rms = |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
                eprintln!("  width {w}: rows {} nominal rms {:.3e} after {:.3e} sigma {:.3e}", rows.len(), rms(&rows), rms(&after), rms(&weights));
            }
        }
        eprintln!("orders {:?}", outcome.excitation.orders);
    }
    let refitter = Refitter::new(&problem, &outcome);
    let fit = &outcome.fit;
    let covariance = Covariance::new(&problem, fit, refitter.inflation(fit));
    let mut effects: Vec<EffectAnswer> = (0..fit.active.len())
        .map(|index| effect_answer(request, &problem, &refitter, &outcome, &covariance, index))
        .collect();
    effects.sort_by(|a, b| b.evidence.heldout_gain.total_cmp(&a.evidence.heldout_gain));
    let improved = problem.machine(&fit.active);
    let verdict = if effects.is_empty() {
        Verdict::None
    } else if effects.iter().any(|effect| !effect.equivalent.is_empty()) {
        Verdict::Ambiguous
    } else {
        Verdict::Named
    };
    let rejected = outcome.trials.iter().filter(|trial| !fit.active.iter().any(|e| e.effect.id == trial.effect.id));
    let answer = Answer {
        schema: 1,
        verdict,
        effects,
        fit: fit_answer(request, &outcome, &nominal, &improved)?,
        locations: Vec::new(),
        regions: Vec::new(),
        rejected: rejected.map(|t| Rejected { id: t.effect.id.to_owned(), heldout_gain: t.gain, why: why(t.gain, t.p_value) }).collect(),
        experiment: None,
        warnings: Vec::new(),
        residual_map: Vec::new(),
    };
    Ok(Diagnosis { answer, nominal, improved })
}

fn why(gain: f64, p_value: f64) -> String {
    if gain < MIN_GAIN {
        format!("less than {:.0} % less held-out error", 100.0 * MIN_GAIN)
    } else if p_value >= MAX_P {
        format!("not significant after correction, p = {p_value:.1e}")
    } else {
        "another effect predicts better, or as well with fewer parameters".to_owned()
    }
}

fn effect_answer(
    request: &Request<'_>,
    problem: &Problem,
    refitter: &Refitter<'_>,
    outcome: &Outcome,
    covariance: &Covariance,
    index: usize,
) -> EffectAnswer {
    let fit = &outcome.fit;
    let entry = &fit.active[index];
    let mut rest = fit.active.clone();
    rest.remove(index);
    let without: Fit = refitter.fit(&rest);
    let floor = fit.residual_count();
    let evidence = Evidence {
        heldout_gain: 1.0 - (fit.heldout_sse() / without.heldout_sse().max(1e-300)).sqrt(),
        p_value: (refitter.p_value(&without, fit) * outcome.variants as f64).min(1.0),
        excess_explained: explained(without.sse, fit.sse, floor),
    };
    let axis = request.machine.axis.kind;
    let names = vocabulary::effect(entry.effect.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    let values = intervals(fit, covariance, index);
    let parameters = names
        .iter()
        .zip(values)
        .map(|(name, (value, half))| Interval {
            id: name.id(axis).to_owned(),
            value,
            low: value - half,
            high: value + half,
            unit: name.unit(axis).to_owned(),
        })
        .collect();
    let recording = (entry.effect.id == "disturbance_pulse")
        .then(|| problem.motions.get(entry.values[0] as usize).map(|motion| motion.name.clone()))
        .flatten();
    let others = equivalents(refitter, fit, index, request.vocabulary);
    EffectAnswer {
        id: entry.effect.id.to_owned(),
        text: entry.effect.sentence.to_owned(),
        equivalent: others.iter().map(|effect| effect.id.to_owned()).collect(),
        parameters,
        evidence,
        recording,
    }
}

fn fit_answer(request: &Request<'_>, outcome: &Outcome, nominal: &Physics, improved: &Physics) -> Result<FitAnswer, Error> {
    let fitted = request.recordings;
    let (before, after) = (Windows::new(nominal, fitted, 0)?.rms(), Windows::new(improved, fitted, 0)?.rms());
    let first = fitted.len();
    let (heldout_before, heldout_after) = if request.holdout.is_empty() {
        let share = |fit: &Fit| (fit.heldout_sse() / fit.sse.max(1e-300)).sqrt();
        (before * share(&outcome.nominal), after * share(&outcome.fit))
    } else {
        let rms = |physics| Windows::new(physics, request.holdout, first).map(|windows| windows.rms());
        (rms(nominal)?, rms(improved)?)
    };
    let floor = outcome.fit.residual_count();
    let unit = if request.machine.axis.kind == AxisKind::Linear { "m" } else { "rad" };
    Ok(FitAnswer {
        before_rms: before,
        after_rms: after,
        heldout_before_rms: heldout_before,
        heldout_after_rms: heldout_after,
        noise_floor_rms: after * (floor / outcome.fit.sse.max(floor)).sqrt(),
        excess_explained: explained(outcome.nominal.sse, outcome.fit.sse, floor),
        unit: unit.to_owned(),
        horizon_s: HORIZON_S,
    })
}

/// Share of the excess of a sum of squares over a floor that is gone, 1; 1 where there was none.
fn explained(before: f64, after: f64, floor: f64) -> f64 {
    let excess = before - floor.min(after);
    if excess <= 0.0 { 1.0 } else { (before - after) / excess }
}
