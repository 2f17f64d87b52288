//! The mark by which servo-lab knows its own files again, so that it replaces no other without being told to.
//!
//! | format | mark |
//! |---|---|
//! | JSON, HTML, SVG, TOML, Markdown | [`WORDS`] in the first kilobyte: a value of `provenance`, else a comment |
//! | CSV | the last name of the header is in quotes and no other is: the same table to every reader of CSV, and the way no other program writes it (a comment would be no recording to other readers) |
//! | MCAP | [`WORDS`] as the library that wrote it, in the first kilobyte |
//! | Parquet | [`WORDS`] as a value of the file's metadata, which stands at its end |
//!
//! An empty file has nothing to lose and counts as marked.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Stands in every file that servo-lab wrote, but in CSV.
pub const WORDS: &str = "Written by servo-lab";

/// The words stand within this many bytes of the beginning.
const WORDS_WITHIN: usize = 1024;
/// Bytes of the beginning that are looked at; no header is longer.
const HEAD: u64 = 1 << 16;
/// Bytes of the end of a Parquet file that are looked at: its metadata closes with the values it was given.
const TAIL: u64 = 1 << 16;

/// A header row with the mark.
pub fn csv_header(names: &[&str]) -> String {
    let quoted = |name: &str| format!("\"{}\"", name.replace('"', "\"\""));
    let needs_quotes = |name: &str| name.contains([',', '"', '\n', '\r']);
    let cell = |(index, name): (usize, &&str)| {
        if index + 1 == names.len() || needs_quotes(name) { quoted(name) } else { (*name).to_owned() }
    };
    let cells: Vec<String> = names.iter().enumerate().map(cell).collect();
    cells.join(",") + "\n"
}

/// Whether servo-lab wrote the regular file, or it is empty.
///
/// # Errors
///
/// A file that cannot be read.
pub fn is_marked(file: &Path) -> io::Result<bool> {
    let mut file = File::open(file)?;
    let length = file.metadata()?.len();
    let mut head = Vec::new();
    (&mut file).take(HEAD).read_to_end(&mut head)?;
    if head.starts_with(b"PAR1") {
        file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
        let mut tail = Vec::new();
        file.read_to_end(&mut tail)?;
        return Ok(holds_words(&tail));
    }
    Ok(length == 0 || holds_words(&head[..head.len().min(WORDS_WITHIN)]) || is_csv_header(&head))
}

fn holds_words(bytes: &[u8]) -> bool {
    bytes.windows(WORDS.len()).any(|window| window == WORDS.as_bytes())
}

/// Whether the first line is a header as [`csv_header`] writes it: quotes around its last cell only, which is not its only
/// one.
fn is_csv_header(head: &[u8]) -> bool {
    let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let Some(comma) = line.iter().rposition(|byte| *byte == b',') else { return false };
    let (others, last) = (&line[..comma], &line[comma + 1..]);
    let inner = last.strip_prefix(b"\"").and_then(|last| last.strip_suffix(b"\""));
    !others.contains(&b'"') && inner.is_some_and(|name| !name.is_empty() && !name.contains(&b'"'))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn marked(content: &[u8]) -> bool {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), content).unwrap();
        is_marked(file.path()).unwrap()
    }

    #[test]
    fn own_files_are_known_and_others_are_not() {
        assert!(marked(b"") && marked(b"# Written by servo-lab\nschema = 1\n"));
        assert!(marked(csv_header(&["t_s", "position_rad"]).as_bytes()));
        // As other programs quote: nothing, everything, or the texts, which a header consists of.
        for other in
            ["t_s,position_rad\n0,1\n", "\"t_s\",\"position_rad\"\n", "\"t_s\"\n0\n", "t_s,\n", "t_s,\"\"\n", "x"]
        {
            assert!(!marked(other.as_bytes()), "{other:?}");
        }
        let far = format!("{}Written by servo-lab", "x".repeat(2000));
        assert!(!marked(far.as_bytes()), "a text that mentions the tool is not its own");
    }

    #[test]
    fn a_header_reads_back_whatever_the_names() {
        let names = ["t_s", "a, \"b\"", "last"];
        let header = csv_header(&names);
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(header.as_bytes());
        let read: Vec<_> = reader.records().map(Result::unwrap).collect();
        assert_eq!(read.len(), 1);
        assert_eq!(read[0].iter().collect::<Vec<_>>(), names);
    }
}
