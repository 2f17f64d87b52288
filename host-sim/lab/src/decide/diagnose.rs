//! From recordings to the answer.

use rayon::prelude::*;

use super::controller::mismatch;
use super::{Covariance, equivalents, intervals};
use crate::Error;
use crate::effects::{Effect, Physics};
use crate::locate::{Leftover, leftover, locations, regions, residual_map};
use crate::propose::{Proposal, for_ambiguous};
use crate::read::vocabulary;
use crate::read::{AxisKind, Machine, Recording};
use crate::refit::{HORIZON_S, Windows};
use crate::report::{Answer, EffectAnswer, Evidence, FitAnswer, Interval, Rejected, Verdict};
use crate::screen::{Fit, MAX_P, MIN_GAIN, Motion, Outcome, Problem, Refitter, Search, Trial};

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
    /// What to record next, where the verdict is ambiguous.
    pub proposal: Option<Proposal>,
}

/// Share of the excess that a model must explain to be named: substitutes explain 0.5 in the median and 0.8 at the 95th
/// percentile (diagnosis.md).
const EXPLAINS: f64 = 0.85;

/// Diagnoses recordings.
///
/// # Errors
/// Recordings too short to say anything.
pub fn diagnose(request: &Request<'_>) -> Result<Diagnosis, Error> {
    let files: Vec<&Recording> = request.recordings.iter().chain(request.holdout).collect();
    let names: Vec<&str> = files.iter().map(|recording| recording.name.as_str()).collect();
    let nominal = Physics::of(request.machine, &names)?;
    let mut warnings: Vec<String> = files.iter().flat_map(|recording| recording.notes()).collect();
    let axis = request.machine.axis.kind;
    let (problem, outcome) = search(request, &nominal);
    if problem.equations.is_empty() {
        let message = "nothing moves long enough in one direction to be judged; record more motion".to_owned();
        return Err(Error::Usage(format!("{}: {message}", names.join(", "))));
    }
    let fit = &outcome.fit;
    let improved = problem.machine(&fit.active);
    let controller = request.machine.controller.as_ref().and_then(|law| mismatch(law, &files, &mut warnings));
    let left = leftover(&problem, fit, axis);
    let (verdict, effects) = match controller {
        Some(answer) => (Verdict::Controller, vec![answer]),
        None => decide(request, &problem, &outcome, &left),
    };
    warn(&problem, fit, &left, verdict, &mut warnings);
    let map =
        if verdict == Verdict::Unknown { residual_map(&problem, fit, &outcome.weights, axis) } else { Vec::new() };
    let proposal = (verdict == Verdict::Ambiguous)
        .then(|| for_ambiguous(request.machine, request.recordings, &problem, &outcome, &effects))
        .flatten();
    let answer = Answer {
        schema: 1,
        verdict,
        fit: fit_answer(request, &outcome, &nominal, &improved)?,
        locations: if verdict == Verdict::None { Vec::new() } else { locations(&problem, &outcome.nominal) },
        regions: if verdict == Verdict::None { Vec::new() } else { regions(&problem, &outcome.nominal, axis) },
        rejected: rejected(request, &outcome, &effects),
        effects,
        experiment: proposal.as_ref().map(Proposal::experiment),
        warnings,
        residual_map: map,
    };
    Ok(Diagnosis { answer, nominal, improved, proposal })
}

/// Searches twice: the smoother knew the nominal torques only; with those of the improved machine reversals are where they
/// were.
fn search(request: &Request<'_>, nominal: &Physics) -> (Problem, Outcome) {
    let linear = request.machine.axis.kind == AxisKind::Linear;
    let resolution = request.machine.axis.resolution;
    let motions = request.recordings.par_iter().map(|r| Motion::new(r, nominal, resolution)).collect();
    let problem = Problem::new(motions, nominal.clone());
    let outcome = Search::new(&problem, request.vocabulary, linear).run(&[]);
    if outcome.fit.active.is_empty() {
        return (problem, outcome);
    }
    let found = problem.machine(&outcome.fit.active);
    let motions = problem.motions.par_iter().enumerate().map(|(index, m)| m.again(&found, index, resolution)).collect();
    let problem = Problem::new(motions, nominal.clone());
    let outcome = Search::new(&problem, request.vocabulary, linear).run(&outcome.fit.active);
    (problem, outcome)
}

/// Verdict and effects where the controller is right or not known.
fn decide(
    request: &Request<'_>,
    problem: &Problem,
    outcome: &Outcome,
    left: &Leftover,
) -> (Verdict, Vec<EffectAnswer>) {
    let fit = &outcome.fit;
    let refitter = Refitter::new(problem, outcome);
    let covariance = Covariance::new(problem, fit, refitter.inflation(fit));
    let mut effects: Vec<EffectAnswer> = (0..fit.active.len())
        .map(|index| effect_answer(request, problem, &refitter, outcome, &covariance, index))
        .collect();
    effects.extend(glitches(request, problem));
    effects.sort_by(|a, b| b.evidence.heldout_gain.total_cmp(&a.evidence.heldout_gain));
    let explains = explained(outcome.nominal.sse, fit.sse, fit.residual_count());
    // Far above the noise is something, even where no channel of state predicts it.
    let structured = left.excess > 2.5 || left.gain >= MIN_GAIN && left.excess > 1.5;
    let verdict = if fit.active.is_empty() && structured || !fit.active.is_empty() && explains < EXPLAINS {
        Verdict::Unknown
    } else if effects.is_empty() {
        Verdict::None
    } else if effects.iter().any(|effect| !effect.equivalent.is_empty()) {
        Verdict::Ambiguous
    } else {
        Verdict::Named
    };
    (verdict, effects)
}

/// Isolated wrong samples, as an effect; a single one is an accident.
fn glitches(request: &Request<'_>, problem: &Problem) -> Option<EffectAnswer> {
    let kind = request.vocabulary.iter().find(|effect| effect.id == "sensor_glitch")?;
    let sizes: Vec<f64> =
        problem.motions.iter().flat_map(|m| m.glitches.iter().map(|glitch| glitch.size.abs())).collect();
    let samples: usize = problem.motions.iter().map(|m| m.cells() + 1).sum();
    if sizes.len() < 5 {
        return None;
    }
    let (count, samples) = (sizes.len() as f64, samples as f64);
    let fraction = count / samples;
    let mean = sizes.iter().sum::<f64>() / count;
    let deviation = (sizes.iter().map(|size| (size - mean).powi(2)).sum::<f64>() / (count - 1.0) / count).sqrt();
    let names = vocabulary::effect(kind.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    // A count is Poisson.
    let values = [(fraction, 1.96 * count.sqrt() / samples), (mean, 1.96 * deviation)];
    let evidence = Evidence { heldout_gain: 0.0, p_value: 0.0, excess_explained: 1.0 };
    Some(EffectAnswer {
        id: kind.id.to_owned(),
        text: kind.sentence.to_owned(),
        equivalent: Vec::new(),
        parameters: parameters(names, &values, request.machine.axis.kind),
        evidence,
        recording: None,
    })
}

fn parameters(names: &[vocabulary::Parameter], values: &[(f64, f64)], axis: AxisKind) -> Vec<Interval> {
    let pairs = names.iter().zip(values);
    pairs
        .map(|(name, &(value, half))| Interval {
            id: name.id(axis).to_owned(),
            value,
            low: value - half,
            high: value + half,
            unit: name.unit(axis).to_owned(),
        })
        .collect()
}

/// What the user should know before believing the answer.
fn warn(problem: &Problem, fit: &Fit, left: &Leftover, verdict: Verdict, warnings: &mut Vec<String>) {
    if left.excess > 3.0 && verdict != Verdict::Unknown {
        warnings.push(format!(
            "{:.1} times the estimated noise is still left after the best model, most of it over {}",
            left.excess.sqrt(),
            if left.channel.is_empty() { "no channel of state" } else { &left.channel }
        ));
    }
    for entry in &fit.active {
        for (value, range) in entry.values.iter().zip(&entry.ranges) {
            let near = |bound: f64| bound.is_finite() && (value - bound).abs() <= 1e-6 * range.scale;
            if near(range.high) || near(range.low) && range.low != 0.0 {
                warnings
                    .push(format!("{}: a value stands at the bound of what was searched, {value}", entry.effect.id));
            }
        }
    }
    let repaired: usize = problem.motions.iter().map(|m| m.glitches.len()).sum();
    if repaired > 0 {
        warnings.push(format!("{repaired} isolated wrong position samples were left out"));
    }
    warnings.push("no clean synthetic twin of these recordings was run in this version".to_owned());
}

fn rejected(request: &Request<'_>, outcome: &Outcome, effects: &[EffectAnswer]) -> Vec<Rejected> {
    let axis = request.machine.axis.kind;
    let open = outcome.trials.iter().filter(|trial| !effects.iter().any(|effect| effect.id == trial.effect.id));
    open.map(|trial| Rejected { id: trial.effect.id.to_owned(), heldout_gain: trial.gain, why: why(trial, axis) })
        .collect()
}

fn why(trial: &Trial, axis: AxisKind) -> String {
    if trial.gain < MIN_GAIN {
        return format!("less than {:.0} % less held-out error", 100.0 * MIN_GAIN);
    }
    if trial.p_value >= MAX_P {
        return format!("not significant after correction, p = {:.1e}", trial.p_value);
    }
    if !trial.accepted() {
        return format!("its gain is not in enough of the blocks, t = {:.1} over blocks", trial.t);
    }
    let names = vocabulary::effect(trial.effect.id).map_or(&[] as &[vocabulary::Parameter], |kind| kind.parameters);
    let values = trial.fit.active.last().map_or(Vec::new(), |entry| (entry.effect.report)(&entry.values));
    let found: Vec<String> =
        names.iter().zip(values).map(|(name, value)| format!("{} = {value:.5}", name.id(axis))).collect();
    format!("another effect predicts better, or as well with fewer parameters; alone it would be {}", found.join(", "))
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
    let parameters = parameters(names, &values, axis);
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

fn fit_answer(
    request: &Request<'_>,
    outcome: &Outcome,
    nominal: &Physics,
    improved: &Physics,
) -> Result<FitAnswer, Error> {
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
