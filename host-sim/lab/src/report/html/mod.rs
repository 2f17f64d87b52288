//! The answer as one page that opens from disk: no file beside it, no network.

mod data;
mod equation;
mod escape;
mod maps;
mod markup;
mod model;
mod sections;
#[cfg(test)]
mod tests;
mod thin;
mod whiteness;
mod windows;
mod words;

pub use data::PlotData;
use maps::{Band, MapPlot};
use markup::Section;
#[cfg(test)]
pub(crate) use words::sentence;
pub(crate) use words::{estimate, interval};
pub(crate) use words::{measure, number};

use crate::Error;
use crate::output::Provenance;
use crate::report::Answer;

/// Sources of the plots; see the README beside them.
const UPLOT: &str = include_str!("../../../assets/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../../assets/uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("../../../assets/uplot/LICENSE");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Whatever the page holds, the browser loads nothing for it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The page for an answer about the machine called `machine`, and what made it.
///
/// # Errors
/// [`Error::Usage`] where the curves are no JSON, which numbers and names always are.
pub fn page(machine: &str, answer: &Answer, plot: &PlotData, made: &Provenance) -> Result<String, Error> {
    let data = escape::json(plot).map_err(|error| Error::Usage(format!("the page's data: {error}")))?;
    let verdict = answer.verdict.name();
    let names: Vec<&str> = plot.recordings.iter().map(|recording| recording.name.as_str()).collect();
    let [machine, names, sentence] = [machine, &names.join(", "), &words::sentence(answer)].map(escape::text);
    let sections = sections(answer, plot, made);
    let (picture, contents) = (sections::picture(answer, plot), markup::contents(&sections));
    let body: String = sections.iter().map(Section::markup).collect();
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" \
         content=\"{POLICY}\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta \
         name=\"color-scheme\" content=\"light dark\">\n<title>{machine}: {verdict}</title>\n<style>\n{UPLOT_STYLE}\n{STYLE}\
         </style>\n</head>\n<body>\n<a class=\"skip\" href=\"#answer\">Skip to the answer</a>\n<main>\n<header><p \
         class=\"quiet\">Diagnosis of {machine} from {names}</p>\n<h1 id=\"answer\" tabindex=\"-1\"><span class=\"verdict \
         {verdict}\">{verdict}</span> {sentence}</h1></header>\n<noscript><p class=\"note\">The curves are drawn by a script, \
         which is off here; every figure is in the tables.</p></noscript>\n{picture}{contents}{body}<footer \
         class=\"quiet\">servo-lab {}; plots by uPlot 1.6.32, MIT licence, text in the source of this page.</footer>\n\
         </main>\n<script type=\"application/json\" id=\"plot\">{data}</script>\n<script>\n/*\n{UPLOT_LICENCE}*/\n{UPLOT}\n\
         </script>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    ))
}

/// The sections in their order; those that have nothing to say are left out.
fn sections(answer: &Answer, plot: &PlotData, made: &Provenance) -> Vec<Section> {
    let all = [
        sections::warnings(answer),
        sections::effects(answer),
        sections::left(answer),
        model::alternatives(answer),
        Some(sections::fit(answer, plot)),
        Some(sections::curves(plot)),
        whiteness::section(&plot.left),
        sections::located(answer, plot),
        sections::maps(plot),
        sections::experiment(answer),
        model::equation(answer, &plot.equation),
        model::correlation(answer),
        sections::rejected(answer),
        Some(sections::provenance(made)),
    ];
    all.into_iter().flatten().collect()
}
