//! Sections and tables of a page.

use super::escape::text;

/// A part of the page, which the table of contents names.
pub(crate) struct Section {
    /// What its link leads to.
    pub id: &'static str,
    /// Its title; text, no markup.
    pub heading: String,
    /// Markup.
    pub body: String,
}

impl Section {
    pub(crate) fn new(id: &'static str, heading: &str, body: String) -> Self {
        Self { id, heading: heading.to_owned(), body }
    }

    /// The section as markup.
    pub(super) fn markup(&self) -> String {
        let (id, heading, body) = (self.id, text(&self.heading), &self.body);
        format!("<section aria-labelledby=\"{id}\"><h2 id=\"{id}\" tabindex=\"-1\">{heading}</h2>{body}</section>\n")
    }
}

/// Links to the sections.
pub(super) fn contents(sections: &[Section]) -> String {
    let link = |section: &Section| format!("<li><a href=\"#{}\">{}</a></li>", section.id, text(&section.heading));
    let links: String = sections.iter().map(link).collect();
    format!("<nav aria-label=\"Contents\"><h2>Contents</h2><ul>{links}</ul></nav>\n")
}

/// A table; captions and headings are text, cells are markup. A wide one is moved by the keyboard, too.
pub(crate) fn table(caption: &str, head: &[&str], rows: Vec<Vec<String>>) -> String {
    let head: String = head.iter().map(|cell| format!("<th scope=\"col\">{}</th>", text(cell))).collect();
    let row = |cells: Vec<String>| {
        let mut cells = cells.into_iter();
        let first = cells.next().unwrap_or_default();
        let rest: String = cells.map(|cell| format!("<td>{cell}</td>")).collect();
        format!("<tr><th scope=\"row\">{first}</th>{rest}</tr>")
    };
    let rows: String = rows.into_iter().map(row).collect();
    let caption = text(caption);
    format!(
        "<div class=\"table\" role=\"region\" tabindex=\"0\" aria-label=\"{caption}\"><table><caption>{caption}</caption><thead>\
         <tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>"
    )
}

/// A table of text.
pub(crate) fn plain<'a>(caption: &str, head: &[&str], rows: impl IntoIterator<Item = &'a Vec<String>>) -> String {
    let escaped = |row: &'a Vec<String>| row.iter().map(|cell| text(cell)).collect();
    table(caption, head, rows.into_iter().map(escaped).collect())
}

/// A verdict in a word, before a heading; the kind is its colour.
pub(crate) fn badge(kind: &str, word: &str) -> String {
    format!("<span class=\"verdict {kind}\">{}</span> ", text(word))
}
