//! What made a page, and how to make it again.

use super::escape::text;
use super::markup::{Section, table};
use crate::output::{CLOCK, Input, Provenance};

/// What made the page, and how to make it again.
pub(super) fn section(made: &Provenance) -> Section {
    let input = |input: &Input| {
        let sha256 = input.sha256.as_deref().unwrap_or("read once, not hashed");
        vec![format!("<code>{}</code>", text(&input.file)), format!("<code>{}</code>", text(sha256))]
    };
    let files = match &made.inputs[..] {
        [] => String::new(),
        inputs => table("Files that were read", &["file", "SHA-256"], inputs.iter().map(input).collect()),
    };
    let seed = made.seed.map_or_else(String::new, |seed| format!(", random draws from seed {seed}"));
    let body = format!(
        "<p>{} on {}, built from commit <code>{}</code>{seed}.</p>{files}<h3>Again</h3><pre role=\"region\" tabindex=\"0\" \
         aria-label=\"Commands that make this page again\">{}</pre>",
        text(&made.written_by),
        text(&made.date),
        text(&made.commit),
        text(&again(made))
    );
    Section::new("provenance", "How to reproduce this page", body)
}

/// The commands that make the page again, to the byte where the sources are those of the commit.
fn again(made: &Provenance) -> String {
    let (commit, changed) = made.commit.split_once(", ").map_or((made.commit.as_str(), false), |(one, _)| (one, true));
    let changed = if changed { "   # the sources had changes beside it" } else { "" };
    let hashed = made.inputs.iter().filter_map(|input| Some((input.sha256.as_ref()?, &input.file)));
    let sums: String = hashed.map(|(sha256, file)| format!("{sha256}  {file}\n")).collect();
    let sums = if sums.is_empty() { sums } else { format!("sha256sum -c <<'END'\n{sums}END\n") };
    let seconds = humantime::parse_rfc3339(&made.date).ok();
    let seconds = seconds.and_then(|date| date.duration_since(std::time::UNIX_EPOCH).ok());
    let clock = seconds.map_or_else(String::new, |since| format!("{CLOCK}={} ", since.as_secs()));
    format!("git checkout {commit}{changed}\ncargo install --path host-sim/lab\n{sums}{clock}{}\n", made.command)
}
