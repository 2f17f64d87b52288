//! What commands find as one page that opens from disk: the frame of all of them, and the answer of a diagnosis in it.

mod data;
mod equation;
mod escape;
mod frame;
mod maps;
mod markup;
mod model;
mod pictures;
mod provenance;
mod sections;
#[cfg(test)]
mod tests;
mod thin;
mod whiteness;
mod windows;
mod words;

pub use data::PlotData;
pub(crate) use data::prefix;
pub(crate) use escape::text;
pub(crate) use frame::Page;
use frame::Script;
use maps::{Band, MapPlot};
pub(crate) use markup::{Section, badge, plain, table};
pub(crate) use pictures::{figure, picture};
pub(crate) use sections::warnings;
#[cfg(test)]
pub(crate) use words::sentence;
pub(crate) use words::{estimate, interval, nominal};
pub(crate) use words::{measure, number, p_value, short};

use crate::Error;
use crate::output::Provenance;
use crate::report::Answer;

/// Sources of the plots; see the README beside them.
const UPLOT: &str = include_str!("../../../assets/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../../assets/uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("../../../assets/uplot/LICENSE");
const SCRIPT: &str = include_str!("page.js");

/// The page for an answer about the machine called `machine`, and what made it.
///
/// # Errors
/// [`Error::Usage`] where the curves are no JSON, which numbers and names always are.
pub fn page(machine: &str, answer: &Answer, plot: &PlotData, made: &Provenance) -> Result<String, Error> {
    let data = escape::json(plot).map_err(|error| Error::Usage(format!("the page's data: {error}")))?;
    let verdict = answer.verdict.name();
    let names: Vec<&str> = plot.recordings.iter().map(|recording| recording.name.as_str()).collect();
    let script = Script {
        style: UPLOT_STYLE,
        without: "<noscript><p class=\"note\">The curves are drawn by a script, which is off here; every figure is in the \
                  tables.</p></noscript>\n",
        credit: "; plots by uPlot 1.6.32, MIT licence, text in the source of this page.",
        elements: format!(
            "<script type=\"application/json\" id=\"plot\">{data}</script>\n<script>\n/*\n{UPLOT_LICENCE}*/\n{UPLOT}\n\
             </script>\n<script>\n{SCRIPT}</script>\n"
        ),
    };
    let page = Page {
        title: format!("{machine}: {verdict}"),
        about: format!("Diagnosis of {machine} from {}", names.join(", ")),
        heading: badge(verdict, verdict) + &text(&words::sentence(answer)),
        picture: sections::picture(answer, plot),
        sections: sections(answer, plot),
        script: Some(script),
    };
    Ok(page.html(made))
}

/// The sections in their order; those that have nothing to say are left out.
fn sections(answer: &Answer, plot: &PlotData) -> Vec<Section> {
    let all = [
        sections::warnings(&answer.warnings),
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
    ];
    all.into_iter().flatten().collect()
}
