//! The improved model: its equation, the models beside it, and how the errors of its values go together.

use super::escape::text;
use super::markup::{Section, table};
use super::words::{number, title};
use crate::report::{AlternativeAnswer, AlternativeEffect, Answer, EffectAnswer, Interval, Verdict, shown};

/// A correlation beyond which two values mostly say what their sum or difference is (Belsley, Kuh and Welsch 1980: a variance
/// inflation factor of about five).
const STRONG: f64 = 0.9;

/// The equation of the improved model, one line each.
pub(super) fn equation(answer: &Answer, lines: &[String]) -> Option<Section> {
    if lines.is_empty() {
        return None;
    }
    let lines: String = lines.iter().map(|line| format!("<p>{}</p>", text(line))).collect();
    let body = format!(
        "<p class=\"quiet\">With its values, in SI units; a star marks what the answer found.</p><div \
         class=\"equation\">{lines}</div>"
    );
    let heading = if answer.effects.is_empty() || answer.verdict == Verdict::Controller {
        "Equation of the model"
    } else {
        "Equation of the improved model"
    };
    Some(Section::new("equation", heading, body))
}

/// The models that these recordings do not exclude, each with its own values beside those of the answer.
pub(super) fn alternatives(answer: &Answer) -> Option<Section> {
    if answer.alternatives.is_empty() {
        return None;
    }
    let each = answer.alternatives.iter().enumerate().map(|(index, other)| {
        let rows = other.effects.iter().flat_map(|effect| rows(answer, effect)).collect();
        let caption = format!("Alternative {}: {}", index + 1, named(answer, other));
        table(&caption, &["effect", "parameter", "value here", "in the answer", "unit"], rows)
    });
    let body = format!(
        "<p class=\"quiet\">Models that these recordings do not exclude beside the answer, the likeliest first, each refitted: what \
         stands in for what, and what the other values become then.</p>{}",
        each.collect::<String>()
    );
    Some(Section::new("alternatives", "The alternatives and their values", body))
}

/// What it has that the answer has not, and for what.
fn named(answer: &Answer, other: &AlternativeAnswer) -> String {
    let without = |these: &[&str], those: &[&str]| -> Vec<String> {
        let mut rest = those.to_vec();
        let mut left = Vec::new();
        for id in these {
            match rest.iter().position(|one| one == id) {
                Some(at) => drop(rest.remove(at)),
                None => left.push(title(id)),
            }
        }
        left
    };
    let own: Vec<&str> = answer.effects.iter().map(|effect| effect.id.as_str()).collect();
    let others: Vec<&str> = other.effects.iter().map(|effect| effect.id.as_str()).collect();
    let (instead, of) = (without(&others, &own), without(&own, &others));
    match (instead.as_slice(), of.as_slice()) {
        ([], []) => "the same effects at other values".to_owned(),
        (instead, []) => format!("{} as well", instead.join(" and ")),
        ([], of) => format!("without {}", of.join(" and ")),
        (instead, of) => format!("{} in place of {}", instead.join(" and "), of.join(" and ")),
    }
}

fn rows(answer: &Answer, effect: &AlternativeEffect) -> Vec<Vec<String>> {
    let own = answer.effects.iter().find(|own| own.id == effect.id && own.recording == effect.recording);
    let event = effect.recording.as_ref().map_or_else(String::new, |name| format!(" in {}", text(name)));
    let row = |value: &crate::report::AlternativeValue| {
        let same = own.and_then(|own: &EffectAnswer| own.parameters.iter().find(|own| own.id == value.id));
        let width = same.map_or(0.0, |own: &Interval| own.high - own.low);
        vec![
            format!("<code>{}</code>{event}", text(&effect.id)),
            format!("<code>{}</code>", text(&value.id)),
            number(value.value, width),
            same.map_or_else(|| "not in it".to_owned(), |own| number(own.value, width)),
            text(shown(&value.unit)),
        ]
    };
    effect.parameters.iter().map(row).collect()
}

/// How the errors of the values go together.
pub(super) fn correlation(answer: &Answer) -> Option<Section> {
    let correlation = answer.correlation.as_ref()?;
    let name = |value: &String| format!("<code>{}</code>", text(value));
    let cell = |value: f64| {
        let figure = format!("{value:.2}");
        if value.abs() > STRONG && value < 1.0 { format!("<strong>{figure}</strong>") } else { figure }
    };
    let rows = correlation.values.iter().zip(&correlation.matrix).enumerate().map(|(at, (value, row))| {
        let cells = row.iter().take(at + 1).map(|value| cell(*value));
        std::iter::once(format!("{} {}", at + 1, name(value))).chain(cells).collect()
    });
    let numbers: Vec<String> = (1..=correlation.values.len()).map(|at| at.to_string()).collect();
    let head: Vec<&str> = std::iter::once("value").chain(numbers.iter().map(String::as_str)).collect();
    let strong = correlation.matrix.iter().enumerate().flat_map(|(at, row)| &row[..at.min(row.len())]);
    let strong = strong.filter(|value| value.abs() > STRONG).count();
    let note = if strong > 0 {
        "<p class=\"note\">Values in bold go together so closely that these recordings mostly tell their sum or difference: a motion \
         in which they act apart would narrow both.</p>"
    } else {
        ""
    };
    let table = table("Correlation of the errors, -1 to 1", &head, rows.collect());
    let body = format!(
        "<p class=\"quiet\">Near 1 or -1, an error of one value is made good by an error of the other.</p>{table}{note}"
    );
    Some(Section::new("correlation", "How the values go together", body))
}
