//! One recording, as columns.

use std::ffi::OsStr;
use std::ops::Range;
use std::path::Path;

use super::columns::{Header, HeaderColumn, Role};
use super::nearest::misspelt;
use super::units;
use super::values::Values;
use super::{AxisKind, Column, Mode, gaps};
use crate::Error;

/// Samples of one run: columns of equal length, at least one row, time strictly rising.
///
/// Commands of a row are held from its time to the next; the position is sampled at the row's time, before that row's
/// command acts. Units follow [`AxisKind`].
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// File name without its folder, as answers name it.
    pub name: String,
    /// Rotary or linear.
    pub axis: AxisKind,
    /// s.
    pub t_s: Vec<f64>,
    /// rad or m.
    pub position: Vec<f64>,
    /// Commanded torque or force, N m or N.
    pub effort_cmd: Vec<f64>,
    /// rad or m.
    pub reference: Option<Vec<f64>>,
    /// kV/mm.
    pub field_cmd_kv_mm: Option<Vec<f64>>,
    /// Commanded mode of the damper.
    pub mode: Option<Vec<Mode>>,
    /// The controller's speed estimate, rad/s or m/s.
    pub velocity: Option<Vec<f64>>,
    /// Measured torque or force, N m or N.
    pub effort_meas: Option<Vec<f64>>,
    /// Field that acted, kV/mm.
    pub field_meas_kv_mm: Option<Vec<f64>>,
    /// Celsius.
    pub temperature_c: Option<Vec<f64>>,
    /// Sequence number of the control tick.
    pub seq: Option<Vec<u64>>,
    /// Fault word of the controller.
    pub fault: Option<Vec<u32>>,
    /// Position in resolver counts, unwrapped across pole pairs.
    pub counts: Option<Vec<i64>>,
    /// Indices `i` where samples are missing between rows `i` and `i + 1`; the model is simulated across, no residual
    /// is taken there.
    pub gaps: Vec<usize>,
    /// Columns the format does not know, kept as text and reported; of a recording that was in memory without their cells.
    pub extra: Vec<(String, Vec<String>)>,
    /// What was taken out on the way in, a sentence each: times that repeat, rows between two samples.
    pub mended: Vec<String>,
}

/// The column of a simulation that names what stood beside the flashed law and replaced its commands.
pub const BESIDE_THE_LAW: &str = "mode_beside_the_law";

/// The cells of one column, as [`Recording::columns`] lists them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cells<'a> {
    /// Finite numbers in the unit of the column's name.
    Real(&'a [f64]),
    /// Column `mode`.
    Mode(&'a [Mode]),
    /// Column `seq`.
    Seq(&'a [u64]),
    /// Column `fault`.
    Fault(&'a [u32]),
    /// Column `counts`.
    Counts(&'a [i64]),
    /// A column the format does not know.
    Text(&'a [String]),
}

impl Recording {
    /// Every column there is with its name on this axis: those of the format in the order of [`Column::ALL`], then the
    /// rest.
    pub fn columns(&self) -> Vec<(&str, Cells<'_>)> {
        let known = Column::ALL.into_iter().filter_map(|column| Some((column.name(self.axis), self.column(column)?)));
        let kept = self.extra.iter().filter(|(_, cells)| cells.len() == self.rows());
        let extra = kept.map(|(name, cells)| (name.as_str(), Cells::Text(cells)));
        known.chain(extra).collect()
    }

    /// The cells of one column of the format; none where the recording has no such column.
    pub fn column(&self, column: Column) -> Option<Cells<'_>> {
        fn real(values: &Option<Vec<f64>>) -> Option<Cells<'_>> {
            values.as_deref().map(Cells::Real)
        }
        match column {
            Column::Time => Some(Cells::Real(&self.t_s)),
            Column::Position => Some(Cells::Real(&self.position)),
            Column::EffortCmd => Some(Cells::Real(&self.effort_cmd)),
            Column::Reference => real(&self.reference),
            Column::FieldCmd => real(&self.field_cmd_kv_mm),
            Column::Velocity => real(&self.velocity),
            Column::EffortMeas => real(&self.effort_meas),
            Column::FieldMeas => real(&self.field_meas_kv_mm),
            Column::Temperature => real(&self.temperature_c),
            Column::Mode => self.mode.as_deref().map(Cells::Mode),
            Column::Seq => self.seq.as_deref().map(Cells::Seq),
            Column::Fault => self.fault.as_deref().map(Cells::Fault),
            Column::Counts => self.counts.as_deref().map(Cells::Counts),
        }
    }

    /// Some of the rows, at least one, as ranges in order, with the columns that drive a model and what it is compared with:
    /// the others of a long recording are large. Between two ranges is a gap.
    pub fn driven(&self, ranges: &[Range<usize>]) -> Self {
        fn cut<T: Clone>(values: &[T], ranges: &[Range<usize>]) -> Vec<T> {
            ranges.iter().flat_map(|rows| &values[rows.clone()]).cloned().collect()
        }
        let mut gaps = Vec::new();
        let mut before = 0_usize;
        for rows in ranges {
            gaps.extend(before.checked_sub(1));
            let inside = self.gaps.iter().filter(|gap| (rows.start..rows.end - 1).contains(*gap));
            gaps.extend(inside.map(|gap| gap - rows.start + before));
            before += rows.len();
        }
        Self {
            name: self.name.clone(),
            t_s: cut(&self.t_s, ranges),
            position: cut(&self.position, ranges),
            effort_cmd: cut(&self.effort_cmd, ranges),
            field_cmd_kv_mm: self.field_cmd_kv_mm.as_ref().map(|values| cut(values, ranges)),
            mode: self.mode.as_ref().map(|values| cut(values, ranges)),
            velocity: self.velocity.as_ref().map(|values| cut(values, ranges)),
            gaps,
            ..Self::empty(self.axis)
        }
    }

    /// The mode of `simulate --mode` that commanded, in place of the flashed law; none for a recording of the law itself.
    pub fn mode_beside_the_law(&self) -> Option<&str> {
        let (_, cells) = self.extra.iter().find(|(name, _)| name == BESIDE_THE_LAW)?;
        Some(cells.first().map_or("unknown", String::as_str))
    }

    /// Number of rows, at least one.
    pub fn rows(&self) -> usize {
        self.t_s.len()
    }

    /// One sentence for each thing in the file that is no error but that the user should know: columns that are not of
    /// the format, and rows that are missing.
    pub fn notes(&self) -> Vec<String> {
        let known = Column::ALL.map(|column| column.name(self.axis));
        let mut notes: Vec<_> = self
            .extra
            .iter()
            .filter(|(name, _)| name != BESIDE_THE_LAW)
            .map(|(name, _)| {
                let hint = misspelt(name, known).map_or_else(String::new, |near| {
                    let unit = units::other_unit(name, near);
                    if unit.is_empty() { format!("; is `{near}` meant?") } else { format!("; `{near}` is{unit}") }
                });
                format!("{}: column `{name}` is not one of the format and is not used{hint}", self.name)
            })
            .collect();
        if let Some(mode) = self.mode_beside_the_law() {
            notes.push(format!("{}: the mode `{mode}` commanded, not the flashed law", self.name));
        }
        notes.extend(self.mended.iter().map(|mended| format!("{}: {mended}", self.name)));
        if !self.gaps.is_empty() {
            // Time counts from another zero than in the log where that is mapped; rows are the same in both but for those left out.
            let (row, since_s) = (self.gaps[0] + 1, self.t_s[self.gaps[0]] - self.t_s[0]);
            notes.push(format!(
                "{}: rows are missing in {}, the first after row {row}, {since_s:.3} s after the start",
                self.name,
                places(self.gaps.len())
            ));
        }
        notes
    }

    /// Puts checked columns in their places, mends what the log has beside samples, and looks for gaps.
    pub(super) fn assemble(file: &Path, header: Header, values: Vec<Values>) -> Result<Self, Error> {
        let name = file.file_name().map_or_else(|| file.to_string_lossy(), OsStr::to_string_lossy).into_owned();
        let mut recording = Self { name, ..Self::empty(header.axis) };
        for (column, mut values) in header.columns.into_iter().zip(values) {
            if let (true, Role::Known(known, reading), Values::Real(values)) = (header.mapped, column.role, &mut values)
            {
                // Clocks of logs count from long ago, which costs digits; only differences are of use.
                let zero = if known == Column::Time { values.first().copied().unwrap_or(0.0) } else { 0.0 };
                reading.apply(values, zero);
            }
            recording.place(column, values);
        }
        if let Some(reading) = header.row_time {
            recording.t_s = (0..recording.position.len()).map(|row| row as f64).collect();
            reading.apply(&mut recording.t_s, 0.0);
        }
        if recording.t_s.is_empty() {
            return Err(Error::input(file, None, "", "the file holds a header but no rows"));
        }
        if header.mapped {
            recording
                .mend_stamps()
                .map_err(|message| Error::input(file, None, Column::Time.name(header.axis), message))?;
        }
        recording.mend_stale_rows();
        recording.gaps = gaps::find(&recording.t_s, recording.seq.as_deref());
        Ok(recording)
    }

    /// Without a name, rows or any column that a recording may lack.
    pub fn empty(axis: AxisKind) -> Self {
        Self {
            name: String::new(),
            axis,
            t_s: Vec::new(),
            position: Vec::new(),
            effort_cmd: Vec::new(),
            reference: None,
            field_cmd_kv_mm: None,
            mode: None,
            velocity: None,
            effort_meas: None,
            field_meas_kv_mm: None,
            temperature_c: None,
            seq: None,
            fault: None,
            counts: None,
            gaps: Vec::new(),
            extra: Vec::new(),
            mended: Vec::new(),
        }
    }

    fn place(&mut self, HeaderColumn { name, role, .. }: HeaderColumn, values: Values) {
        match values {
            Values::Skipped => {}
            Values::Text(values) => self.extra.push((name, values)),
            Values::Mode(values) => self.mode = Some(values),
            Values::Seq(values) => self.seq = Some(values),
            Values::Fault(values) => self.fault = Some(values),
            Values::Counts(values) => self.counts = Some(values),
            Values::Real(values) => match role.column() {
                Some(Column::Time) => self.t_s = values,
                Some(Column::Position) => self.position = values,
                Some(Column::EffortCmd) => self.effort_cmd = values,
                Some(Column::Reference) => self.reference = Some(values),
                Some(Column::FieldCmd) => self.field_cmd_kv_mm = Some(values),
                Some(Column::Velocity) => self.velocity = Some(values),
                Some(Column::EffortMeas) => self.effort_meas = Some(values),
                Some(Column::FieldMeas) => self.field_meas_kv_mm = Some(values),
                Some(Column::Temperature) => self.temperature_c = Some(values),
                // The remaining columns are not of real numbers.
                Some(Column::Mode | Column::Seq | Column::Fault | Column::Counts) | None => {}
            },
        }
    }
}

/// So many places, as a text has them.
pub fn places(count: usize) -> String {
    format!("{count} place{}", if count == 1 { "" } else { "s" })
}
