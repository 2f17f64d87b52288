//! The results as one page that opens from disk: no file beside it, no network.

use super::power::Curve;
use super::results::Results;
use super::text::{self, Table};
use crate::Error;
use crate::output::Provenance;
use crate::plot::{Figure, Mark, Panel, Series};
use crate::report::html::{self, Page, Section, badge, plain, table};

/// Points of a drawn curve.
const POINTS: usize = 60;

/// The page, and what made it.
///
/// # Errors
/// What the drawing library says.
pub fn page(results: &Results, made: &Provenance) -> Result<String, Error> {
    let (score, origin) = (&results.score, &results.origin);
    let asked = score.pass.iter().filter(|pass| pass.measured.is_some() && !pass.required.is_empty());
    let (met, asked) = (asked.clone().filter(|pass| pass.met).count(), asked.count());
    let (kind, word) = if met == asked { ("good", "passed") } else { ("", "not passed") };
    let page = Page {
        title: "Proof on concealed effects".to_owned(),
        about: format!(
            "Proof on concealed effects, seeds {} to {}, {} cases",
            origin.seeds[0],
            origin.seeds[1],
            results.outcomes.len()
        ),
        heading: badge(kind, word) + &format!("{met} of {asked} lines of the pass line that these cases ask are met"),
        picture: html::picture(
            &reliability(results),
            "How often intervals hold the truth, scaled about their estimate.",
        )?,
        sections: sections(results)?,
        script: None,
    };
    Ok(page.html(made))
}

/// The sections in their order.
fn sections(results: &Results) -> Result<Vec<Section>, Error> {
    let score = &results.score;
    let figures: String = text::figures(score).iter().map(|line| format!("<li>{}</li>", html::text(line))).collect();
    let section = |id, heading, caption, of: &Table| Section::new(id, heading, plain(caption, &of.0, &of.1));
    Ok(vec![
        Section::new("pass", "Pass line", pass(&text::pass(score))),
        section("arms", "Arms", "Counts by arm of the plan", &text::arms(score)),
        section("conclusions", "Conclusions", "How often each was drawn, by arm", &text::verdicts(score)),
        Section::new("power", "Power: how large an effect must be to be found", power(results)?),
        section("intervals", "Reliability of the intervals", "By parameter", &text::coverage(score)),
        section(
            "experiment",
            "Before and after the proposed experiment",
            "Cases that are poorly excited",
            &text::experiment(score),
        ),
        section("rivals", "Rivals on the same files", "What simpler methods answer", &text::rivals(score)),
        section("confusions", "Confusions", "Of one concealed effect, or nothing", &text::confusion(score)),
        Section::new("figures", "Figures", format!("<ul>{figures}</ul>")),
        section(
            "misses",
            "Misses",
            "Each again with servo-lab prove --case SEED",
            &text::misses(score, &results.outcomes),
        ),
        tested(results),
    ])
}

/// The page of one table, for proofs that have no score; `without` says why some have no answer.
pub fn of_table(title: &str, of: &Table, summary: &str, without: &[String], made: &Provenance) -> String {
    let lines = |lines: &mut dyn Iterator<Item = &str>| -> String {
        lines.map(|line| format!("<li>{}</li>", html::text(line))).collect()
    };
    let mut sections = vec![Section::new("table", "Case by case", plain(title, &of.0, &of.1))];
    if !summary.is_empty() {
        let body = format!("<ul>{}</ul>", lines(&mut summary.lines()));
        sections.insert(0, Section::new("summary", "Together", body));
    }
    if !without.is_empty() {
        let body = format!("<ul>{}</ul>", lines(&mut without.iter().map(String::as_str)));
        sections.push(Section::new("without", "Without an answer", body));
    }
    let page = Page {
        title: title.to_owned(),
        about: "Proof on recordings whose answer is known".to_owned(),
        heading: html::text(&format!("{title}: {} cases, {} without an answer", of.1.len(), without.len())),
        picture: String::new(),
        sections,
        script: None,
    };
    page.html(made)
}

/// The pass line; what is not met stands out.
fn pass((head, rows): &Table) -> String {
    let cell = |cell: &String| match cell.as_str() {
        "NOT MET" => "<strong class=\"bad\">NOT MET</strong>".to_owned(),
        other => html::text(other),
    };
    let rows = rows.iter().map(|row| row.iter().map(cell).collect()).collect();
    table("What is asked, and what was found", head, rows)
}

/// The program that was proved, which need not be the one that counts.
fn tested(results: &Results) -> Section {
    let origin = &results.origin;
    let rows = [
        ("command of the run", origin.command.clone()),
        ("sources", origin.commit.clone()),
        ("SHA-256 of the program that diagnosed", origin.program.clone()),
    ];
    let rows = rows.map(|(what, value)| vec![what.to_owned(), value]);
    Section::new("tested", "What was proved", plain("The program that diagnosed", &["what", "value"], &rows))
}

fn power(results: &Results) -> Result<String, Error> {
    let (head, rows) = text::power(&results.score);
    let sizes = plain("Sizes that are found in half and in nine of ten cases", &head, &rows);
    let caption = |curve: &Curve| format!("{}, over its strength", curve.id);
    let plots = results.score.power.iter().map(|curve| html::figure(&drawn(curve), &caption(curve)));
    Ok(format!("{sizes}<div class=\"grid\">\n{}</div>\n", plots.collect::<Result<String, Error>>()?))
}

/// One power curve: chance over strength, and the cases.
fn drawn(curve: &Curve) -> Figure {
    let strongest = curve.points.last().map_or(1.0, |point| point.strength);
    let label = match curve.origin {
        None => format!("1/{} (one over its unit)", curve.parameter),
        Some(0.0) => curve.parameter.clone(),
        Some(origin) => format!("{} away from {origin}", curve.parameter),
    };
    let line = (1..=POINTS).map(|k| strongest * k as f64 / POINTS as f64).map(|at| (at, curve.chance(at)));
    let cases = curve.points.iter().map(|point| (point.strength, f64::from(u8::from(point.found))));
    let series = vec![Series::new("chance to be found", Mark::Line, line), Series::new("cases", Mark::Points, cases)];
    Figure { title: curve.id.clone(), panels: vec![Panel::new(&label, "first name right (1)", series)] }
}

fn reliability(results: &Results) -> Figure {
    let found = Series::new("found", Mark::Line, results.score.reliability.curve.iter().copied());
    let right = Series::new("as it should be", Mark::Line, [(0.5, 0.5), (1.0, 1.0)]);
    let panel = Panel::new("nominal coverage (1)", "intervals that hold the truth (1)", vec![found, right]);
    Figure { title: "Coverage of intervals scaled about their estimate".to_owned(), panels: vec![panel] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proof_of_one_table_is_a_page_of_it() {
        let of: Table = (vec!["case", "answer"], vec![vec!["a<b".to_owned(), "named".to_owned()]]);
        let without = ["set c: no machine file".to_owned()];
        let page = of_table(
            "Answers that must follow",
            &of,
            "turned: 1 of 1 follow\n",
            &without,
            &Provenance::without_inputs(None),
        );
        for part in
            ["1 cases, 1 without an answer", "a&lt;b", "turned: 1 of 1 follow", "no machine file", "git checkout"]
        {
            assert!(page.contains(part), "{part}");
        }
        assert!(!page.contains("<script"));
    }
}
