//! Text and data as a page may hold them, whatever a recording is called.

use serde::Serialize;

/// Text for the content or a quoted attribute of an element.
pub(crate) fn text(raw: &str) -> String {
    let mut safe = String::with_capacity(raw.len());
    for character in raw.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            other => safe.push(other),
        }
    }
    safe
}

/// JSON for the content of a `<script type="application/json">`: nothing in it can end the element or begin a comment.
///
/// # Errors
/// Data that is not JSON; the page's is.
pub(super) fn json(data: &impl Serialize) -> serde_json::Result<String> {
    // These stand in JSON only inside strings, where the escapes mean the same.
    Ok(serde_json::to_string(data)?.replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e"))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn markup_becomes_text() {
        assert_eq!(text("a<b>&\"'.csv"), "a&lt;b&gt;&amp;&quot;&#39;.csv");
    }

    #[test]
    fn data_cannot_end_the_script_and_reads_back() {
        let name = "</script><!-- & \" \u{2028}.csv";
        let safe = json(&name).unwrap();
        assert!(!safe.contains(['<', '>', '&']), "{safe}");
        assert_eq!(serde_json::from_str::<String>(&safe).unwrap(), name);
    }
}
