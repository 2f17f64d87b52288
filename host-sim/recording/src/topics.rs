//! Logs of several topics, each with its own rows: brought to the rows of the topic that has the position.

use std::path::Path;

use super::Column;
use super::columns::{Complaint, Header, HeaderColumn, Role, Wanted};
use super::values::{Cell, Values};
use crate::Error;

/// More columns in one topic are taken for a corrupt file; a robot has hundreds.
const MOST_COLUMNS: usize = 4096;

/// One topic: columns of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Topic {
    /// When each row was logged, ns; rising or equal. Empty where the log does not tell: then rows go with rows.
    pub(crate) logged_ns: Vec<u64>,
    /// Names, the topic's before its own, and cells.
    pub(crate) columns: Vec<(String, Series)>,
}

/// The cells of one column of a topic.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Series {
    /// Not a number where the row lacks one.
    Numbers(Vec<f64>),
    /// Empty where the row lacks one.
    Texts(Vec<String>),
}

/// One cell of a message.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Field {
    Number(f64),
    Text(String),
}

impl Topic {
    pub(crate) fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, cells)| cells.len())
    }

    /// Adds a row; the message says what is wrong with it.
    pub(crate) fn push(&mut self, logged_ns: u64, fields: Vec<(String, Field)>) -> Result<(), String> {
        let rows = self.logged_ns.len();
        self.logged_ns.push(logged_ns);
        for (index, (name, field)) in fields.into_iter().enumerate() {
            // Messages of a topic have their fields in one order, mostly.
            let is_here = self.columns.get(index).is_some_and(|(other, _)| *other == name);
            let place = if is_here { Some(index) } else { self.columns.iter().position(|(other, _)| *other == name) };
            let place = match place {
                Some(place) => place,
                None if self.columns.len() == MOST_COLUMNS => {
                    return Err(format!("has more than {MOST_COLUMNS} fields"));
                }
                None => {
                    self.columns.push((name, Series::like(&field, rows)));
                    self.columns.len() - 1
                }
            };
            self.columns[place].1.put(rows, field);
        }
        self.columns.iter_mut().for_each(|(_, cells)| cells.resize(rows + 1));
        Ok(())
    }

    /// Puts the rows in the order they were logged; files hold them in the order they were written.
    pub(crate) fn sort(&mut self) {
        if self.logged_ns.is_sorted() {
            return;
        }
        let mut order: Vec<usize> = (0..self.logged_ns.len()).collect();
        order.sort_by_key(|row| self.logged_ns[*row]);
        self.logged_ns.sort_unstable();
        for (_, cells) in &mut self.columns {
            match cells {
                Series::Numbers(values) => *values = order.iter().map(|row| values[*row]).collect(),
                Series::Texts(values) => *values = order.iter().map(|row| values[*row].clone()).collect(),
            }
        }
    }
}

impl Series {
    /// A column for such cells, of rows that lack one.
    fn like(field: &Field, rows: usize) -> Self {
        match field {
            Field::Number(_) => Self::Numbers(vec![f64::NAN; rows]),
            Field::Text(_) => Self::Texts(vec![String::new(); rows]),
        }
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Texts(values) => values.len(),
        }
    }

    fn resize(&mut self, rows: usize) {
        match self {
            Self::Numbers(values) => values.resize(rows, f64::NAN),
            Self::Texts(values) => values.resize(rows, String::new()),
        }
    }

    /// Sets the cell of the last row, of which there may be one already: a field that is there twice counts once.
    fn put(&mut self, row: usize, field: Field) {
        self.resize(row);
        match (self, field) {
            (Self::Numbers(values), Field::Number(value)) => values.push(value),
            (Self::Numbers(values), Field::Text(_)) => values.push(f64::NAN),
            (Self::Texts(values), Field::Text(text)) => values.push(text),
            (Self::Texts(values), Field::Number(value)) => values.push(format!("{value:?}")),
        }
    }

    fn cell(&self, row: usize) -> Cell {
        match self {
            Self::Numbers(values) => Cell::Real(values[row]),
            Self::Texts(values) => Cell::Text(values[row].clone()),
        }
    }
}

/// The columns of all topics at the rows of the one with the position (the longest without one), each other with the last it
/// had before; rows before all that are used have one are left out.
pub(crate) fn columns(file: &Path, topics: &[Topic], wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Error> {
    joined(topics, wanted).map_err(|Complaint { column, message }| Error::input(file, None, &column, message))
}

fn joined(topics: &[Topic], wanted: Wanted<'_>) -> Result<(Header, Vec<Values>), Complaint> {
    let all =
        || topics.iter().enumerate().flat_map(|(index, topic)| topic.columns.iter().map(move |column| (index, column)));
    let header = Header::resolve(all().map(|(_, (name, _))| name.clone()).collect(), wanted)?;
    let position = header.columns.iter().position(|column| column.role.column() == Some(Column::Position));
    let longest = || topics.iter().enumerate().rev().max_by_key(|(_, topic)| topic.rows()).map(|(index, _)| index);
    let base = position.and_then(|place| all().nth(place)).map(|(topic, _)| topic).or_else(longest);
    let Some(base) = base else { return Err(Complaint::new("", "it holds no topic with numbers")) };
    let used = |topic: usize| {
        header.columns.iter().zip(all()).any(|(column, (of, _))| of == topic && column.role.column().is_some())
    };
    let rows = held_rows(topics, base, used)?;
    let mut values = Vec::with_capacity(header.columns.len());
    for (column, (topic, (_, cells))) in header.columns.iter().zip(all()) {
        values.push(match &rows[topic] {
            Some(rows) if column.role != Role::Skipped => taken(column, header.mapped, cells, rows)?,
            _ => Values::Skipped,
        });
    }
    Ok((header, values))
}

/// The cells of a column at these rows of its topic.
fn taken(column: &HeaderColumn, mapped: bool, cells: &Series, rows: &[usize]) -> Result<Values, Complaint> {
    let mut values = Values::new(column.role);
    for (row, at) in rows.iter().enumerate() {
        let pushed = values.push_cell(cells.cell(*at)).and_then(|()| values.check_last(column.role.column(), mapped));
        pushed.map_err(|message| Complaint::new(&column.name, format!("row {}: {message}", row + 1)))?;
    }
    Ok(values)
}

/// For each topic the row of it that is held at each row of the base; none for a topic that has no place there.
fn held_rows(
    topics: &[Topic],
    base: usize,
    used: impl Fn(usize) -> bool,
) -> Result<Vec<Option<Vec<usize>>>, Complaint> {
    let clock = &topics[base].logged_ns;
    let mut held: Vec<Option<Vec<usize>>> = Vec::new();
    let mut first = 0;
    for (index, topic) in topics.iter().enumerate() {
        let timed = !clock.is_empty() && !topic.logged_ns.is_empty();
        let name = topic.columns.first().map_or("", |(name, _)| name.as_str());
        if index == base || (!timed && topic.rows() == topics[base].rows()) {
            held.push(Some((0..topics[base].rows()).collect()));
        } else if timed {
            let before = |now: &u64| topic.logged_ns.partition_point(|logged| logged <= now);
            let rows: Vec<usize> = clock.iter().map(before).collect();
            if used(index) {
                first = first.max(rows.partition_point(|count| *count == 0));
            }
            held.push(Some(rows.into_iter().map(|count| count.saturating_sub(1)).collect()));
        } else if used(index) {
            let (rows, others) = (topic.rows(), topics[base].rows());
            return Err(Complaint::new(name, format!("it has {rows} rows, but the position has {others}")));
        } else {
            held.push(None);
        }
    }
    for (rows, topic) in held.iter_mut().zip(topics) {
        match rows {
            Some(_) if topic.rows() == 0 => *rows = None,
            Some(rows) => drop(rows.drain(..first.min(rows.len()))),
            None => {}
        }
    }
    Ok(held)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn topic(logged_ns: &[u64], columns: &[(&str, &[f64])]) -> Topic {
        let columns = columns.iter().map(|(name, values)| ((*name).to_owned(), Series::Numbers(values.to_vec())));
        Topic { logged_ns: logged_ns.to_vec(), columns: columns.collect() }
    }

    #[test]
    fn a_slower_topic_is_held_and_rows_before_it_are_left_out() {
        let fast = topic(&[10, 20, 30, 40], &[("t_s", &[1.0, 2.0, 3.0, 4.0]), ("position_rad", &[0.1, 0.2, 0.3, 0.4])]);
        let slow = topic(&[15, 35], &[("torque_cmd_nm", &[5.0, 6.0])]);
        let (header, values) = joined(&[fast.clone(), slow], Wanted::Recording(None)).unwrap();
        assert_eq!(header.columns.len(), 3);
        assert_eq!(values[0], Values::Real(vec![2.0, 3.0, 4.0]));
        assert_eq!(values[2], Values::Real(vec![5.0, 5.0, 6.0]));
        let untimed = topic(&[], &[("torque_cmd_nm", &[5.0, 6.0])]);
        let error = joined(&[fast, untimed], Wanted::Recording(None)).unwrap_err();
        assert_eq!(
            (error.column.as_str(), error.message.as_str()),
            ("torque_cmd_nm", "it has 2 rows, but the position has 4")
        );
    }

    #[test]
    fn rows_are_put_in_the_order_they_were_logged() {
        let mut topic = Topic::default();
        for (logged_ns, value) in [(30, 3.0), (10, 1.0), (20, 2.0)] {
            topic.push(logged_ns, vec![("a".to_owned(), Field::Number(value))]).unwrap();
        }
        topic.push(40, vec![("b".to_owned(), Field::Text("x".to_owned()))]).unwrap();
        topic.sort();
        let Series::Numbers(values) = &topic.columns[0].1 else { unreachable!() };
        assert!(values[..3] == [1.0, 2.0, 3.0] && values[3].is_nan());
        assert_eq!(topic.columns[1].1, Series::Texts(["", "", "", "x"].map(str::to_owned).to_vec()));
    }
}
