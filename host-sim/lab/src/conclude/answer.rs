//! A conclusion as an answer.

use diagnosis::locate::{Region, Span, regions, spans};
use diagnosis::pipeline::{Conclusion, Named};
use diagnosis::problem::Problem;
use diagnosis::verdict as judged;
use diagnosis::windows::window_s;

use crate::read::{AxisKind, vocabulary};
use crate::report::html::measure;
use crate::report::{
    Answer, EffectAnswer, Evidence, FitAnswer, Interval, Location, PredictorAnswer, Rejected, RemainderAnswer, Units,
    Verdict,
};

/// The answer of a conclusion, without warnings.
pub(super) fn answer(problem: &Problem, conclusion: &Conclusion, axis: AxisKind) -> Answer {
    // Against the noise itself: measured from what is left, whatever was gained would be all there is.
    let fit = fit(problem, conclusion, axis);
    let missing = conclusion.verdict != judged::Verdict::None;
    Answer {
        schema: 2,
        verdict: verdict(conclusion.verdict),
        effects: conclusion.effects.iter().map(|named| effect(problem, named, &fit, axis)).collect(),
        locations: if missing {
            spans(problem, conclusion).iter().map(|span| location(problem, span, axis)).collect()
        } else {
            Vec::new()
        },
        regions: if missing {
            regions(problem, conclusion).iter().map(|one| region(one, axis)).collect()
        } else {
            Vec::new()
        },
        rejected: rejected(conclusion),
        remainder: conclusion.remainder.as_ref().map(|left| RemainderAnswer {
            effort_rms: left.torque_rms,
            unit: Units::of(axis).effort.to_owned(),
            unnamed: left.unnamed.iter().map(|effect| effect.id.to_owned()).collect(),
            predictors: left
                .predictors
                .iter()
                .map(|one| PredictorAnswer {
                    channel: channel(one.channel, axis),
                    share: one.share,
                    p_value: one.p_value,
                    effort_rms: one.torque_rms,
                })
                .collect(),
        }),
        fit,
        ..Answer::default()
    }
}

fn verdict(verdict: judged::Verdict) -> Verdict {
    match verdict {
        judged::Verdict::None => Verdict::None,
        judged::Verdict::Named => Verdict::Named,
        judged::Verdict::Ambiguous => Verdict::Ambiguous,
        judged::Verdict::Partial => Verdict::Partial,
        judged::Verdict::Unknown => Verdict::Unknown,
    }
}

fn fit(problem: &Problem, conclusion: &Conclusion, axis: AxisKind) -> FitAnswer {
    let nominal = &conclusion.nominal.windows;
    // Where nothing is added the model is the same, whatever noise was found for it behind the search.
    let best = if conclusion.effects.is_empty() { nominal } else { &conclusion.best.windows };
    let fitted = 0..problem.fitted;
    let held = problem.judged();
    // A floor above what the model leaves is none: the noise was estimated with it.
    let floor =
        |recordings: std::ops::Range<usize>| best.expected_rms(recordings.clone(), 0).min(best.rms(recordings, 0));
    let (before, after, floor_held) = (nominal.rms(held.clone(), 0), best.rms(held.clone(), 0), floor(held.clone()));
    FitAnswer {
        before_rms: nominal.rms(fitted.clone(), 0),
        after_rms: best.rms(fitted.clone(), 0),
        heldout_before_rms: before,
        heldout_after_rms: after,
        noise_floor_rms: floor(fitted),
        heldout_floor_rms: floor_held,
        excess_explained: explained(before, after, floor_held),
        unit: Units::of(axis).position.to_owned(),
        horizon_s: window_s(problem, 0),
    }
}

/// Share of the squares over the floor that is gone.
fn explained(before: f64, after: f64, floor: f64) -> f64 {
    let excess = before * before - floor * floor;
    if excess > 0.0 { ((before * before - after * after) / excess).clamp(0.0, 1.0) } else { 0.0 }
}

fn effect(problem: &Problem, named: &Named, fit: &FitAnswer, axis: AxisKind) -> EffectAnswer {
    let kinds = vocabulary::effect(named.effect.id).map_or(&[][..], |kind| kind.parameters);
    let neutral = (named.effect.neutral)(&problem.nominal);
    let nominal = (neutral.is_finite() && neutral != 0.0).then_some(neutral);
    let without = fit.heldout_after_rms / (1.0 - named.gain).max(1e-9);
    EffectAnswer {
        id: named.effect.id.to_owned(),
        text: named.effect.sentence.to_owned(),
        equivalent: named.equivalent.iter().map(|effect| effect.id.to_owned()).collect(),
        nuisances: named.nuisances.iter().map(|one| one.sentence.to_owned()).collect(),
        parameters: kinds
            .iter()
            .zip(&named.intervals)
            .enumerate()
            .map(|(at, (kind, interval))| Interval {
                id: kind.id(axis).to_owned(),
                value: interval.value,
                low: interval.low,
                high: interval.high,
                unit: kind.unit(axis).to_owned(),
                nominal: nominal.filter(|_| named.effect.leading.contains(&at)),
            })
            .collect(),
        evidence: Evidence {
            heldout_gain: named.gain,
            p_value: named.p_value,
            excess_explained: explained(without, fit.heldout_after_rms, fit.heldout_floor_rms),
        },
        recording: named.recording.and_then(|index| Some(problem.recordings.get(index)?.name.clone())),
    }
}

fn location(problem: &Problem, span: &Span, axis: AxisKind) -> Location {
    let speed = Units::of(axis).speed;
    Location {
        recording: problem.recordings[span.recording].name.clone(),
        start_s: span.start_s,
        end_s: span.end_s,
        share: span.share,
        share_low: span.share_low,
        share_high: span.share_high,
        text: format!("while the axis moves at {} {speed} on average", measure(span.speed)),
    }
}

fn region(region: &Region, axis: AxisKind) -> crate::report::Region {
    crate::report::Region {
        channel: channel(region.channel, axis),
        low: region.low,
        high: region.high,
        share: region.share,
        share_low: region.share_low,
        share_high: region.share_high,
    }
}

/// The name of a channel with the unit of the axis.
fn channel(name: &str, axis: AxisKind) -> String {
    let (position, effort) = match axis {
        AxisKind::Rotary => ("rad", "nm"),
        AxisKind::Linear => ("m", "n"),
    };
    match name {
        "speed" => format!("speed_{position}_s"),
        "position" => format!("position_{position}"),
        "torque" | "torque_rate" => format!("{name}_{effort}"),
        "field" => "field_kv_mm".to_owned(),
        "time" => "time_s".to_owned(),
        other => other.to_owned(),
    }
}

/// What was refitted beside the best hypothesis and not taken.
fn rejected(conclusion: &Conclusion) -> Vec<Rejected> {
    let one = |one: &diagnosis::search::Rejected| Rejected {
        id: one.effect.id.to_owned(),
        heldout_gain: one.gain,
        why: why(one),
    };
    conclusion.rejected.iter().filter(|one| one.rise > 0.0).map(one).collect()
}

/// Why it was not taken.
fn why(one: &diagnosis::search::Rejected) -> String {
    let certainly = if one.certain { "certainly " } else { "" };
    let adds = format!("it would {certainly}add {:.1} to the log-likelihood", one.rise);
    match (one.certain, one.gain) {
        (_, Some(gain)) if gain < 0.0 => format!("{adds}, but predict the held-out motion worse"),
        (true, _) => format!("{adds}, but too little to the motion to be named"),
        (false, _) => format!("{adds}, no more than its free values and the scatter from block to block may"),
    }
}

/// What the user should know before believing the answer; where it is told already what to do next, not another time.
pub(super) fn warnings(problem: &Problem, conclusion: &Conclusion, next: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(band_hz) = problem.band_hz() {
        warnings.push(format!(
            "the machine file models no delay of the drive and no fluid, so the torque column may be a measurement: judged by what \
             torque the motion needs, up to {band_hz:.0} Hz"
        ));
    }
    if problem.fitted == problem.recordings.len() {
        let message = "no recording was held out: what is said of held-out data is of what was fitted; --holdout FILE keeps one apart";
        warnings.push(message.to_owned());
    }
    let stand = |standing| conclusion.effects.iter().filter(move |one| one.standing == standing);
    if conclusion.verdict == judged::Verdict::Ambiguous && stand(judged::Standing::Contested).next().is_some() {
        let otherwise = "; another motion or a direct measurement (weighing, a torque sensor) tells them apart";
        warnings.push(format!(
            "what the alternatives predict differs by less than these recordings' noise{}",
            if next { "" } else { otherwise }
        ));
    }
    warnings.extend(conclusion.at_an_end(problem).map(|one| {
        format!(
            "{}: its value is the last that is looked at, and the true one may lie beyond its interval; look at what was taken for \
             known, as units and the machine file's inertia",
            one.effect.id
        )
    }));
    if conclusion.cut_short {
        warnings.push("the search ended at its budget of work: less was tried than would have been".to_owned());
        let left: Vec<&str> = stand(judged::Standing::NotCompared).map(|one| one.effect.id).collect();
        if !left.is_empty() {
            warnings.push(format!(
                "not compared with all that may stand in its place: {}; fewer or shorter recordings leave work for it",
                left.join(", ")
            ));
        }
    }
    warnings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_explained_is_that_of_the_excess_over_the_noise() {
        for (before, after, floor, share) in [
            (10.0, 1.0, 1.0, 1.0),
            (10.0, 5.0, 0.0, 0.75),
            (41.96, 41.63, 1.0, 0.0157),
            (41.96, 41.63, 41.7, 1.0),
            // Nothing is in excess of the noise, nothing is explained.
            (41.96, 41.63, 50.0, 0.0),
            (1.0, 1.0, 1.0, 0.0),
            (0.0, 0.0, 0.0, 0.0),
            // Worse than before.
            (10.0, 11.0, 1.0, 0.0),
        ] {
            let found = explained(before, after, floor);
            assert!((found - share).abs() < 1e-3, "{before} to {after} over {floor}: {found}");
        }
    }
}
