//! The answer in words.

use std::fmt::Write;

use super::{Answer, EffectAnswer, FitAnswer, RemainderAnswer, Verdict};

/// A few lines that say what the answer says.
pub fn summary(answer: &Answer) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_summary(&mut text, answer);
    text
}

fn write_summary(text: &mut String, answer: &Answer) -> std::fmt::Result {
    let headline = match answer.verdict {
        Verdict::None => "Nothing is missing from the model beyond the noise of these recordings.",
        Verdict::Named => "This is missing from the model:",
        Verdict::Ambiguous => "Something is missing, and these recordings cannot tell which of these it is:",
        Verdict::Partial => "This is missing from the model, and something more that is not explained:",
        Verdict::Unknown => "Something is missing, and nothing in the vocabulary explains it.",
        Verdict::Controller => "The recorded commands are not what this control law computes; no physics is named.",
    };
    writeln!(text, "{headline}")?;
    if !answer.verdict.believes_its_effects() && !answer.effects.is_empty() {
        writeln!(text, "\nFitted, but not believed:")?;
    }
    answer.effects.iter().try_for_each(|effect| write_effect(text, effect))?;
    write_fit(text, &answer.fit)?;
    if let Some(left) = &answer.remainder {
        write_remainder(text, left)?;
    }
    for location in answer.locations.iter().take(3) {
        let (from, to) = (location.start_s, location.end_s);
        writeln!(
            text,
            "{:.0} % ({:.0} to {:.0} %) of the excess at {from:.2} to {to:.2} s of {}: {}",
            100.0 * location.share,
            100.0 * location.share_low,
            100.0 * location.share_high,
            location.recording,
            location.text
        )?;
    }
    if let Some(experiment) = &answer.experiment {
        writeln!(text, "Next: {}", experiment.text)?;
    }
    for warning in &answer.warnings {
        writeln!(text, "Warning: {warning}")?;
    }
    Ok(())
}

/// A share in per cent with one decimal, never rounded up: what is nearly the whole is not all of it.
pub(super) fn per_cent(share: f64) -> String {
    format!("{:.1}", (1000.0 * share + 1e-9).floor() / 10.0)
}

/// An effect with its values and why it is believed.
fn write_effect(text: &mut String, effect: &EffectAnswer) -> std::fmt::Result {
    writeln!(text, "\n{}: {}", effect.id, effect.text)?;
    for p in &effect.parameters {
        writeln!(text, "  {} = {:.6} ({:.6} to {:.6}) {}", p.id, p.value, p.low, p.high, p.unit)?;
    }
    let e = effect.evidence;
    writeln!(
        text,
        "  held-out error {} % less, p = {:.1e}, explains {} % of the excess",
        per_cent(e.heldout_gain),
        e.p_value,
        per_cent(e.excess_explained)
    )?;
    if !effect.equivalent.is_empty() {
        writeln!(text, "  these recordings cannot tell it from: {}", effect.equivalent.join(", "))?;
    }
    Ok(())
}

/// Windows before and after.
fn write_fit(text: &mut String, fit: &FitAnswer) -> std::fmt::Result {
    writeln!(
        text,
        "\nWindows of {} s, rms in {}: {:.3e} before, {:.3e} after, noise {:.3e}; \
         held out {:.3e} before, {:.3e} after, noise {:.3e}.",
        fit.horizon_s,
        fit.unit,
        fit.before_rms,
        fit.after_rms,
        fit.noise_floor_rms,
        fit.heldout_before_rms,
        fit.heldout_after_rms,
        fit.heldout_floor_rms
    )
}

/// What is left, and what predicts it.
fn write_remainder(text: &mut String, left: &RemainderAnswer) -> std::fmt::Result {
    writeln!(
        text,
        "Left: {:.3} {} rms, some of which the values above may have absorbed.",
        left.effort_rms, left.unit
    )?;
    if !left.unnamed.is_empty() {
        writeln!(text, "  traces of: {}", left.unnamed.join(", "))?;
    }
    for one in &left.predictors {
        let (share, p) = (per_cent(one.share), one.p_value);
        writeln!(
            text,
            "  {} predicts {share} % of its squares (p = {p:.1e}), {:.3} {} rms",
            one.channel, one.effort_rms, left.unit
        )?;
    }
    Ok(())
}
