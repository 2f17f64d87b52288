//! The answer in a sentence, and numbers as a reader takes them.

use crate::report::text::{fall, per_cent};
use crate::report::{Answer, EffectAnswer, Interval, Verdict, shown};

/// The answer in one sentence.
pub(crate) fn sentence(answer: &Answer) -> String {
    let found: Vec<String> = answer.effects.iter().map(named).collect();
    let found = listed(&found);
    let fit = &answer.fit;
    let fall = per_cent(fall(fit.heldout_before_rms, fit.heldout_after_rms));
    match answer.verdict {
        Verdict::None => "Nothing is missing from the model beyond the noise of these recordings.".to_owned(),
        Verdict::Named => {
            let it = if answer.effects.len() > 1 { "them" } else { "it" };
            format!("The model lacks {found}; with {it}, the error on data the fit never saw is {fall} % less.")
        }
        Verdict::Partial => {
            let left = answer.remainder.as_ref().map_or_else(String::new, |left| {
                format!(", {} rms of it", with_unit(&measure(left.effort_rms), &left.unit))
            });
            format!(
                "The model lacks {found}, which takes {fall} % of the error on data the fit never saw; something more is \
                 left that is not explained{left}."
            )
        }
        Verdict::Ambiguous => {
            let left = if answer.remainder.is_some() { "; something more is left that is not explained" } else { "" };
            let why = if answer.offers_a_choice() {
                "these recordings cannot tell which it is"
            } else {
                "not all that may stand in its place was compared"
            };
            format!("The model lacks {found}: something is missing, and {why}{left}.")
        }
        Verdict::Unknown => {
            "Something is missing from the model, and nothing in the vocabulary explains it.".to_owned()
        }
        Verdict::Controller => {
            "The recorded commands are not what this control law computes, so no physics is named.".to_owned()
        }
    }
}

/// An effect with its first value and what it may be instead.
fn named(effect: &EffectAnswer) -> String {
    let values: Vec<String> = effect.parameters.iter().map(|value| with_unit(&estimate(value), &value.unit)).collect();
    let values = if values.is_empty() { String::new() } else { format!(" ({})", values.join(", ")) };
    let others: Vec<String> = effect.equivalent.iter().map(|id| title(id)).collect();
    let others = if others.is_empty() { String::new() } else { format!(" or {}", others.join(" or ")) };
    format!("{}{values}{others}", title(&effect.id))
}

/// A value and its unit, which no line break may part.
fn with_unit(value: &str, unit: &str) -> String {
    format!("{value} {}", shown(unit)).trim_end().replace(' ', "\u{a0}")
}

/// An identifier as words.
pub(super) fn title(id: &str) -> String {
    id.replace('_', " ")
}

fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The value with the digits that its interval leaves.
pub(crate) fn estimate(of: &Interval) -> String {
    number(of.value, of.high - of.low)
}

/// The interval with the digits that its width leaves.
pub(crate) fn interval(of: &Interval) -> String {
    let width = of.high - of.low;
    format!("{} to {}", number(of.low, width), number(of.high, width))
}

/// What the nominal model has in its place, with the same digits; nothing where it has none.
pub(crate) fn nominal(of: &Interval) -> Option<String> {
    of.nominal.map(|value| number(value, of.high - of.low))
}

/// A number with two digits of `width`; four of its own where that is zero or no number.
pub(crate) fn number(value: f64, width: f64) -> String {
    if !value.is_finite() {
        return "unbounded".to_owned();
    }
    let resolution = if width.is_finite() && width > 0.0 { width / 10.0 } else { value.abs() / 1000.0 };
    // Of a wide interval about zero, the place of an end within it is no figure.
    let value = if value.abs() < resolution { 0.0 } else { value };
    if value == 0.0 && resolution < 1e-4 {
        return "0".to_owned();
    }
    let order = |value: f64| value.log10().floor();
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        let digits = (order(value.abs()) - order(resolution)).clamp(0.0, 9.0) as usize;
        return format!("{value:.digits$e}");
    }
    let decimals = if resolution > 0.0 { (-order(resolution)).clamp(0.0, 9.0) as usize } else { 0 };
    format!("{value:.decimals$}")
}

/// A number without an interval, for orientation: three digits.
pub(crate) fn measure(value: f64) -> String {
    number(value, 0.1 * value.abs())
}

/// A number without an interval: up to four digits, and no zeros behind the last.
pub(crate) fn short(value: f64) -> String {
    let text = number(value, 0.0);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A fit, a share up to 1, in per cent: near the whole with the digits that what is missing of it has.
pub(super) fn fit_percent(share: f64) -> String {
    if !share.is_finite() {
        return "not known".to_owned();
    }
    let missing = 100.0 * (1.0 - share);
    // Two digits of what is missing, four decimals at most.
    let decimals = if missing > 0.0 { (1.0 - missing.log10().floor()).clamp(0.0, 4.0) as usize } else { 1 };
    format!("{:.decimals$} %", 100.0 * share)
}

/// A p value; what cannot be told from zero is said to be small.
pub(crate) fn p_value(p: f64) -> String {
    if p < 1e-12 { "< 1e-12".to_owned() } else { format!("{p:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_of_their_interval() {
        assert_eq!(number(0.950_123, 0.004), "0.9501");
        assert_eq!(number(0.950_123, 0.0), "0.9501");
        assert_eq!(number(1234.567, 300.0), "1235");
        assert_eq!(number(0.0, 0.0), "0");
        assert_eq!((number(-3e-7, 0.22), number(1e-9, 4e-7)), ("0.00".into(), "0".into()));
        assert_eq!(number(2.5e-7, 4e-9), "2.500e-7");
        assert_eq!(number(f64::INFINITY, 1.0), "unbounded");
    }

    #[test]
    fn a_plain_number_has_no_unit() {
        assert_eq!((with_unit("0.966", "1"), with_unit("2.0", "N m")), ("0.966".into(), "2.0\u{a0}N\u{a0}m".into()));
    }

    #[test]
    fn a_fit_has_the_digits_of_what_it_misses() {
        for (share, text) in [
            (0.5, "50 %"),
            (0.9987, "99.87 %"),
            (0.999_987, "99.9987 %"),
            (1.0, "100.0 %"),
            (-1.5, "-150 %"),
            (f64::NAN, "not known"),
        ] {
            assert_eq!(fit_percent(share), text, "{share}");
        }
        assert_eq!((measure(0.3751), measure(3.2e-5), measure(0.0)), ("0.375".into(), "3.20e-5".into(), "0".into()));
        assert_eq!((short(0.005), short(30.0), short(1.2e-7)), ("0.005".into(), "30".into(), "1.200e-7".into()));
    }

    #[test]
    fn effects_are_listed_as_in_speech() {
        let items = ["a".to_owned(), "b".to_owned(), "c".to_owned()];
        assert_eq!(listed(&items), "a, b and c");
        assert_eq!(title("field_dead_time"), "field dead time");
    }
}
