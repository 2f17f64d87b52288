//! A column looked for among those of a log.

use super::names::fit;
use super::unit::unit_of;
use super::{Guess, has};
use crate::column_names::is_told_apart;
use crate::joints::{Joints, member};
use crate::nearest::quoted;
use crate::units::{self, Quantity};
use crate::{AxisKind, Column, MappedColumn, Table};

/// A column of a log that may be the one that is looked for.
struct Candidate<'a> {
    /// Whether it is of the topic of the position: what is not has other rows.
    beside: bool,
    score: u32,
    name: &'a str,
    values: &'a [f64],
}

/// What is looked through for a column.
pub(super) struct Search<'a> {
    pub(super) table: &'a Table,
    pub(super) joints: &'a Joints<'a>,
    pub(super) axis: AxisKind,
    /// What is known already.
    pub(super) taken: &'a [Guess],
}

impl<'a> Search<'a> {
    /// Columns that are not taken and of no other joint.
    fn free(&self) -> impl Iterator<Item = Candidate<'a>> {
        let position = self.taken.iter().find(|guess| guess.mapped.column == Column::Position);
        let topic = position.and_then(|guess| self.table.topic(&guess.mapped.name));
        let of = self.table.numbers.iter().zip(&self.table.topics);
        of.filter(|((name, _), _)| {
            !self.taken.iter().any(|guess| guess.mapped.name == *name) && !self.joints.is_of_another(name)
        })
        .map(move |((name, values), of)| Candidate {
            beside: topic.is_none_or(|topic| topic == *of),
            score: 0,
            name,
            values,
        })
    }

    /// The columns that fit, the likeliest first.
    fn fitting(&self, column: Column) -> Vec<Candidate<'a>> {
        let scored = |candidate: Candidate<'a>| {
            let rising = column != Column::Time || never_runs_back(candidate.values);
            fit(self.table, candidate.name, column, self.axis)
                .filter(|_| rising)
                .map(|score| Candidate { score, ..candidate })
        };
        let mut fitting: Vec<_> = self.free().filter_map(scored).collect();
        let efforts = if column == Column::Position { self.members_of_efforts() } else { Vec::new() };
        fitting.sort_by_cached_key(|candidate| {
            std::cmp::Reverse((candidate.beside, efforts.contains(&self.members(candidate.name)), candidate.score))
        });
        fitting
    }

    /// How many members the arrays of efforts have: of seven joints `q[2]` is a position beside `tau[2]`, and the three numbers of
    /// `ee_pos[2]` are where the hand is.
    fn members_of_efforts(&self) -> Vec<usize> {
        let fits = |name: &str, column| fit(self.table, name, column, self.axis).is_some();
        let efforts = self.names().filter(|name| fits(name, Column::EffortCmd) || fits(name, Column::EffortMeas));
        efforts.map(|effort| self.members(effort)).collect()
    }

    /// How many members the array of a name has; 1 where it is of none.
    fn members(&self, name: &str) -> usize {
        self.names().filter(|other| array_of(other) == array_of(name)).count()
    }

    fn names(&self) -> impl Iterator<Item = &'a str> {
        self.table.numbers.iter().map(|(name, _)| name.as_str())
    }

    /// The column by its name; an error where a required one is not found.
    pub(super) fn column(&self, column: Column) -> Result<Option<Guess>, String> {
        let (table, axis) = (self.table, self.axis);
        let mut fitting = self.fitting(column);
        let mut because = "by its name".to_owned();
        if fitting.is_empty() && column == Column::EffortCmd {
            fitting = self.fitting(Column::EffortMeas);
            "a measured one, there is no commanded one".clone_into(&mut because);
        }
        if fitting.is_empty() && column == Column::Time {
            if let Some(broken) = broken_time(table).or_else(|| not_numbers(table, column, axis)) {
                return Err(broken);
            }
            fitting = self.free().filter(|candidate| candidate.beside && rises(candidate.values)).take(1).collect();
            "the first that always rises".clone_into(&mut because);
        }
        let Some(Candidate { beside, score, name, values }) = fitting.first() else {
            let missing = || not_numbers(table, column, axis).unwrap_or_else(|| missing(table, column, axis));
            return if Column::REQUIRED.contains(&column) { Err(missing()) } else { Ok(None) };
        };
        let alike = |other: &&Candidate<'_>| (other.beside, other.score) == (*beside, *score);
        let rivals: Vec<_> = fitting[1..].iter().filter(alike).map(|other| quoted(other.name)).collect();
        if !rivals.is_empty() && is_told_apart(name) {
            let (key, rivals) = (column.key(axis), rivals.join(" or "));
            return Err(format!(
                "which column is `{key}`? {} or {rivals}; give it as --map \"{key}={name}\"",
                quoted(name)
            ));
        }
        if !rivals.is_empty() {
            because += &format!(", as well as {}", rivals.join(", "));
        }
        let (unit, unit_because, unit_unsure) = unit_of(table, column, axis, (name, values));
        let needs_scale = units::measure(&unit)
            .is_some_and(|measure| matches!(measure.quantity, Quantity::Current | Quantity::Voltage));
        let own = column.unit(axis);
        if needs_scale {
            let key = column.key(axis);
            because += &format!("; scale 1 {own}/{unit} is NOT KNOWN, give --map \"{key}={name}:{unit}*SCALE\"");
        }
        let mapped = MappedColumn::new(column, axis, name, &unit, needs_scale.then_some(1.0))?;
        let unsure = unit_unsure || needs_scale || !rivals.is_empty() || *score == 0;
        Ok(Some(Guess { mapped, because: format!("{because}; unit: {unit_because}"), unsure }))
    }
}

/// The array that a name is of, without the number of its member; the name where it is of none.
fn array_of(name: &str) -> &str {
    member(name).map_or(name, |(array, _)| array)
}

fn rises(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] > pair[0])
}

/// What a time by its name may do: stamps that are rounded repeat.
fn never_runs_back(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] >= pair[0]) && values.first() < values.last()
}

/// What is wrong with the column that is the time by its unit: another that rises in its place, as a counter of rows does, would
/// mislead.
fn broken_time(table: &Table) -> Option<String> {
    let is_time = |name: &str| fit(table, name, Column::Time, AxisKind::Rotary).is_some_and(|score| score > 100);
    let (name, values) = table.numbers.iter().find(|(name, _)| is_time(name))?;
    let row = values.windows(2).position(|pair| pair[1] <= pair[0])?;
    let (from, to, name) = (values[row], values[row + 1], quoted(name));
    let runs = if to < from { "where the file holds several runs, split it there; else " } else { "" };
    let advice = "mend the log, or give another column as --map \"time=NAME:s\"";
    Some(format!("{name} does not rise from {from} to {to}, rows {} and {}; {runs}{advice}", row + 1, row + 2))
}

/// What is wrong with the column that is the wanted one by its name, but does not hold numbers alone.
fn not_numbers(table: &Table, column: Column, axis: AxisKind) -> Option<String> {
    let score = |name: &&String| fit(table, name, column, axis);
    let name = table.others.iter().filter(|name| score(name).is_some()).max_by_key(score)?;
    let (key, unit, cell) = (column.key(axis), column.unit(axis), table.not_number(name)?);
    let dates = if column == Column::Time { dates(cell) } else { "" };
    Some(format!(
        "{} holds cells that are no finite numbers, the first {cell}, and is `{key}` by its name{dates}; leave those rows \
         out, for rows that are missing do no harm, or give another column as --map \"{key}=NAME:{unit}\"",
        quoted(name)
    ))
}

/// What to do about a time that is written as a date or a clock; nothing where it is not.
pub(super) fn dates(cell: &str) -> &'static str {
    let digits = cell.bytes().filter(u8::is_ascii_digit).count();
    if digits >= 4 && cell.matches([':', '-', '/']).count() >= 2 {
        "; dates are not read: add a column of seconds, in Python: t = pandas.to_datetime(log['NAME']); \
         log['t_s'] = (t - t[0]).dt.total_seconds()"
    } else {
        ""
    }
}

fn missing(table: &Table, column: Column, axis: AxisKind) -> String {
    let (key, unit) = (column.key(axis), column.unit(axis));
    let (what, or) = match column {
        Column::Time => {
            let rows = "; where no column is, and rows are evenly apart, say how far: --map \"time=[0]:ms*5\"";
            ("no column always rises", rows)
        }
        Column::Position => ("no name tells", "; where only a speed was logged, add its integral to the log first"),
        _ => ("no name tells", ""),
    };
    format!("which column is `{key}`? {what}; {}; give it as --map \"{key}=NAME:{unit}\"{or}", has(table))
}
