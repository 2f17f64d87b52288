//! The answer in words.

use std::fmt::Write;

use super::html::{measure, nominal, number, p_value};
use super::{Answer, EffectAnswer, FitAnswer, Interval, Location, RemainderAnswer, Verdict, shown};

/// Lines of the longest answer: what a terminal shows at once.
const MOST_LINES: usize = 40;

/// How much of each effect is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// What it is, its values, why it is believed, what it may be instead.
    All,
    /// One line: its values, and what it may be instead.
    Line,
}

/// At most forty lines that say what the answer says; of a long one what is left out is in the JSON and on the page.
pub fn summary(answer: &Answer) -> String {
    let written = |detail| {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = write_summary(&mut text, answer, detail);
        text
    };
    let text = written(Detail::All);
    if text.lines().count() <= MOST_LINES {
        return text;
    }
    let text = written(Detail::Line);
    let lines: Vec<&str> = text.lines().collect();
    if lines.len() <= MOST_LINES {
        return text;
    }
    let (shown, rest) = lines.split_at(MOST_LINES - 1);
    format!("{}\n... and {} more lines: --html FILE and --json FILE have all of it\n", shown.join("\n"), rest.len())
}

fn write_summary(text: &mut String, answer: &Answer, detail: Detail) -> std::fmt::Result {
    let headline = match answer.verdict {
        Verdict::None => "Nothing is missing from the model beyond the noise of these recordings.",
        Verdict::Named => "This is missing from the model:",
        Verdict::Ambiguous if !answer.offers_a_choice() => {
            "Something is missing, likely this, but not all that may stand in its place was compared:"
        }
        Verdict::Ambiguous if answer.remainder.is_some() => {
            "Something is missing, these recordings cannot tell which of these it is, and something more is not explained:"
        }
        Verdict::Ambiguous => "Something is missing, and these recordings cannot tell which of these it is:",
        Verdict::Partial => "This is missing from the model, and something more that is not explained:",
        Verdict::Unknown => "Something is missing, and nothing in the vocabulary explains it.",
        Verdict::Controller => "The recorded commands are not what this control law computes; no physics is named.",
    };
    writeln!(text, "{headline}")?;
    match detail {
        Detail::All => answer.effects.iter().try_for_each(|effect| write_effect(text, effect))?,
        Detail::Line => answer.effects.iter().try_for_each(|effect| write_line(text, effect))?,
    }
    write_fit(text, &answer.fit)?;
    if let Some(left) = &answer.remainder {
        write_remainder(text, left)?;
    }
    answer.locations.iter().take(3).try_for_each(|location| write_location(text, location))?;
    if let Some(experiment) = &answer.experiment {
        writeln!(text, "Next: {}", experiment.text)?;
    }
    for warning in &answer.warnings {
        writeln!(text, "Warning: {warning}")?;
    }
    Ok(())
}

/// A span of time in which the nominal model fails.
fn write_location(text: &mut String, location: &Location) -> std::fmt::Result {
    let (from, to) = (location.start_s, location.end_s);
    writeln!(
        text,
        "{} % ({} to {} %) of the excess at {from:.2} to {to:.2} s of {}: {}",
        per_cent(location.share),
        per_cent(location.share_low),
        per_cent(location.share_high),
        location.recording,
        location.text
    )
}

/// A share in per cent with one decimal, never rounded up: what is nearly the whole is not all of it.
pub(super) fn per_cent(share: f64) -> String {
    format!("{:.1}", (1000.0 * share + 1e-9).floor() / 10.0)
}

/// Relative fall from `before` to `after`, 1; nothing where there is nothing to fall from.
pub(super) fn fall(before: f64, after: f64) -> f64 {
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}

/// A p value in a sentence.
fn p_is(p: f64) -> String {
    let value = p_value(p);
    if value.starts_with('<') { format!("p {value}") } else { format!("p = {value}") }
}

/// A value with its interval, in the digits that the interval leaves.
fn valued(of: &Interval) -> String {
    let [value, low, high] = [of.value, of.low, of.high].map(|end| number(end, of.high - of.low));
    format!("{value} ({low} to {high}) {}", shown(&of.unit)).trim_end().to_owned()
}

/// An effect with its values in one line.
fn write_line(text: &mut String, effect: &EffectAnswer) -> std::fmt::Result {
    let values: Vec<String> = effect.parameters.iter().map(|p| format!("{} = {}", p.id, valued(p))).collect();
    let others =
        if effect.equivalent.is_empty() { String::new() } else { format!("; or {}", effect.equivalent.join(", ")) };
    writeln!(text, "{}: {}{others}", effect.id, values.join(", "))
}

/// An effect with its values and why it is believed.
fn write_effect(text: &mut String, effect: &EffectAnswer) -> std::fmt::Result {
    writeln!(text, "\n{}: {}", effect.id, effect.text)?;
    for p in &effect.parameters {
        let nominal = nominal(p).map(|value| format!(", nominal {value}")).unwrap_or_default();
        writeln!(text, "  {} = {}{nominal}", p.id, valued(p))?;
    }
    let e = effect.evidence;
    writeln!(
        text,
        "  accounts for up to {} % of the held-out error without it, {}",
        per_cent(e.heldout_gain),
        p_is(e.p_value)
    )?;
    if !effect.equivalent.is_empty() {
        writeln!(text, "  these recordings cannot tell it from: {}", effect.equivalent.join(", "))?;
    }
    if !effect.nuisances.is_empty() {
        writeln!(text, "  as good, and no effect of a machine: {}", effect.nuisances.join("; "))?;
    }
    Ok(())
}

/// Windows before and after.
fn write_fit(text: &mut String, fit: &FitAnswer) -> std::fmt::Result {
    writeln!(
        text,
        "\nWindows of {} s, rms in {}: {:.3e} before, {:.3e} after, noise {:.3e}; \
         held out {:.3e} before, {:.3e} after ({} % less), noise {:.3e}: {} % of the excess explained.",
        fit.horizon_s,
        fit.unit,
        fit.before_rms,
        fit.after_rms,
        fit.noise_floor_rms,
        fit.heldout_before_rms,
        fit.heldout_after_rms,
        per_cent(fall(fit.heldout_before_rms, fit.heldout_after_rms)),
        fit.heldout_floor_rms,
        per_cent(fit.excess_explained)
    )
}

/// What is left, and what predicts it.
fn write_remainder(text: &mut String, left: &RemainderAnswer) -> std::fmt::Result {
    writeln!(
        text,
        "Left: {} {} rms, some of which the values above may have absorbed.",
        measure(left.effort_rms),
        left.unit
    )?;
    if !left.unnamed.is_empty() {
        writeln!(text, "  traces of: {}", left.unnamed.join(", "))?;
    }
    for one in &left.predictors {
        let (share, p) = (per_cent(one.share), p_is(one.p_value));
        let rms = one.effort_rms.map(|rms| format!(", {} {} rms", measure(rms), left.unit)).unwrap_or_default();
        writeln!(text, "  {} predicts {share} % of its squares ({p}){rms}", one.channel)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Evidence;
    use crate::report::testing::effect;

    fn answer(verdict: Verdict, fit: FitAnswer) -> Answer {
        let effect = EffectAnswer {
            text: "Torque repeats over a revolution.".into(),
            evidence: Evidence { heldout_gain: 0.9999, p_value: 1e-13, excess_explained: 1.0 },
            ..effect("cogging", "amplitude_nm", 18.0, 1.0)
        };
        Answer { verdict, effects: vec![effect], fit, ..Answer::default() }
    }

    #[test]
    fn what_is_gained_is_never_rounded_up() {
        for (share, text) in [
            (0.0, "0.0"),
            (0.9996, "99.9"),
            (0.999_999, "99.9"),
            (1.0, "100.0"),
            (0.54, "54.0"),
            (0.0099, "0.9"),
            (-0.0001, "-0.1"),
        ] {
            assert_eq!(per_cent(share), text, "{share}");
        }
    }

    #[test]
    fn a_fall_from_nothing_is_none() {
        for (before, after, expected) in [(2.0, 1.0, 0.5), (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 2.0, -1.0)] {
            assert_eq!(fall(before, after), expected);
        }
    }

    /// Text and page show the same figures, of the same residual.
    #[test]
    fn the_fall_of_the_held_out_error_is_one_number() {
        let fit = FitAnswer {
            heldout_before_rms: 41.96e-6,
            heldout_after_rms: 41.63e-6,
            excess_explained: 0.031,
            ..FitAnswer::default()
        };
        let answer = answer(Verdict::Named, fit);
        let text = summary(&answer);
        assert!(text.contains("(0.7 % less)") && text.contains("3.1 % of the excess explained"), "{text}");
        let sentence = super::super::html::sentence(&answer);
        assert!(sentence.contains("is 0.7 % less"), "{sentence}");
    }

    #[test]
    fn a_long_answer_has_forty_lines_and_says_what_is_left_out() {
        let mut long = answer(Verdict::Partial, FitAnswer::default());
        assert!(summary(&long).contains("\n  amplitude_nm = 18.0 (17.0 to 19.0) N m\n"), "{}", summary(&long));
        // As on the page, a p value that cannot be told from zero is only small, and a plain number has no unit.
        assert!(summary(&long).contains(", p < 1e-12\n") && p_is(3.14e-5) == "p = 3.1e-5", "{}", summary(&long));
        let gain = Interval { unit: "1".into(), ..long.effects[0].parameters[0].clone() };
        assert_eq!(valued(&gain), "18.0 (17.0 to 19.0)");
        long.effects = vec![long.effects[0].clone(); 12];
        let text = summary(&long);
        assert!(
            text.lines().count() <= MOST_LINES && text.contains("\ncogging: amplitude_nm = 18.0 (17.0 to 19.0) N m\n")
        );
        long.effects = vec![long.effects[0].clone(); 60];
        let text = summary(&long);
        assert_eq!(text.lines().count(), MOST_LINES);
        assert!(text.ends_with("more lines: --html FILE and --json FILE have all of it\n"), "{text}");
    }

    #[test]
    fn only_what_is_certain_is_said_to_be_missing() {
        for verdict in [Verdict::Unknown, Verdict::Named, Verdict::Partial, Verdict::Ambiguous] {
            let text = summary(&answer(verdict, FitAnswer::default()));
            let certain = matches!(verdict, Verdict::Named | Verdict::Partial);
            assert_eq!(text.contains("This is missing"), certain, "{text}");
        }
    }

    #[test]
    fn an_ambiguous_answer_tells_that_more_is_left() {
        let mut left = answer(Verdict::Ambiguous, FitAnswer::default());
        // With nothing to choose from it does not ask which.
        assert!(summary(&left).starts_with("Something is missing, likely this, but not all"), "{}", summary(&left));
        left.effects[0].equivalent.push("torque_ripple".to_owned());
        assert!(
            summary(&left).starts_with("Something is missing, and these recordings cannot tell which of these it is:")
        );
        left.remainder = Some(RemainderAnswer::default());
        assert!(summary(&left).contains("and something more is not explained:"), "{}", summary(&left));
    }
}
