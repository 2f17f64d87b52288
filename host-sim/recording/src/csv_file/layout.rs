//! How a CSV file is laid out, by its first lines: what separates its cells, and what other programs put above and below the header.

use std::io::{self, Cursor, Read, Seek, SeekFrom};

use super::cells::{have_decimal_commas, is_number, text};
use super::stream::Stream;
use super::{COMMENT, reader};
use crate::units;

/// Bytes and rows that are looked at.
const HEAD_BYTES: u64 = 1 << 16;
const HEAD_ROWS: usize = 200;
/// A row of data has a time and something that was measured.
const FEWEST_NUMBERS: usize = 2;

/// What the first lines tell of the others.
pub(super) struct Layout {
    pub(super) separator: u8,
    /// Whether runs of blanks separate the cells; the separator is a tab then.
    pub(super) blanks: bool,
    /// Whether a comma in a number is a decimal one.
    pub(super) decimal_comma: bool,
    /// Rows above the header: titles and settings of the program that wrote it.
    pub(super) above: usize,
    /// Whether a row of units stands below the header.
    pub(super) units: bool,
    /// The last comment before the first row, without its sign.
    comment: Vec<u8>,
}

impl Layout {
    pub(super) fn read(input: &mut (impl Read + Seek)) -> io::Result<Self> {
        let mut head = Vec::new();
        input.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
        input.seek(SeekFrom::Start(0))?;
        Ok(Self::of(&head))
    }

    fn of(head: &[u8]) -> Self {
        // Decimal commas are no separators where another sign is one; blanks are in names where another sign is one.
        for (separator, blanks) in [(b'\t', false), (b';', false), (b',', false), (b'\t', true)] {
            let rows = rows(head, separator, blanks);
            if let Some((above, units)) = table(&rows, blanks) {
                let decimal_comma = separator != b',' || have_decimal_commas(rows[above + 1..].iter().flatten());
                return Self { separator, blanks, decimal_comma, above, units, comment: Vec::new() };
            }
        }
        Self::plain(head)
    }

    /// A file that begins with its header, or with its first row of numbers.
    fn plain(head: &[u8]) -> Self {
        let lines = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        let mut comment: &[u8] = &[];
        let mut first: &[u8] = &[];
        for line in lines.split(|byte| matches!(byte, b'\r' | b'\n')).filter(|line| !line.is_empty()) {
            if line[0] != COMMENT {
                first = line;
                break;
            }
            comment = line[1..].trim_ascii_start();
        }
        let separator = separator(first);
        let all_numbers = |rows: &[Vec<String>]| {
            rows.first().is_some_and(|row| row.len() >= FEWEST_NUMBERS && named(row).iter().all(|cell| is_number(cell)))
        };
        let apart = rows(head, separator, false);
        let blanks = !all_numbers(&apart) && all_numbers(&rows(head, b'\t', true));
        let separator = if blanks { b'\t' } else { separator };
        let decimal_comma = separator != b',' || have_decimal_commas(apart.iter().flatten());
        Self { separator, blanks, decimal_comma, above: 0, units: false, comment: comment.to_vec() }
    }

    /// The names of the columns by the comment; none where it has not as many as the first row has cells.
    pub(super) fn names(&self, cells: usize) -> Option<Vec<String>> {
        let text = text(&self.comment);
        let name = |name: &str| name.trim().trim_matches('"').to_owned();
        let names: Vec<String> = if self.blanks {
            text.split_whitespace().map(name).collect()
        } else {
            text.split(char::from(self.separator)).map(name).collect()
        };
        (names.len() == cells && !names.iter().all(|name| is_number(name))).then_some(names)
    }
}

/// What separates the cells of a line outside quotes.
fn separator(line: &[u8]) -> u8 {
    let mut quoted = false;
    let outside: Vec<u8> = line
        .iter()
        .copied()
        .filter(|byte| {
            quoted ^= *byte == b'"';
            !quoted
        })
        .collect();
    [b'\t', b';'].into_iter().find(|separator| outside.contains(separator)).unwrap_or(b',')
}

/// The first rows, of which the last may be cut.
fn rows(head: &[u8], separator: u8, blanks: bool) -> Vec<Vec<String>> {
    let rows = reader(Stream::new(Cursor::new(head), blanks), separator).into_byte_records();
    let cells = |row: csv::ByteRecord| row.iter().map(|cell| text(cell).trim().to_owned()).collect();
    rows.map_while(Result::ok).take(HEAD_ROWS).map(cells).collect()
}

/// The cells that have names: programs that end every line with a separator have one more, which is empty.
pub(super) fn named(header: &[String]) -> &[String] {
    match header {
        [named @ .., last] if last.is_empty() && !named.is_empty() => named,
        _ => header,
    }
}

/// How many rows stand above the header, and whether units stand below; none where no row is a header of the first row of
/// numbers. Rows of numbers are never above a header.
fn table(rows: &[Vec<String>], blanks: bool) -> Option<(usize, bool)> {
    for (above, header) in rows.iter().enumerate() {
        let names = named(header);
        let below = &rows[above + 1..];
        let fits = |row: &[String]| row.len() == names.len() || named(row).len() == names.len();
        let units = below.first().is_some_and(|row| fits(row) && are_units(row));
        let data = below.get(usize::from(units)).is_some_and(|row| fits(row) && numbers(row) >= FEWEST_NUMBERS);
        if are_names(names) && data {
            // The same header twice: what stands between is data. Two rows of names: which are the names, nobody knows.
            let first = above.checked_sub(1).map(|before| named(&rows[before]));
            let is_second = first.is_some_and(|first| first.len() == names.len() && are_names(first) && differ(first));
            return (!is_second && !rows[..above].contains(header)).then_some((above, units));
        }
        // A title in words, `Run 2 of 5`, has numbers too where blanks separate.
        let is_title = blanks && 2 * numbers(header) <= header.len();
        if numbers(header) >= FEWEST_NUMBERS && !is_title {
            return None;
        }
    }
    None
}

fn are_names(names: &[String]) -> bool {
    names.len() >= FEWEST_NUMBERS && !names.iter().any(|name| name.is_empty() || is_number(name))
}

/// Whether no name is there twice, as the names of groups of columns are.
fn differ(names: &[String]) -> bool {
    names.iter().enumerate().all(|(at, name)| !names[..at].contains(name))
}

fn numbers(row: &[String]) -> usize {
    row.iter().filter(|cell| is_number(cell)).count()
}

/// Whether a row holds units and nothing that could be data.
fn are_units(row: &[String]) -> bool {
    row.iter().any(|cell| units::measure(unit(cell)).is_some()) && numbers(row) == 0
}

/// A unit without the brackets around it.
pub(super) fn unit(cell: &str) -> &str {
    let inside = |(open, close): (char, char)| cell.strip_prefix(open)?.strip_suffix(close);
    [('[', ']'), ('(', ')'), ('{', '}')].into_iter().find_map(inside).unwrap_or(cell).trim()
}
