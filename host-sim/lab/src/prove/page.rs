//! The results as one page that opens from disk: no file beside it, no network.

use super::power::Curve;
use super::results::Results;
use super::text::{self, Table};
use crate::Error;
use crate::output::Provenance;
use crate::plot::{Figure, Mark, Panel, Series};

const STYLE: &str = include_str!("page.css");
/// Points of a drawn curve.
const POINTS: usize = 60;

/// The page, and what made it.
///
/// # Errors
/// What the drawing library says.
pub fn page(results: &Results, made: &Provenance) -> Result<String, Error> {
    let score = &results.score;
    let origin = &results.origin;
    let met = score.pass.iter().filter(|pass| pass.met).count();
    let mut body = format!(
        "<header><p class=\"quiet\">Proof on concealed effects, seeds {} to {}, {} cases</p><h1>{met} of {} lines of the pass \
         line met</h1></header>",
        origin.seeds[0],
        origin.seeds[1],
        results.outcomes.len(),
        score.pass.len()
    );
    body += &section("Pass line", &table(&text::pass(score)));
    body += &section("Arms", &table(&text::arms(score)));
    body += &section("Conclusions", &table(&text::verdicts(score)));
    body += &section("Power: how large an effect must be to be found", &power(results)?);
    body += &section("Reliability of the intervals", &reliability(results)?);
    body += &section("Before and after the proposed experiment", &table(&text::experiment(score)));
    body += &section("Rivals on the same files", &table(&text::rivals(score)));
    body += &section("Confusions", &table(&text::confusion(score)));
    let figures: String = text::figures(score).iter().map(|line| format!("<li>{}</li>", escape(line))).collect();
    body += &section("Figures", &format!("<ul>{figures}</ul>"));
    body += &section("Misses", &table(&text::misses(score, &results.outcomes)));
    let footer = format!(
        "Made by <code>{}</code>; sources at {}; SHA-256 of the program that diagnosed: {}. {} on {}, built from {}: \
         <code>{}</code>.",
        escape(&origin.command),
        escape(&origin.commit),
        escape(&origin.program),
        escape(&made.written_by),
        escape(&made.date),
        escape(&made.commit),
        escape(&made.command)
    );
    Ok(document("Proof on concealed effects", &body, &footer))
}

/// A page of sections with a footer, both as HTML.
pub(crate) fn document(title: &str, body: &str, footer: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; style-src 'unsafe-inline'\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>\n{STYLE}</style>\n\
         </head>\n<body>\n<main>\n{body}<footer class=\"quiet\">{footer}</footer>\n</main>\n</body>\n</html>\n",
        escape(title)
    )
}

/// A section with its heading; the content is HTML.
pub(crate) fn section(title: &str, content: &str) -> String {
    format!("<section><h2>{}</h2>\n{content}</section>\n", escape(title))
}

/// A table as HTML.
pub(crate) fn table((head, rows): &Table) -> String {
    let cell = |tag: &str, text: &str| format!("<{tag}>{}</{tag}>", escape(text));
    let head: String = head.iter().map(|text| cell("th", text)).collect();
    let row = |row: &Vec<String>| {
        let bad = if row.iter().any(|text| text == "NOT MET") { " class=\"bad\"" } else { "" };
        format!("<tr{bad}>{}</tr>\n", row.iter().map(|text| cell("td", text)).collect::<String>())
    };
    let rows: String = rows.iter().map(row).collect();
    format!("<div class=\"table\"><table><thead><tr>{head}</tr></thead><tbody>\n{rows}</tbody></table></div>\n")
}

fn power(results: &Results) -> Result<String, Error> {
    let plots: Result<String, Error> = results.score.power.iter().map(curve).collect();
    Ok(format!("{}<div class=\"grid\">\n{}</div>\n", table(&text::power(&results.score)), plots?))
}

/// One power curve: chance over strength, and the cases.
fn curve(curve: &Curve) -> Result<String, Error> {
    let strongest = curve.points.last().map_or(1.0, |point| point.strength);
    let label = match curve.origin {
        None => format!("1/{} (one over its unit)", curve.parameter),
        Some(0.0) => curve.parameter.clone(),
        Some(origin) => format!("{} away from {origin}", curve.parameter),
    };
    let line = (1..=POINTS).map(|k| strongest * k as f64 / POINTS as f64).map(|at| (at, curve.chance(at)));
    let cases = curve.points.iter().map(|point| (point.strength, f64::from(u8::from(point.found))));
    let series = vec![Series::new("chance to be found", Mark::Line, line), Series::new("cases", Mark::Points, cases)];
    figure(&curve.id, Panel::new(&label, "first name right (1)", series))
}

fn reliability(results: &Results) -> Result<String, Error> {
    let reliability = &results.score.reliability;
    let found = Series::new("found", Mark::Line, reliability.curve.iter().copied());
    let right = Series::new("as it should be", Mark::Line, [(0.5, 0.5), (1.0, 1.0)]);
    let panel = Panel::new("nominal coverage (1)", "intervals that hold the truth (1)", vec![found, right]);
    Ok(figure("Coverage of intervals scaled about their estimate", panel)? + &table(&text::coverage(&results.score)))
}

fn figure(title: &str, panel: Panel) -> Result<String, Error> {
    let svg = Figure { title: title.to_owned(), panels: vec![panel] }.to_svg().map_err(Error::Usage)?;
    Ok(format!("<figure>{svg}</figure>\n"))
}

/// Text for the content of an element.
pub(crate) fn escape(raw: &str) -> String {
    raw.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
