//! The fleet at a glance: verdicts, which effects in which machines, and how their values drift over dates.

use std::collections::{BTreeMap, BTreeSet};

use super::Row;
use crate::Error;
use crate::output::Provenance;
use crate::prove::text::{Table, aligned};
use crate::report::html::{Page, Section, estimate, interval, plain, text};
use crate::report::{EffectAnswer, Interval, shown};

/// What the rows say together.
#[derive(Debug)]
pub struct Summary {
    /// How many rows have which verdict, and how many none.
    pub verdicts: Table,
    /// In how many diagnoses of which machine each effect is.
    pub effects: Table,
    /// First and last value of each parameter that has more than one date.
    pub drift: Table,
    /// Rows without an answer, and why.
    pub failed: Table,
}

impl Summary {
    /// Of the rows of a manifest.
    pub fn of(rows: &[Row]) -> Self {
        Self { verdicts: verdicts(rows), effects: effects(rows), drift: drift(rows), failed: failed(rows) }
    }

    /// Those that have a row, each with what its link leads to.
    fn parts(&self) -> impl Iterator<Item = (&'static str, &'static str, &Table)> {
        let all = [
            ("verdicts", "Verdicts", &self.verdicts),
            ("effects", "Effects in machines", &self.effects),
            ("drift", "Drift over dates", &self.drift),
            ("failed", "Rows without an answer", &self.failed),
        ];
        all.into_iter().filter(|(_, _, (_, rows))| !rows.is_empty())
    }

    /// For a terminal; parts without a row are left out.
    pub fn text(&self) -> String {
        let part = |(_, title, table): (_, &str, &Table)| {
            format!("{title}\n{}", aligned(table).lines().map(|line| format!("  {line}\n")).collect::<String>())
        };
        self.parts().map(part).collect::<Vec<_>>().join("\n")
    }

    /// As one page that opens from disk.
    pub fn page(&self, manifest: &str, made: &Provenance) -> String {
        let done: usize = self.verdicts.1.iter().filter_map(|row| row[1].parse::<usize>().ok()).sum();
        let section = |(id, title, (head, rows)): (_, _, &Table)| Section::new(id, title, plain(title, head, rows));
        let page = Page {
            title: "Fleet".to_owned(),
            about: format!("Fleet of {manifest}"),
            heading: text(&format!("{done} diagnoses, {} rows without an answer", self.failed.1.len())),
            picture: String::new(),
            sections: self.parts().map(section).collect(),
            script: None,
        };
        page.html(made)
    }

    /// The first row without an answer as an error, with how many there are.
    ///
    /// # Errors
    /// [`Error::Input`] with its line in the manifest.
    pub fn complete(manifest: &std::path::Path, rows: &[Row]) -> Result<(), Error> {
        let mut failed = rows.iter().filter_map(|row| Some((row.task.line, row.outcome.as_ref().err()?)));
        let Some((line, error)) = failed.next() else { return Ok(()) };
        let more = match failed.count() {
            0 => String::new(),
            more => format!(" (and {more} more rows without an answer, in the table)"),
        };
        Err(Error::input(manifest, Some(line), "", format!("{error}{more}")))
    }
}

fn verdicts(rows: &[Row]) -> Table {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for answer in rows.iter().filter_map(Row::answer) {
        *counts.entry(answer.verdict.name()).or_default() += 1;
    }
    (
        vec!["verdict", "diagnoses"],
        counts.into_iter().map(|(verdict, count)| vec![verdict.to_owned(), count.to_string()]).collect(),
    )
}

/// Effects, with the row they are of.
fn found_in(rows: &[Row]) -> impl Iterator<Item = (&Row, &EffectAnswer)> {
    rows.iter().flat_map(|row| {
        row.answer().into_iter().flat_map(move |one| one.effects.iter().map(move |effect| (row, effect)))
    })
}

fn effects(rows: &[Row]) -> Table {
    let mut diagnoses: BTreeMap<&str, usize> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.answer().is_some()) {
        *diagnoses.entry(&row.task.machine).or_default() += 1;
    }
    // An effect that repeats, as cogging of several orders, is in a diagnosis once.
    let mut found: BTreeMap<(&str, &str), BTreeSet<u64>> = BTreeMap::new();
    for (row, effect) in found_in(rows) {
        found.entry((row.task.machine.as_str(), effect.id.as_str())).or_default().insert(row.task.line);
    }
    let row = |((machine, effect), lines): (&(&str, &str), &BTreeSet<u64>)| {
        let of = diagnoses.get(machine).copied().unwrap_or(0);
        let listed: Vec<String> = lines.iter().take(8).map(u64::to_string).collect();
        let more = if lines.len() > 8 { ", ..." } else { "" };
        vec![
            (*machine).to_owned(),
            (*effect).to_owned(),
            format!("{} of {of}", lines.len()),
            format!("{}{more}", listed.join(", ")),
        ]
    };
    (vec!["machine", "effect", "diagnoses", "lines of the manifest"], found.iter().map(row).collect())
}

/// A parameter of an effect of a machine. Where an effect repeats, its entries are told apart by nothing that stays, and have no drift.
type Series<'a> = BTreeMap<Parameter<'a>, Vec<Dated<'a>>>;
/// Machine, effect, parameter.
type Parameter<'a> = (&'a str, &'a str, &'a str);
/// A value with its date.
type Dated<'a> = (&'a str, &'a Interval);

fn drift(rows: &[Row]) -> Table {
    let mut series: Series<'_> = BTreeMap::new();
    for (row, effect) in found_in(rows).filter(|(row, _)| !row.task.date.is_empty()) {
        let once =
            row.answer().is_some_and(|one| one.effects.iter().filter(|other| other.id == effect.id).count() == 1);
        for value in effect.parameters.iter().filter(|_| once) {
            series
                .entry((row.task.machine.as_str(), effect.id.as_str(), value.id.as_str()))
                .or_default()
                .push((row.task.date.as_str(), value));
        }
    }
    let head = vec!["machine", "effect", "parameter", "values", "first", "95 %", "last", "95 %", "drift"];
    let line = |((machine, effect, parameter), values): (&Parameter<'_>, &Vec<Dated<'_>>)| {
        let mut values = values.clone();
        values.sort_by_key(|(date, _)| *date);
        let ((first_date, first), (last_date, last)) = (values.first()?, values.last()?);
        let apart = first.high < last.low || last.high < first.low;
        (first_date != last_date).then(|| {
            vec![
                (*machine).to_owned(),
                (*effect).to_owned(),
                match shown(&last.unit) {
                    "" => (*parameter).to_owned(),
                    unit => format!("{parameter}, {unit}"),
                },
                values.len().to_string(),
                format!("{} on {first_date}", estimate(first)),
                interval(first),
                format!("{} on {last_date}", estimate(last)),
                interval(last),
                if apart { "beyond both intervals" } else { "within the intervals" }.to_owned(),
            ]
        })
    };
    (head, series.iter().filter_map(line).collect())
}

fn failed(rows: &[Row]) -> Table {
    let row = |row: &Row| {
        Some(vec![row.task.line.to_string(), row.task.machine.clone(), row.outcome.as_ref().err()?.clone()])
    };
    (vec!["line", "machine", "why"], rows.iter().filter_map(row).collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::fleet::Task;
    use crate::report::testing::effect;
    use crate::report::{Answer, Verdict};

    fn row(line: u64, date: &str, outcome: Result<f64, &str>) -> Row {
        let task = Task { line, machine: "a.toml".into(), date: date.into(), ..Task::default() };
        let answer = |value: f64| {
            let effect = effect("coulomb_friction", "coulomb_nm", value, 0.1);
            Answer { verdict: Verdict::Named, effects: vec![effect], ..Answer::default() }
        };
        Row { task, key: String::new(), outcome: outcome.map(answer).map_err(str::to_owned) }
    }

    #[test]
    fn a_value_that_grows_over_dates_drifts_and_one_that_does_not_stays() {
        // Not in the order of their dates.
        let rows = [row(2, "2026-03-01", Ok(1.0)), row(3, "2026-01-01", Ok(0.5)), row(4, "2026-02-01", Ok(0.7))];
        let summary = Summary::of(&rows);
        assert_eq!(summary.drift.1.len(), 1);
        let drift = summary.drift.1[0].join(" ");
        assert!(drift.contains("2026-01-01") && drift.contains("2026-03-01") && drift.contains("beyond"), "{drift}");
        assert_eq!(summary.effects.1, [["a.toml", "coulomb_friction", "3 of 3", "2, 3, 4"]]);
        let steady = Summary::of(&[row(2, "2026-03-01", Ok(1.0)), row(3, "2026-01-01", Ok(0.95))]);
        assert!(steady.drift.1[0].join(" ").contains("within"));
        // One date is no drift, and rows without one have no place in it.
        assert!(Summary::of(&[row(2, "2026-03-01", Ok(1.0)), row(3, "", Ok(9.0))]).drift.1.is_empty());
    }

    #[test]
    fn rows_without_an_answer_are_told_by_their_line() {
        let rows = [row(2, "", Ok(1.0)), row(3, "", Err("no.csv: is not there")), row(4, "", Err("again"))];
        let error = Summary::complete(std::path::Path::new("m.csv"), &rows).unwrap_err().to_string();
        assert_eq!(error, "m.csv:3: no.csv: is not there (and 1 more rows without an answer, in the table)");
        let text = Summary::of(&rows).text();
        assert!(text.contains("named    1") && text.contains("again"), "{text}");
    }
}
