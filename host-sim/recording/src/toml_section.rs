//! Sections of a TOML file whose every key and number is checked, with file, line and key in each message.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::nearest::quoted;
use super::schema;
use super::vocabulary::{Allowed, LARGEST, SMALLEST};
use crate::Error;

/// The text of a TOML file, for the line of a span.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Source<'a> {
    pub(crate) file: &'a Path,
    pub(crate) text: &'a str,
}

impl<'a> Source<'a> {
    pub(crate) fn parse(self) -> Result<Spanned<DeTable<'a>>, Error> {
        DeTable::parse(self.text).map_err(|error| {
            let line = error.span().map(|span| self.line(&span));
            Error::input(self.file, line, "", format!("is not TOML: {}", error.message()))
        })
    }

    /// The one-based line a span begins at.
    pub(crate) fn line(self, span: &Range<usize>) -> u64 {
        let before = self.text.as_bytes().get(..span.start).unwrap_or_default();
        1 + before.iter().filter(|byte| **byte == b'\n').count() as u64
    }

    pub(crate) fn error(self, span: &Range<usize>, key: &str, message: impl Into<String>) -> Error {
        Error::input(self.file, Some(self.line(span)), key, message)
    }
}

/// One table of the file.
#[derive(Debug, Clone)]
pub(crate) struct Section<'a, 'i> {
    source: Source<'a>,
    /// As messages name it: empty at the top, else with a full stop at its end, such as `plant.er.`.
    prefix: String,
    span: Range<usize>,
    table: &'a DeTable<'i>,
}

/// A key of a section that is passed on as it stands, with what it is set to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pair {
    pub(crate) key: String,
    pub(crate) setting: Setting,
    pub(crate) span: Range<usize>,
}

/// A number or a flag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Setting {
    /// Finite.
    Number(f64),
    Flag(bool),
}

impl<'a, 'i> Section<'a, 'i> {
    /// The whole file.
    pub(crate) fn top(source: Source<'a>, document: &'a Spanned<DeTable<'i>>) -> Self {
        Self { source, prefix: String::new(), span: 0..0, table: document.get_ref() }
    }

    /// Where the section begins.
    pub(crate) fn span(&self) -> &Range<usize> {
        &self.span
    }

    /// An error about `key` of this section, at `span`.
    pub(crate) fn error(&self, span: &Range<usize>, key: &str, message: impl Into<String>) -> Error {
        self.source.error(span, &format!("{}{key}", self.prefix), message)
    }

    /// Its name in the schema: without indices and the full stop at the end.
    fn path(&self) -> &str {
        self.prefix.split('[').next().unwrap_or_default().trim_end_matches('.')
    }

    /// Refuses the first key, in file order, that is not one of `known`.
    pub(crate) fn only(&self, known: &[&str]) -> Result<(), Error> {
        let stranger =
            self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())).min_by_key(|key| key.span().start);
        stranger.map_or(Ok(()), |key| {
            let message = format!("unknown key; {}", schema::hint(self.path(), key.get_ref(), known));
            Err(self.error(&key.span(), quoted(key.get_ref()).trim_matches('`'), message))
        })
    }

    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
        self.table.get(key)
    }

    fn missing(&self, key: &str, allowed: &str) -> Error {
        self.error(&self.span, key, format!("is missing; must be {allowed}"))
    }

    fn must_be(&self, key: &str, value: &Spanned<DeValue<'_>>, allowed: &str) -> Error {
        self.error(&value.span(), key, format!("{} is not allowed; must be {allowed}", shown(value.get_ref())))
    }

    /// The section below called `key`.
    pub(crate) fn section(&self, key: &str) -> Result<Option<Self>, Error> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.must_be(key, value, &format!("a section [{}{key}]", self.prefix)));
        };
        let prefix = format!("{}{key}.", self.prefix);
        Ok(Some(Self { source: self.source, prefix, span: value.span(), table }))
    }

    /// The section below called `key`, which must be there.
    pub(crate) fn required_section(&self, key: &str) -> Result<Self, Error> {
        self.section(key)?.ok_or_else(|| {
            let message = format!("section [{}{key}] is missing", self.prefix);
            Error::input(self.source.file, None, "", message)
        })
    }

    /// The sections below called `[[key]]`, in file order; none where there is none.
    pub(crate) fn sections(&self, key: &str) -> Result<Vec<Self>, Error> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let kind = format!("sections [[{}{key}]]", self.prefix);
        let Some(array) = value.get_ref().as_array() else { return Err(self.must_be(key, value, &kind)) };
        let section = |(index, value): (usize, &'a Spanned<DeValue<'i>>)| match value.get_ref().as_table() {
            Some(table) => {
                let prefix = format!("{}{key}[{}].", self.prefix, index + 1);
                Ok(Self { source: self.source, prefix, span: value.span(), table })
            }
            None => Err(self.must_be(key, value, &kind)),
        };
        array.iter().enumerate().map(section).collect()
    }

    /// The text of `key`.
    pub(crate) fn text(&self, key: &str, allowed: &str) -> Result<Option<(&'a str, Range<usize>)>, Error> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) if !text.trim().is_empty() => Ok(Some((text, value.span()))),
            _ => Err(self.must_be(key, value, allowed)),
        }
    }

    /// The text of `key`, which must be there.
    pub(crate) fn required_text(&self, key: &str, allowed: &str) -> Result<(&'a str, Range<usize>), Error> {
        self.text(key, allowed)?.ok_or_else(|| self.missing(key, allowed))
    }

    /// The number of `key`.
    pub(crate) fn number(&self, key: &str, allowed: Allowed) -> Result<Option<f64>, Error> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match number(value.get_ref()) {
            Some(number) if allowed.holds(number) && allowed.is_wild(number) => {
                let of_a_size = format!("{allowed}, of a size from {SMALLEST:e} to {LARGEST:e}");
                Err(self.must_be(key, value, &of_a_size))
            }
            Some(number) if allowed.holds(number) => Ok(Some(number)),
            _ => Err(self.must_be(key, value, &allowed.to_string())),
        }
    }

    /// The number of `key`, which must be there.
    pub(crate) fn required_number(&self, key: &str, allowed: Allowed) -> Result<f64, Error> {
        self.number(key, allowed)?.ok_or_else(|| self.missing(key, &allowed.to_string()))
    }

    /// Every key and its setting, in file order.
    pub(crate) fn pairs(&self) -> Result<Vec<Pair>, Error> {
        let pair = |(key, value): (&Spanned<DeString<'i>>, &Spanned<DeValue<'i>>)| {
            let setting = match (value.get_ref(), number(value.get_ref())) {
                (DeValue::Boolean(flag), _) => Setting::Flag(*flag),
                (_, Some(number)) if number.is_finite() => Setting::Number(number),
                _ => return Err(self.must_be(key.get_ref(), value, "a finite number, true or false")),
            };
            Ok(Pair { key: key.get_ref().to_string(), setting, span: key.span() })
        };
        let mut pairs: Vec<_> = self.table.iter().map(pair).collect::<Result<_, _>>()?;
        pairs.sort_by_key(|pair| pair.span.start);
        Ok(pairs)
    }
}

/// The number, if the value is one; whole numbers count.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(whole) => i64::from_str_radix(whole.as_str(), whole.radix()).ok().map(|whole| whole as f64),
        _ => None,
    }
}

/// A value as a message shows it.
fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => quoted(text),
        DeValue::Integer(whole) => whole.to_string(),
        DeValue::Float(float) => float.to_string(),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(_) => "an array".to_owned(),
        DeValue::Table(_) => "a section".to_owned(),
    }
}
