//! Texts with the mark of the tool, each in the way of its format.

use std::path::PathBuf;

use serde::Serialize;

use super::{Provenance, mark};
use crate::Error;

/// A document beside what made it.
#[derive(Serialize)]
struct Document<'a, T> {
    provenance: &'a Provenance,
    #[serde(flatten)]
    content: &'a T,
}

/// `content`, an object, as the text of a JSON file whose first key is `provenance`.
///
/// # Errors
/// Content that is no object, which is a mistake of the caller.
pub fn json(content: &impl Serialize, provenance: &Provenance) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(&Document { provenance, content });
    let failed = |error: serde_json::Error| Error::Output { file: PathBuf::from("JSON"), reason: error.to_string() };
    text.map(|text| text + "\n").map_err(failed)
}

/// An SVG or HTML text with the mark as a comment after its first tag.
pub fn markup(text: &str) -> String {
    let (first, rest) = text.split_at(text.find('>').map_or(0, |end| end + 1));
    format!("{first}\n<!-- {} -->{rest}", mark::WORDS)
}

/// A Markdown text with the mark, which is not shown.
pub fn markdown(text: &str) -> String {
    format!("<!-- {} -->\n\n{text}", mark::WORDS)
}

/// A machine file with the mark, and what it means to who edits it.
pub fn toml(text: &str) -> String {
    let words = mark::WORDS;
    // A byte order mark is one at the beginning only.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.starts_with(&format!("# {words}")) {
        return text.to_owned();
    }
    format!(
        "# {words}, which replaces this file when told to write it again; without this line it asks for --force.\n{text}"
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn texts_carry_the_mark_and_stay_what_they_are() {
        assert_eq!(markup("<svg width=\"1\">\n</svg>"), "<svg width=\"1\">\n<!-- Written by servo-lab -->\n</svg>");
        assert!(
            markup("<!DOCTYPE html>\n<html>").starts_with("<!DOCTYPE html>\n<!-- Written by servo-lab -->\n<html>")
        );
        let machine = toml("schema = 1\n");
        assert!(machine.ends_with("\nschema = 1\n") && machine.lines().count() == 2);
        assert_eq!(toml(&machine), machine, "an improved model that is improved again has one mark");
        let made = Provenance::without_inputs(Some(1));
        let text = json(&serde_json::json!({ "schema": 1 }), &made).unwrap();
        assert!(text.find(mark::WORDS).unwrap() < 100, "{text}");
        let read: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!((read["schema"].as_u64(), read["provenance"]["seed"].as_u64()), (Some(1), Some(1)));
        assert!(json(&[1.0], &made).is_err(), "a list has no place for it");
    }
}
