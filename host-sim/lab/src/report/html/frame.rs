//! The frame of every page: one dress, whatever a command has to say. A page opens from disk, with no file beside it and no
//! network.

use super::escape::text;
use super::markup::{Section, contents};
use super::provenance;
use crate::output::Provenance;

const STYLE: &str = include_str!("page.css");

/// What a page says; the frame adds the table of contents, and last how to make the page again.
pub(crate) struct Page {
    /// Of the window; text.
    pub title: String,
    /// What the page is about, above its heading; text.
    pub about: String,
    /// What came out, in a sentence; markup.
    pub heading: String,
    /// What is seen first, a figure; markup, empty for none.
    pub picture: String,
    /// In their order.
    pub sections: Vec<Section>,
    /// Of pages with curves to zoom in.
    pub script: Option<Script>,
}

/// What a page with curves needs beside.
pub(crate) struct Script {
    /// Style of the curves, before the frame's own.
    pub style: &'static str,
    /// What a reader without scripts is told; markup.
    pub without: &'static str,
    /// Who drew the curves; markup for the footer.
    pub credit: &'static str,
    /// Elements with data and programs; markup.
    pub elements: String,
}

impl Page {
    /// The text of the page, and what made it.
    pub(crate) fn html(mut self, made: &Provenance) -> String {
        self.sections.push(provenance::section(made));
        let [title, about] = [&self.title, &self.about].map(|raw| text(raw));
        let (heading, picture, contents) = (&self.heading, &self.picture, contents(&self.sections));
        let body: String = self.sections.iter().map(Section::markup).collect();
        let none = Script { style: "", without: "", credit: "", elements: String::new() };
        let Script { style, without, credit, elements } = self.script.as_ref().unwrap_or(&none);
        // Whatever the page holds, the browser loads nothing for it, and runs nothing where nothing is to run.
        let scripts = if self.script.is_some() { "; script-src 'unsafe-inline'" } else { "" };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" \
             content=\"default-src 'none'; style-src 'unsafe-inline'{scripts}\">\n<meta name=\"viewport\" \
             content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
             <title>{title}</title>\n<style>\n{style}\n{STYLE}</style>\n</head>\n<body>\n<a class=\"skip\" \
             href=\"#answer\">Skip to the answer</a>\n<main>\n<header><p class=\"quiet\">{about}</p>\n<h1 id=\"answer\" \
             tabindex=\"-1\">{heading}</h1></header>\n{without}{picture}{contents}{body}<footer class=\"quiet\">servo-lab \
             {}{credit}</footer>\n</main>\n{elements}</body>\n</html>\n",
            env!("CARGO_PKG_VERSION")
        )
    }
}
