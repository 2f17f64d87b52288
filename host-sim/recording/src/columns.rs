//! Columns of a recording: their names on each kind of axis, and the header made sense of.

use super::column_names::{refuse_unusable_names, told_apart};
use super::mapping::Reading;
use super::nearest::{misspelt, quoted};
use super::units::{self, Quantity};
use super::{AxisKind, MappedColumn, Mapping};

/// The name that a mapping gives the time of a log without one: the number of the row, counted from 0. Columns without names count from 1.
pub(crate) const ROW: &str = "[0]";

/// A column the format knows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Column {
    /// Time, s.
    Time,
    /// Reference, rad or m.
    Reference,
    /// Position, rad or m.
    Position,
    /// Commanded torque or force, N m or N.
    EffortCmd,
    /// Commanded field, kV/mm.
    FieldCmd,
    /// Commanded mode of the damper.
    Mode,
    /// Speed estimate, rad/s or m/s.
    Velocity,
    /// Measured torque or force, N m or N.
    EffortMeas,
    /// Field that acted, kV/mm.
    FieldMeas,
    /// Temperature, Celsius.
    Temperature,
    /// Sequence number of the control tick.
    Seq,
    /// Fault word.
    Fault,
    /// Resolver counts.
    Counts,
}

impl Column {
    /// Every column, in the order a written recording has them.
    pub const ALL: [Self; 13] = [
        Self::Time,
        Self::Reference,
        Self::Position,
        Self::EffortCmd,
        Self::FieldCmd,
        Self::Mode,
        Self::Velocity,
        Self::EffortMeas,
        Self::FieldMeas,
        Self::Temperature,
        Self::Seq,
        Self::Fault,
        Self::Counts,
    ];

    /// Columns no recording can do without.
    pub const REQUIRED: [Self; 3] = [Self::Time, Self::Position, Self::EffortCmd];

    /// The name in the header.
    pub fn name(self, axis: AxisKind) -> &'static str {
        let (rotary, linear) = match self {
            Self::Time => ("t_s", "t_s"),
            Self::Reference => ("reference_rad", "reference_m"),
            Self::Position => ("position_rad", "position_m"),
            Self::EffortCmd => ("torque_cmd_nm", "force_cmd_n"),
            Self::FieldCmd => ("field_cmd_kv_mm", "field_cmd_kv_mm"),
            Self::Mode => ("mode", "mode"),
            Self::Velocity => ("velocity_rad_s", "velocity_m_s"),
            Self::EffortMeas => ("torque_meas_nm", "force_meas_n"),
            Self::FieldMeas => ("field_meas_kv_mm", "field_meas_kv_mm"),
            Self::Temperature => ("temperature_c", "temperature_c"),
            Self::Seq => ("seq", "seq"),
            Self::Fault => ("fault", "fault"),
            Self::Counts => ("counts", "counts"),
        };
        match axis {
            AxisKind::Rotary => rotary,
            AxisKind::Linear => linear,
        }
    }

    fn named(name: &str, axis: AxisKind) -> Option<Self> {
        Self::ALL.into_iter().find(|column| column.name(axis) == name)
    }

    /// Whether the name tells the kind of axis.
    fn tells_axis(self) -> bool {
        self.name(AxisKind::Rotary) != self.name(AxisKind::Linear)
    }
}

/// What is wrong with a header or a cell; the reader adds where.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Complaint {
    /// The column; empty where it is about none.
    pub(crate) column: String,
    pub(crate) message: String,
}

impl Complaint {
    pub(crate) fn new(column: &str, message: impl Into<String>) -> Self {
        Self { column: column.to_owned(), message: message.into() }
    }
}

/// What a log is read as.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Wanted<'a> {
    /// A recording with the format's own columns; of this axis, where a machine tells.
    Recording(Option<AxisKind>),
    /// A recording whose columns a machine file names; the format's own where the log has none of those.
    Mapped(AxisKind, &'a Mapping),
    /// Every column as it stands, with rows.
    Table,
    /// The same of a table of words, which may have no rows.
    Words,
}

/// One column of a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeaderColumn {
    pub(crate) name: String,
    pub(crate) role: Role,
    /// What a row of units says of it.
    pub(crate) unit: Option<String>,
    /// The first cell that is no finite number, where the reader knows its line and nobody has said what the column is.
    pub(crate) not_number: Option<NotNumber>,
}

impl HeaderColumn {
    fn new(name: String, role: Role) -> Self {
        Self { name, role, unit: None, not_number: None }
    }
}

/// A cell that is no finite number.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NotNumber {
    /// `line 17`, or `row 16` in files that have no lines.
    pub(crate) place: String,
    pub(crate) cell: String,
}

impl NotNumber {
    /// In the row of this index.
    pub(crate) fn at(row: usize, cell: &str) -> Self {
        Self { place: format!("row {}", row + 1), cell: cell.to_owned() }
    }
}

/// What a column of a file is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Role {
    /// A column of the format, and how its numbers are read.
    Known(Column, Reading),
    /// One the format does not know, kept as text.
    Other,
    /// One that a mapping does not name, not read.
    Skipped,
}

impl Role {
    /// The column of the format.
    pub(crate) fn column(self) -> Option<Column> {
        match self {
            Self::Known(column, _) => Some(column),
            Self::Other | Self::Skipped => None,
        }
    }
}

/// A header made sense of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Header {
    pub(crate) axis: AxisKind,
    pub(crate) columns: Vec<HeaderColumn>,
    /// Whether a mapping named the columns.
    pub(crate) mapped: bool,
    /// Rows above the header that are left out.
    pub(crate) rows_above: usize,
    /// How the number of a row is read as its time, where a mapping says so of a log that has no other.
    pub(crate) row_time: Option<Reading>,
}

impl Header {
    /// Checks the column names: not doubled, of one kind of axis (the machine's, where it tells), and none of the
    /// required ones missing.
    pub(crate) fn resolve(names: Vec<String>, wanted: Wanted<'_>) -> Result<Self, Complaint> {
        let has_own = match wanted {
            Wanted::Recording(_) => true,
            Wanted::Mapped(_, mapping) => mapping.is_empty(),
            Wanted::Table | Wanted::Words => false,
        };
        let names = if has_own { names } else { told_apart(&names) };
        refuse_unusable_names(&names)?;
        let expected = match wanted {
            Wanted::Recording(expected) => expected,
            Wanted::Mapped(axis, mapping) if mapping.is_empty() => Some(axis),
            Wanted::Mapped(axis, mapping) => match Self::mapped(&names, axis, mapping) {
                Some(header) => return header,
                None => Some(axis),
            },
            Wanted::Table | Wanted::Words => {
                let columns = names.into_iter().map(|name| HeaderColumn::new(name, Role::Other)).collect();
                return Ok(Self { axis: AxisKind::Rotary, columns, mapped: false, rows_above: 0, row_time: None });
            }
        };
        let axis = axis_of(&names, expected)?;
        let columns: Vec<_> = names
            .into_iter()
            .map(|name| {
                let role = Column::named(&name, axis).map_or(Role::Other, |column| Role::Known(column, Reading::PLAIN));
                HeaderColumn::new(name, role)
            })
            .collect();
        let header = Self { axis, columns, mapped: false, rows_above: 0, row_time: None };
        let missing: Vec<&str> = Column::REQUIRED
            .into_iter()
            .filter(|required| !header.columns.iter().any(|column| column.role.column() == Some(*required)))
            .map(|required| required.name(axis))
            .collect();
        if missing.is_empty() { Ok(header) } else { Err(header.missing(&missing)) }
    }

    /// The header by a mapping; none where the log has none of the names but the format's own columns.
    fn mapped(names: &[String], axis: AxisKind, mapping: &Mapping) -> Option<Result<Self, Complaint>> {
        let places: Vec<_> = mapping.columns().iter().map(|mapped| (mapped, place(names, &mapped.name))).collect();
        let own = |column: &Column| names.iter().any(|name| name == column.name(axis));
        if places.iter().all(|(_, place)| place.is_none()) && Column::REQUIRED.iter().all(own) {
            return None;
        }
        let mut columns: Vec<_> = names.iter().map(|name| HeaderColumn::new(name.clone(), Role::Skipped)).collect();
        let mut row_time = None;
        for (mapped, place) in places {
            match place {
                Some(place) => columns[place].role = Role::Known(mapped.column, mapped.reading()),
                None if mapped.is_row() => row_time = Some(mapped.reading()),
                None => return Some(Err(unmapped(names, axis, mapped))),
            }
        }
        Some(Ok(Self { axis, columns, mapped: true, rows_above: 0, row_time }))
    }

    /// All required columns that are missing, each with the one that may be meant to be it.
    fn missing(&self, missing: &[&str]) -> Complaint {
        let unknown =
            || self.columns.iter().filter(|column| column.role == Role::Other).map(|column| column.name.as_str());
        let hint = |required: &str| units::called_alike(required, unknown()).map(|near| units::hint(near, required));
        let names: Vec<_> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let has = format!("the file has {}", quoted_list(&names));
        if let [only] = missing {
            let hint = hint(only).unwrap_or(has);
            return Complaint::new(only, format!("required column is missing; {hint}"));
        }
        let hints: Vec<String> = missing.iter().filter_map(|name| Some(format!("{name}: {}", hint(name)?))).collect();
        let hints = if hints.is_empty() { has } else { hints.join("; ") };
        Complaint::new(&missing.join(", "), format!("required columns are missing; {hints}"))
    }
}

/// Where the column `name` of a mapping is: by its whole name, or by the end of one only, behind the topic it is in.
pub(crate) fn place(names: &[String], name: &str) -> Option<usize> {
    let whole = names.iter().position(|other| other == name);
    let by_end = || {
        let ends = |other: &&String| other.strip_suffix(name).is_some_and(|before| before.ends_with('.'));
        let mut found = names.iter().enumerate().filter(|(_, other)| ends(other)).map(|(index, _)| index);
        found.next().filter(|_| found.next().is_none())
    };
    whole.or_else(by_end)
}

/// That the column of a mapping is not in the log.
fn unmapped(names: &[String], axis: AxisKind, mapped: &MappedColumn) -> Complaint {
    let near = misspelt(&mapped.name, names.iter().map(String::as_str));
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    let hint = near
        .map_or_else(|| format!("the file has {}", quoted_list(&names)), |near| format!("is {} meant?", quoted(near)));
    let key = mapped.column.key(axis);
    Complaint::new(
        &mapped.name,
        format!("column is missing, which [columns] of the machine file names as `{key}`; {hint}"),
    )
}

/// At most a dozen names, for a message.
pub(crate) fn quoted_list(names: &[&str]) -> String {
    let shown: Vec<_> = names.iter().take(12).map(|name| quoted(name)).collect();
    let more = names.len().saturating_sub(shown.len());
    if more == 0 { shown.join(", ") } else { format!("{} and {more} more", shown.join(", ")) }
}

/// The kind of axis the names tell; `expected` where they tell none.
fn axis_of(names: &[String], expected: Option<AxisKind>) -> Result<AxisKind, Complaint> {
    let first =
        |axis| names.iter().find(|name| Column::named(name, axis).is_some_and(Column::tells_axis)).map(String::as_str);
    match (first(AxisKind::Rotary), first(AxisKind::Linear), expected) {
        (Some(rotary), Some(linear), _) => {
            let message = format!("mixed runs: the column is of a linear axis, but `{rotary}` is of a rotary one");
            Err(Complaint::new(linear, message))
        }
        (Some(name), None, Some(AxisKind::Linear)) => Err(wrong_axis(name, AxisKind::Rotary)),
        (None, Some(name), Some(AxisKind::Rotary)) => Err(wrong_axis(name, AxisKind::Linear)),
        (None, Some(_), _) => Ok(AxisKind::Linear),
        (Some(_), None, _) => Ok(AxisKind::Rotary),
        // Columns in other units tell it too.
        (None, None, expected) => {
            let linear = |name: &String| {
                matches!(units::quantity(name), Some(Quantity::Length | Quantity::Force | Quantity::Speed))
            };
            Ok(expected.unwrap_or(if names.iter().any(linear) { AxisKind::Linear } else { AxisKind::Rotary }))
        }
    }
}

fn wrong_axis(name: &str, recording: AxisKind) -> Complaint {
    let machine = match recording {
        AxisKind::Rotary => AxisKind::Linear,
        AxisKind::Linear => AxisKind::Rotary,
    };
    let (recording, machine) = (recording.name(), machine.name());
    let message = format!("the column is of a {recording} axis, but the axis of the machine is {machine}");
    Complaint::new(name, message)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn resolve(names: &str, expected: Option<AxisKind>) -> Result<Header, String> {
        let names = names.split(',').map(str::to_owned).collect();
        Header::resolve(names, Wanted::Recording(expected))
            .map_err(|complaint| format!("{}: {}", complaint.column, complaint.message))
    }

    #[test]
    fn units_tell_the_axis() {
        assert_eq!(resolve("t_s,position_rad,torque_cmd_nm", None).unwrap().axis, AxisKind::Rotary);
        assert_eq!(resolve("t_s,position_m,force_cmd_n,x", None).unwrap().axis, AxisKind::Linear);
        let error = resolve("t_s,position_m,force_cmd_n", Some(AxisKind::Rotary)).unwrap_err();
        assert_eq!(error, "position_m: the column is of a linear axis, but the axis of the machine is rotary");
        let error = resolve("t_s,position_m,torque_cmd_nm", None).unwrap_err();
        assert!(error.contains("mixed runs") && error.contains("torque_cmd_nm"), "{error}");
    }

    #[test]
    fn bad_headers_name_the_column() {
        let error = resolve("t_s,positon_rad,torque_cmd_nm", None).unwrap_err();
        assert_eq!(error, "position_rad: required column is missing; is `positon_rad` meant to be it?");
        let error = resolve("t_s,t_s,position_rad,torque_cmd_nm", None).unwrap_err();
        assert_eq!(error, "t_s: column is there twice, as column 1 and column 2");
        let error = resolve("t_ms,position_rad,torque_cmd_nm", None).unwrap_err();
        assert_eq!(
            error,
            "t_s: required column is missing; `t_ms` is in ms: multiply its values by 0.001 and call it `t_s`, in s"
        );
        let error = resolve("t_s,position_mm,force_cmd_n", None).unwrap_err();
        assert!(error.starts_with("position_m: required column is missing; `position_mm` is in mm: "), "{error}");
        let error = resolve("time,position_mm,humidity", None).unwrap_err();
        assert_eq!(
            error,
            "t_s, position_m, force_cmd_n: required columns are missing; t_s: is `time` meant to be it? It must be in s; \
             position_m: `position_mm` is in mm: multiply its values by 0.001 and call it `position_m`, in m"
        );
        let error = resolve("a,b", None).unwrap_err();
        assert!(error.starts_with("t_s, position_rad, torque_cmd_nm: ") && error.ends_with("has `a`, `b`"), "{error}");
        assert!(resolve("0,1,2", None).unwrap_err().contains("header row is missing"));
        assert!(resolve("t_s,,position_rad", None).unwrap_err().contains("column 2 has no name"));
    }
}
