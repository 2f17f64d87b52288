//! The paper's claims and figures as a page, and the control beyond it.

use crate::Error;
use crate::beyond::{Comparison, LINES, UNCERTAINTY};
use crate::output::Provenance;
use crate::paper::claims::{Claim, Verdict};
use crate::paper::figures::{LEFT_OUT, NamedFigure};
use crate::paper::{Reproduction, table};
use crate::report::html::{Page, Section, badge, figure, number, picture, plain, text};

/// The figure at the top: the stable regions, which the paper's design stands on.
const FIRST: &str = "fig09.svg";

/// The page of a reproduction, and what made it.
///
/// # Errors
/// What the drawing library says.
pub(super) fn page(paper: &Reproduction, made: &Provenance) -> Result<String, Error> {
    let first = paper.figures.iter().find(|named| named.file == FIRST);
    let caption = "Fig. 9, where the linear loop is stable; the other figures are below.";
    let claims: String = paper.claims.iter().map(claim).collect();
    let page = Page {
        title: "The paper, reproduced".to_owned(),
        about: "The paper's figures and claims, from the model alone".to_owned(),
        heading: text(&sentence(paper)),
        picture: first.map_or(Ok(String::new()), |named| picture(&named.figure, caption))?,
        sections: vec![
            Section::new("verdicts", "Every claim in a line", verdicts(paper)),
            Section::new("rule", "How it was judged", format!("<p>{}</p>", text(&table::preamble(paper)))),
            Section::new("claims", "The claims", claims),
            Section::new("figures", "The figures", figures(paper)?),
        ],
        script: None,
    };
    Ok(page.html(made))
}

fn sentence(paper: &Reproduction) -> String {
    let count = |holds: fn(&Verdict) -> bool| paper.claims.iter().filter(|claim| holds(&claim.verdict)).count();
    format!(
        "Of {} claims {} hold at every place asked, {} in part, {} rarely, {} at none; {} cannot be tested.",
        paper.claims.len(),
        count(|verdict| matches!(verdict, Verdict::Holds)),
        count(|verdict| matches!(verdict, Verdict::InPart(_))),
        count(|verdict| matches!(verdict, Verdict::Rarely(_))),
        count(|verdict| matches!(verdict, Verdict::DoesNotHold(_))),
        count(|verdict| matches!(verdict, Verdict::NotTestable(_)))
    )
}

fn verdicts(paper: &Reproduction) -> String {
    let row = |claim: &Claim| [claim.section, claim.statement, claim.verdict.name()].map(str::to_owned).to_vec();
    let rows: Vec<_> = paper.claims.iter().map(row).collect();
    plain("The claims in the order of the paper", &["paper", "claim", "verdict"], &rows)
}

fn claim(claim: &Claim) -> String {
    let kind = match claim.verdict {
        Verdict::Holds => "good",
        Verdict::NotTestable(_) => "named",
        Verdict::InPart(_) | Verdict::Rarely(_) | Verdict::DoesNotHold(_) => "",
    };
    let detail = match claim.verdict.detail() {
        "" => String::new(),
        detail => format!("<p>{}.</p>", text(detail)),
    };
    let figures: String = claim.figures.iter().map(|figure| format!("<li>{}</li>", text(figure))).collect();
    let figures = if figures.is_empty() { figures } else { format!("<ul>{figures}</ul>") };
    format!(
        "<article><h3>{}{}</h3> <span class=\"quiet\">{}</span>{detail}<p class=\"quiet\">Test: {}. Range: {}.</p>{figures}\
         </article>",
        badge(kind, claim.verdict.name()),
        text(claim.statement),
        text(claim.section),
        text(claim.test),
        text(&claim.range)
    )
}

fn figures(paper: &Reproduction) -> Result<String, Error> {
    let one = |named: &NamedFigure| figure(&named.figure, named.file);
    let each = paper.figures.iter().map(one).collect::<Result<String, Error>>()?;
    Ok(format!("<p class=\"quiet\">{}.</p>{each}", text(LEFT_OUT)))
}

/// The page of the control beyond the paper, and what made it.
///
/// # Errors
/// A value the law or the plant does not take; what the drawing library says.
pub(super) fn beyond(comparison: &Comparison, made: &Provenance) -> Result<String, Error> {
    let all = comparison.figure()?;
    // The last panel is the field that goes with it.
    let push = all.panels.iter().rev().skip(1).take(1).cloned().collect();
    let first = crate::plot::Figure { title: "A push of 8 N m".to_owned(), panels: push };
    let verdicts: String = comparison.verdicts().iter().map(|line| format!("<li>{}</li>", text(line))).collect();
    let page = Page {
        title: "Beyond the paper's law".to_owned(),
        about: "The control that the paper asks for, beside its own law".to_owned(),
        heading: text(&format!(
            "{} ways to use known delays, on {} lines each.",
            comparison.entries.len() - 1,
            LINES.len()
        )),
        picture: picture(&first, "Error under a push at rest, of the paper's law and of what was added to it.")?,
        sections: vec![
            Section::new("verdicts", "Better and worse than the paper's law", format!("<ul>{verdicts}</ul>")),
            Section::new("table", "Line by line", lines(comparison)),
            Section::new("figures", "The runs", figure(&all, "Both steps and the push, each with its field.")?),
        ],
        script: None,
    };
    Ok(page.html(made))
}

/// Each figure of each mode: with the delays it was told, and the worst with every delay off.
fn lines(comparison: &Comparison) -> String {
    let mut head = vec!["figure"];
    head.extend(comparison.entries.iter().map(|entry| entry.mode.name));
    let rows = LINES.iter().enumerate().map(|(line, name)| {
        let cells = comparison.entries.iter().map(|entry| {
            let [nominal, worst] = [&entry.nominal, &entry.worst].map(|of| number(of.0[line], 0.0));
            format!("{nominal} / {worst}")
        });
        std::iter::once((*name).to_owned()).chain(cells).collect()
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let caption = format!(
        "With the delays that were told / the worst with every delay off by \u{b1}{:.0} %, alone and together; less is better",
        100.0 * UNCERTAINTY
    );
    plain(&caption, &head, &rows)
}
