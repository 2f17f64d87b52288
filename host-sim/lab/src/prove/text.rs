//! The counts as text for a terminal, and the tables that the page and the results share.

use std::fmt::Write as _;

use super::power::Curve;
use super::score::{ArmScore, Count, ExperimentScore, Pass, RivalScore};
use super::{Outcome, Score, Verdict};

/// A table: head, rows.
pub type Table = (Vec<&'static str>, Vec<Vec<String>>);

/// As `3/4`, or a dash of nothing.
pub fn count(count: Count) -> String {
    if count.of == 0 { "-".to_owned() } else { format!("{}/{}", count.holds, count.of) }
}

/// The pass line.
pub fn pass(score: &Score) -> Table {
    let row = |pass: &Pass| {
        let measured = pass.measured.map_or_else(|| "not asked".to_owned(), |value| format!("{value:.3}"));
        let interval = pass.interval.map_or_else(String::new, |[low, high]| format!("{low:.3} to {high:.3}"));
        let met = match (pass.measured, pass.met) {
            (None, _) => "-",
            _ if pass.required.is_empty() => "beside",
            (_, true) => "met",
            (_, false) => "NOT MET",
        };
        vec![pass.what.clone(), pass.required.clone(), measured, interval, pass.of.to_string(), met.to_owned()]
    };
    let head = vec!["pass line", "required", "measured", "exact 95 % interval", "cases", ""];
    (head, score.pass.iter().map(row).collect())
}

/// Counts by arm.
pub fn arms(score: &Score) -> Table {
    let head = vec![
        "arm",
        "right",
        "exact set",
        "first name",
        "or one that no motion tells from it",
        "listed",
        "abstained",
        "confidently wrong",
        "named anything",
        "wrongly",
    ];
    let row = |arm: &ArmScore| {
        let named = [arm.right, arm.exact, arm.first, arm.first_indistinct, arm.listed];
        let counts = named.into_iter().chain([arm.abstained, arm.wrong, arm.named, arm.wrongly]);
        [arm.arm.name().to_owned()].into_iter().chain(counts.map(count)).collect()
    };
    (head, score.arms.iter().map(row).collect())
}

/// The exact 95 % interval of a share.
fn bounds(count: Count) -> String {
    let [low, high] = count.interval();
    format!("{low:.3} to {high:.3}")
}

/// Conclusions by arm, each with the exact 95 % interval of its share.
pub fn verdicts(score: &Score) -> Table {
    const ALL: [Verdict; 6] =
        [Verdict::None, Verdict::Named, Verdict::Partial, Verdict::Ambiguous, Verdict::Unknown, Verdict::Controller];
    let mut head = vec!["arm"];
    head.extend(ALL.map(Verdict::name));
    head.extend(["confidently wrong", "exact 95 % interval", "named with a stray", "partial, first name wrong"]);
    let row = |arm: &ArmScore| {
        let mut cells = vec![arm.arm.name().to_owned()];
        cells.extend(ALL.map(|verdict| {
            let holds = arm.verdicts.get(&verdict).copied().unwrap_or(0);
            format!("{holds} ({})", bounds(Count { holds, of: arm.wrong.of }))
        }));
        cells.extend([count(arm.wrong), bounds(arm.wrong), count(arm.stray), count(arm.partial_wrong)]);
        cells
    };
    (head, score.arms.iter().map(row).collect())
}

/// Detectable sizes by effect.
pub fn power(score: &Score) -> Table {
    let head = vec!["effect", "parameter", "found in 50 %", "found in 90 %", "found"];
    let row = |curve: &Curve| {
        let name =
            if curve.origin.is_none() { format!("{} (at most)", curve.parameter) } else { curve.parameter.clone() };
        let found = Count::over(&curve.points, |point| point.found);
        vec![curve.id.clone(), name, curve.size_words(&curve.at_50), curve.size_words(&curve.at_90), count(found)]
    };
    (head, score.power.iter().map(row).collect())
}

/// Confusions: only rows in which something was answered wrongly or not at all.
pub fn confusion(score: &Score) -> Table {
    let row = |(truth, answers): (&String, &std::collections::BTreeMap<String, usize>)| {
        let mut answers: Vec<(&String, &usize)> = answers.iter().collect();
        answers.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
        let words: Vec<String> = answers.iter().map(|(answer, times)| format!("{answer} {times}")).collect();
        vec![truth.clone(), words.join(", ")]
    };
    (
        vec!["concealed", "answered (verdict in brackets where nothing is named), times"],
        score.confusion.iter().map(row).collect(),
    )
}

/// The rivals beside the tool.
pub fn rivals(score: &Score) -> Table {
    let head = vec![
        "rival",
        "named on clean",
        "exact, one effect",
        "first name, one effect",
        "exact, several",
        "named, outside the library",
    ];
    let row = |rival: &RivalScore| {
        let counts =
            [rival.named_on_clean, rival.exact_single, rival.first_single, rival.exact_many, rival.named_outside];
        [rival.rival.clone()].into_iter().chain(counts.map(count)).collect()
    };
    (head, score.rivals.iter().map(row).collect())
}

/// Before and after the proposed experiment.
pub fn experiment(score: &Score) -> Table {
    let ExperimentScore { proposed, before, after, wrong_before, wrong_after } = score.experiment;
    let head = vec!["poor excitation", "proposed", "named and right", "confidently wrong"];
    let rows = vec![
        vec!["before".to_owned(), "-".to_owned(), count(before), count(wrong_before)],
        vec!["after the proposed experiment".to_owned(), count(proposed), count(after), count(wrong_after)],
    ];
    (head, rows)
}

/// Coverage by parameter.
pub fn coverage(score: &Score) -> Table {
    let rows = score.reliability.by_parameter.iter().map(|(name, held)| vec![name.clone(), count(*held)]);
    (vec!["parameter", "intervals that hold the truth"], rows.collect())
}

/// Every miss with its seed.
pub fn misses(score: &Score, outcomes: &[Outcome]) -> Table {
    let row = |outcome: &Outcome| {
        let truth = &outcome.truth;
        vec![truth.seed.to_string(), truth.arm.name().to_owned(), outcome.concealed(), outcome.answered()]
    };
    let mut rows: Vec<Vec<String>> = score.misses(outcomes).map(row).collect();
    let failed = |(seed, reason): &(u64, String)| {
        vec![seed.to_string(), "no answer".to_owned(), String::new(), reason.trim().replace('\n', " ")]
    };
    rows.extend(score.failures.iter().map(failed));
    (vec!["seed", "arm", "concealed", "answered"], rows)
}

/// Single figures, one line each.
pub fn figures(score: &Score) -> Vec<String> {
    let mut lines = vec![
        format!("95 % intervals that hold the truth: {}", count(score.reliability.all)),
        format!("pushes of which the best location covers half: {}", count(score.located)),
        format!("first region over the right channel: {}", count(score.regions)),
    ];
    for (what, ratios) in [("oracle's", score.over_oracle), ("floor", score.over_floor)] {
        lines.extend(
            ratios.map(|[median, high]| {
                format!("held-out error over the {what}: median {median:.3}, 95 % below {high:.3}")
            }),
        );
    }
    lines.extend(
        score.seconds.map(|[median, most]| format!("time of one diagnosis: median {median:.1} s, longest {most:.1} s")),
    );
    lines
}

/// The whole report.
pub fn report(score: &Score, outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for table in
        [pass(score), arms(score), verdicts(score), power(score), experiment(score), rivals(score), confusion(score)]
    {
        text += &aligned(&table);
        text.push('\n');
    }
    for line in figures(score) {
        let _ = writeln!(text, "{line}");
    }
    text += "\nmisses (again with --case SEED)\n";
    text += &aligned(&misses(score, outcomes));
    text
}

/// A table with columns as wide as they must be.
pub fn aligned((head, rows): &Table) -> String {
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let all = || std::iter::once(&head).chain(rows);
    let width = |column: usize| all().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    let mut text = String::new();
    for row in all() {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        let _ = writeln!(text, "{}", cells.join("  ").trim_end());
    }
    text
}

/// A table in Markdown.
pub fn markdown((head, rows): &Table) -> String {
    let line = |cells: Vec<String>| {
        let safe: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", safe.join(" | "))
    };
    let mut text = line(head.iter().map(|cell| (*cell).to_owned()).collect());
    text += &format!("|{}\n", "---|".repeat(head.len()));
    text + &rows.iter().map(|row| line(row.clone())).collect::<String>()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::prove::run::Ran;
    use crate::prove::score::testing;
    use conceal::plan::Arm;

    #[test]
    fn every_conclusion_of_an_arm_has_its_exact_bounds() {
        let outcome = |verdict: &str| {
            let answer = serde_json::from_str(&format!(r#"{{"verdict": "{verdict}", "effects": []}}"#)).unwrap();
            Outcome::of(testing::truth(Arm::Outside), String::new(), &answer, 1.0)
        };
        let mut outcomes = vec![outcome("unknown"); 60];
        outcomes.extend(vec![outcome("named"); 2]);
        outcomes.extend([outcome("partial"), outcome("ambiguous")]);
        let score = Score::of(&Ran { outcomes, failures: Vec::new() });
        let (head, rows) = verdicts(&score);
        let cell = |name: &str| rows[0][head.iter().position(|word| *word == name).unwrap()].clone();
        // None of 64: 1 - 0.025^(1/64). One of 64 and two of 64: Clopper and Pearson's beta quantiles.
        assert_eq!([cell("none"), cell("partial")], ["0 (0.000 to 0.056)", "1 (0.000 to 0.084)"]);
        assert_eq!([cell("named"), cell("ambiguous")], ["2 (0.004 to 0.108)", "1 (0.000 to 0.084)"]);
        assert_eq!(cell("unknown"), "60 (0.848 to 0.983)");
    }
}
