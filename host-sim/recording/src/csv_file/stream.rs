//! The bytes of a CSV file on their way to the parser.

use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

use super::COMMENT;

/// A stream that remembers its last byte (a file that does not end with a line break may end within a number), and in which
/// each run of blanks is one tab where blanks separate the cells.
pub(super) struct Stream<R> {
    inner: R,
    blanks: Option<Blanks>,
    /// As it stands in the file.
    pub(super) last: Option<u8>,
}

impl<R: Read> Stream<R> {
    pub(super) fn new(inner: R, separated_by_blanks: bool) -> Self {
        Self { inner, blanks: separated_by_blanks.then_some(Blanks::START), last: None }
    }

    pub(super) fn into_inner(self) -> R {
        self.inner
    }
}

impl<R: Read> Read for Stream<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = self.inner.read(buffer)?;
            if let Some(last) = buffer[..count].last() {
                self.last = Some(*last);
            }
            let kept = self.blanks.as_mut().map_or(count, |blanks| blanks.squeeze(&mut buffer[..count]));
            // Nothing is the end of the file; of blanks alone nothing may be left.
            if kept > 0 || count == 0 {
                return Ok(kept);
            }
        }
    }
}

/// Where in a line the bytes are, for those to come.
struct Blanks {
    /// Only blanks since the line began.
    at_start: bool,
    /// The byte before was a blank, or the line begins.
    in_run: bool,
    in_quotes: bool,
    in_comment: bool,
}

impl Blanks {
    const START: Self = Self { at_start: true, in_run: true, in_quotes: false, in_comment: false };

    /// Makes each run of blanks outside quotes one tab, and none at the beginning of a line; how many bytes are left.
    fn squeeze(&mut self, bytes: &mut [u8]) -> usize {
        let mut kept = 0;
        for index in 0..bytes.len() {
            let byte = bytes[index];
            let is_blank = matches!(byte, b' ' | b'\t') && !self.in_quotes && !self.in_comment;
            if is_blank && self.in_run {
                continue;
            }
            bytes[kept] = if is_blank { b'\t' } else { byte };
            kept += 1;
            if matches!(byte, b'\n' | b'\r') && !self.in_quotes {
                *self = Self::START;
                continue;
            }
            self.in_comment |= self.at_start && byte == COMMENT;
            // A quote within a word is one of its letters.
            if byte == b'"' && !self.in_comment && (self.in_quotes || self.in_run) {
                self.in_quotes = !self.in_quotes;
            }
            (self.at_start, self.in_run) = (false, is_blank);
        }
        kept
    }
}

/// The one-based line of the row that begins at `byte`, or after the line breaks and comments there.
///
/// The line that `csv` counts lags behind by blank lines and by one where lines end as on Windows; so the lines are
/// counted afresh, once there is something to complain about.
pub(super) fn line_at(mut input: impl Read + Seek, separated_by_blanks: bool, byte: u64) -> io::Result<u64> {
    input.seek(SeekFrom::Start(0))?;
    let mut bytes = BufReader::new(Stream::new(input, separated_by_blanks));
    let mut line = 1;
    let mut left = byte;
    let mut in_comment = false;
    loop {
        let buffer = bytes.fill_buf()?;
        let Some(first) = buffer.first() else { return Ok(line) };
        if left == 0 {
            in_comment = *first == COMMENT || (in_comment && !matches!(first, b'\r' | b'\n'));
            if !in_comment && !matches!(first, b'\r' | b'\n') {
                return Ok(line);
            }
        }
        // Beyond `byte` one at a time, up to the first that is no line break.
        let count = usize::try_from(left).unwrap_or(usize::MAX).clamp(1, buffer.len());
        line += buffer[..count].iter().filter(|byte| **byte == b'\n').count() as u64;
        bytes.consume(count);
        left = left.saturating_sub(count as u64);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn runs_of_blanks_are_one_tab_wherever_a_read_ends() {
        let text = "  a   \"b  c\"\t d\n# x  \"y\n\n 1 5\" 2  \r\n";
        for chunk in 1..text.len() {
            let mut stream = Stream::new(text.as_bytes(), true);
            let (mut squeezed, mut buffer) = (Vec::new(), vec![0; chunk]);
            loop {
                let count = stream.read(&mut buffer).unwrap();
                if count == 0 {
                    break;
                }
                squeezed.extend_from_slice(&buffer[..count]);
            }
            assert_eq!(String::from_utf8(squeezed).unwrap(), "a\t\"b  c\"\td\n# x  \"y\n\n1\t5\"\t2\t\r\n", "{chunk}");
        }
    }
}
