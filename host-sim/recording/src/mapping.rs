//! How the columns of somebody else's log become those of a recording: section `[columns]` of a machine file.
//!
//! ```toml
//! [columns]
//! time = { name = "ts", unit = "us" }
//! position = { name = "enc", unit = "counts(8192)" }
//! torque = { name = "iq", unit = "A", scale = -0.12 } # N m per A
//! ```

use super::columns::ROW;
use super::nearest::quoted;
use super::toml_section::Section;
use super::units::{self, Quantity};
use super::vocabulary::Allowed;
use super::{AxisKind, Column};
use crate::Error;

/// One column of the log and what it is.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedColumn {
    /// Which column of a recording it is.
    pub column: Column,
    /// Its name in the log.
    pub name: String,
    /// Its unit in the log: `deg`, `mN m`, `counts(8192)`; empty for a column without one, such as `mode`.
    pub unit: String,
    /// Factor on top of the unit: a sign, N m per A, N per V.
    pub scale: f64,
    /// What a position or reference jumps back by at the end of its range, in the unit of the log; none where it counts on.
    pub wrap: Option<f64>,
    /// What one of the log is in the unit of the format, scale included.
    factor: f64,
}

/// How the numbers of a column become those of the format.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    /// In the unit of the format over in that of the log.
    pub(crate) factor: f64,
    /// Width of the range they are kept within, in the unit of the format.
    pub(crate) wrap: Option<f64>,
}

impl Reading {
    /// As they stand.
    pub(crate) const PLAIN: Self = Self { factor: 1.0, wrap: None };

    /// Turns numbers of the log, counted from `zero`, into those of the format.
    pub(crate) fn apply(self, values: &mut [f64], zero: f64) {
        values.iter_mut().for_each(|value| *value = (*value - zero) * self.factor);
        let Some(wrap) = self.wrap else { return };
        let mut turns = 0.0;
        let mut before = values.first().copied().unwrap_or(0.0);
        for value in values {
            // The nearer way round is the one it went.
            turns -= ((*value - before) / wrap).round();
            before = *value;
            *value += turns * wrap;
        }
    }
}

/// The columns of a log; at most one for each of a recording. Empty for logs that have the format's own.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mapping(Vec<MappedColumn>);

impl Column {
    /// The key in `[columns]` and in `--map`.
    pub fn key(self, axis: AxisKind) -> &'static str {
        let (rotary, linear) = match self {
            Self::Time => ("time", "time"),
            Self::Reference => ("reference", "reference"),
            Self::Position => ("position", "position"),
            Self::EffortCmd => ("torque", "force"),
            Self::FieldCmd => ("field", "field"),
            Self::Mode => ("mode", "mode"),
            Self::Velocity => ("velocity", "velocity"),
            Self::EffortMeas => ("torque_measured", "force_measured"),
            Self::FieldMeas => ("field_measured", "field_measured"),
            Self::Temperature => ("temperature", "temperature"),
            Self::Seq => ("seq", "seq"),
            Self::Fault => ("fault", "fault"),
            Self::Counts => ("counts", "counts"),
        };
        match axis {
            AxisKind::Rotary => rotary,
            AxisKind::Linear => linear,
        }
    }

    /// What its numbers may measure in a log, the format's own first; empty for whole numbers and words.
    pub(crate) fn quantities(self, axis: AxisKind) -> &'static [Quantity] {
        use Quantity::{
            Angle, AngularSpeed, Counts, Current, Field, Force, Length, Speed, Temperature, Time, Torque, Voltage,
        };
        match (self, axis) {
            (Self::Time, _) => &[Time],
            (Self::Position | Self::Reference, AxisKind::Rotary) => &[Angle, Counts],
            (Self::Position | Self::Reference, AxisKind::Linear) => &[Length, Counts],
            (Self::EffortCmd | Self::EffortMeas, AxisKind::Rotary) => &[Torque, Current, Voltage],
            (Self::EffortCmd | Self::EffortMeas, AxisKind::Linear) => &[Force, Current, Voltage],
            (Self::Velocity, AxisKind::Rotary) => &[AngularSpeed],
            (Self::Velocity, AxisKind::Linear) => &[Speed],
            (Self::FieldCmd | Self::FieldMeas, _) => &[Field],
            (Self::Temperature, _) => &[Temperature],
            (Self::Mode | Self::Seq | Self::Fault | Self::Counts, _) => &[],
        }
    }

    /// The unit of the format as a person writes it; empty for whole numbers and words.
    pub fn unit(self, axis: AxisKind) -> &'static str {
        match (self.quantities(axis).first(), axis) {
            (Some(Quantity::Time), _) => "s",
            (Some(Quantity::Angle), _) => "rad",
            (Some(Quantity::Length), _) => "m",
            (Some(Quantity::Torque), _) => "N m",
            (Some(Quantity::Force), _) => "N",
            (Some(Quantity::AngularSpeed), _) => "rad/s",
            (Some(Quantity::Speed), _) => "m/s",
            (Some(Quantity::Field), _) => "kV/mm",
            (Some(Quantity::Temperature), _) => "C",
            _ => "",
        }
    }
}

/// What a unit measures and how much it is, where it is one of the column on this kind of axis.
fn measure_of(column: Column, axis: AxisKind, unit: &str) -> Result<units::Measure, String> {
    let quantities = column.quantities(axis);
    let counts = if quantities.contains(&Quantity::Counts) {
        format!(", counts(number in a {})", if axis == AxisKind::Rotary { "revolution" } else { "metre" })
    } else {
        String::new()
    };
    let allowed = || format!("allowed are {}{counts}", units::written(quantities));
    let Some(measure) = units::measure(unit) else {
        // Of a unit that is none nobody knows which kind of axis was meant.
        let other = if axis == AxisKind::Rotary { AxisKind::Linear } else { AxisKind::Rotary };
        let others = column.quantities(other);
        let elsewhere = if others == quantities {
            String::new()
        } else {
            format!("; on a {} axis {}", other.name(), units::written(others))
        };
        return Err(format!("{} is not a unit; {}{elsewhere}", quoted(unit), allowed()));
    };
    if quantities.contains(&measure.quantity) {
        return Ok(measure);
    }
    let (key, kind) = (column.key(axis), axis.name());
    Err(format!("{} is not a unit of `{key}` on a {kind} axis; {}", quoted(unit), allowed()))
}

impl MappedColumn {
    /// The column `name` of a log, in `unit` (empty: the format's own) and times `scale`; without a scale, 1.
    ///
    /// # Errors
    /// What is wrong, as a sentence: a unit that is not known or not of such a column, a current or voltage without a scale.
    pub fn new(column: Column, axis: AxisKind, name: &str, unit: &str, scale: Option<f64>) -> Result<Self, String> {
        let quantities = column.quantities(axis);
        let own = column.unit(axis);
        let unit = if unit.trim().is_empty() { own } else { unit.trim() };
        if quantities.is_empty() {
            return if unit.is_empty() && scale.is_none() {
                Ok(Self { column, name: name.to_owned(), unit: String::new(), scale: 1.0, wrap: None, factor: 1.0 })
            } else {
                Err(format!("`{}` has neither unit nor scale", column.key(axis)))
            };
        }
        let measure = measure_of(column, axis, unit)?;
        let needs_scale = matches!(measure.quantity, Quantity::Current | Quantity::Voltage);
        if needs_scale && scale.is_none() {
            return Err(format!("{} needs a scale: how many {own} one {unit} makes", quoted(unit)));
        }
        let scale = scale.unwrap_or(1.0);
        if scale == 0.0 || !scale.is_finite() {
            return Err(format!("scale {scale} is not allowed; must be a finite number other than 0"));
        }
        let factor = match (measure.quantity, axis) {
            (Quantity::Counts, AxisKind::Rotary) => std::f64::consts::TAU / measure.factor,
            (Quantity::Counts, AxisKind::Linear) => 1.0 / measure.factor,
            // The scale says what one A or V of the log makes, mA and mV included.
            (Quantity::Current | Quantity::Voltage, _) => 1.0,
            _ => measure.factor,
        };
        Ok(Self { column, name: name.to_owned(), unit: unit.to_owned(), scale, wrap: None, factor: factor * scale })
    }

    /// What one of the log is in the unit of the format.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    /// The same column, of which the log keeps the values within a range of this width, in its own unit.
    ///
    /// # Errors
    /// A column that is no position or reference, a width that is not above 0, as a sentence.
    pub fn wrapping(self, wrap: f64) -> Result<Self, String> {
        if !matches!(self.column, Column::Position | Column::Reference) {
            return Err("only `position` and `reference` wrap".to_owned());
        }
        if !(wrap > 0.0 && wrap.is_finite()) {
            return Err(format!(
                "wrap {wrap} is not allowed; must be above 0: the width of the range, in the unit of the log"
            ));
        }
        Ok(Self { wrap: Some(wrap), ..self })
    }

    /// Whether it is the time of a log without one, by the number of the row; a column of this name comes before it.
    pub(crate) fn is_row(&self) -> bool {
        self.column == Column::Time && self.name == ROW
    }

    /// What the numbers of the log are turned by into those of the format.
    pub(crate) fn reading(&self) -> Reading {
        Reading { factor: self.factor, wrap: self.wrap.map(|wrap| wrap * self.factor.abs()) }
    }

    /// The same column, its values the other way round.
    pub fn reversed(self) -> Self {
        Self { scale: -self.scale, factor: -self.factor, ..self }
    }

    /// As `[columns]` holds it.
    pub fn to_toml(&self, axis: AxisKind) -> String {
        let name = toml::Value::String(self.name.clone());
        let unit = if self.unit.is_empty() { String::new() } else { format!(", unit = \"{}\"", self.unit) };
        let needs_scale = units::measure(&self.unit)
            .is_some_and(|measure| matches!(measure.quantity, Quantity::Current | Quantity::Voltage));
        let scale =
            if self.scale == 1.0 && !needs_scale { String::new() } else { format!(", scale = {:?}", self.scale) };
        let wrap = self.wrap.map(|wrap| format!(", wrap = {wrap:?}")).unwrap_or_default();
        format!("{} = {{ name = {name}{unit}{scale}{wrap} }}", self.column.key(axis))
    }
}

impl Mapping {
    /// The columns of a log.
    ///
    /// # Errors
    /// A column of a recording that is given twice, as a sentence.
    pub fn new(columns: Vec<MappedColumn>, axis: AxisKind) -> Result<Self, String> {
        for (index, mapped) in columns.iter().enumerate() {
            if columns[..index].iter().any(|earlier| earlier.column == mapped.column) {
                return Err(format!("`{}` is given twice", mapped.column.key(axis)));
            }
        }
        Ok(Self(columns))
    }

    /// The columns, in the order they were given.
    pub fn columns(&self) -> &[MappedColumn] {
        &self.0
    }

    /// The unit of the effort where it is a current or a voltage and nobody has said what one makes: its scale is 1 or -1.
    pub fn unscaled_effort(&self) -> Option<&str> {
        let effort = self.0.iter().find(|mapped| mapped.column == Column::EffortCmd)?;
        let quantity = units::measure(&effort.unit)?.quantity;
        let electric = matches!(quantity, Quantity::Current | Quantity::Voltage);
        (electric && effort.scale.abs() == 1.0).then_some(effort.unit.as_str())
    }

    /// Whether logs have the format's own columns.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Section `[columns]`.
    pub(crate) fn read(section: &Section<'_, '_>, axis: AxisKind) -> Result<Self, Error> {
        let keys = Column::ALL.map(|column| column.key(axis));
        section.only(&keys)?;
        let mut columns = Vec::new();
        for column in Column::ALL {
            let key = column.key(axis);
            let Some(entry) = section.section(key)? else {
                if Column::REQUIRED.contains(&column) {
                    let message = format!("is missing; [columns] must have {}", required(axis));
                    return Err(section.error(section.span(), key, message));
                }
                continue;
            };
            entry.only(&["name", "unit", "scale", "wrap"])?;
            let (name, _) = entry.required_text("name", "the name of a column of the log, in quotes")?;
            let unit = entry.text("unit", "a unit in quotes")?.map_or("", |(unit, _)| unit);
            let scale = entry.number("scale", Allowed::Finite)?;
            let mapped = MappedColumn::new(column, axis, name, unit, scale);
            let mapped = mapped.map_err(|message| entry.error(entry.span(), "unit", message))?;
            let wrap = entry.number("wrap", Allowed::AboveZero)?;
            columns.push(match wrap.map(|wrap| mapped.clone().wrapping(wrap)) {
                None => mapped,
                Some(wrapping) => wrapping.map_err(|message| entry.error(entry.span(), "wrap", message))?,
            });
        }
        Ok(Self(columns))
    }
}

fn required(axis: AxisKind) -> String {
    Column::REQUIRED.map(|column| format!("`{}`", column.key(axis))).join(", ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn factor(column: Column, axis: AxisKind, unit: &str, scale: Option<f64>) -> Result<f64, String> {
        MappedColumn::new(column, axis, "x", unit, scale).map(|mapped| mapped.factor())
    }

    #[test]
    fn units_become_those_of_the_format() {
        use AxisKind::{Linear, Rotary};
        for (column, axis, unit, scale, expected) in [
            (Column::Time, Rotary, "us", None, 1e-6),
            (Column::Time, Rotary, "ns", None, 1e-9),
            (Column::Time, Linear, "ms", None, 1e-3),
            (Column::Position, Rotary, "rev", None, std::f64::consts::TAU),
            (Column::Position, Linear, "mm", None, 1e-3),
            (Column::Position, Rotary, "deg", None, 1f64.to_radians()),
            (Column::Position, Rotary, "mrad", None, 1e-3),
            (Column::Position, Rotary, "counts(8192)", None, std::f64::consts::TAU / 8192.0),
            (Column::Position, Linear, "counts(20000000)", None, 5e-8),
            (Column::Position, Linear, "um", None, 1e-6),
            (Column::EffortCmd, Rotary, "A", Some(0.12), 0.12),
            (Column::EffortCmd, Rotary, "mN m", None, 1e-3),
            (Column::EffortCmd, Rotary, "N m", Some(-1.0), -1.0),
            (Column::EffortCmd, Linear, "V", Some(35.15), 35.15),
            (Column::Velocity, Rotary, "rad/s", None, 1.0),
        ] {
            let found = factor(column, axis, unit, scale).unwrap();
            assert!((found / expected - 1.0).abs() < 1e-12, "{column:?} in {unit}: {found}");
        }
    }

    #[test]
    fn a_range_that_is_left_is_entered_from_the_other_end() {
        let column = MappedColumn::new(Column::Position, AxisKind::Rotary, "x", "deg", None).unwrap();
        let wrapping = column.clone().wrapping(360.0).unwrap();
        assert_eq!(wrapping.to_toml(AxisKind::Rotary), r#"position = { name = "x", unit = "deg", wrap = 360.0 }"#);
        let mut values = [170.0, 179.0, -175.0, 179.5, -170.0, -100.0, 10.0, 100.0, 190.0 - 360.0];
        wrapping.reading().apply(&mut values, 0.0);
        let expected = [170.0, 179.0, 185.0, 179.5, 190.0, 260.0, 370.0, 460.0, 550.0];
        for (value, expected) in values.iter().zip(expected) {
            assert!((value.to_degrees() - expected).abs() < 1e-9, "{} instead of {expected}", value.to_degrees());
        }
        assert!(column.wrapping(0.0).unwrap_err().contains("must be above 0"));
        let torque = MappedColumn::new(Column::EffortCmd, AxisKind::Rotary, "x", "", None).unwrap();
        assert!(torque.wrapping(1.0).unwrap_err().contains("only `position`"));
    }

    #[test]
    fn what_cannot_be_is_told() {
        let error = factor(Column::EffortCmd, AxisKind::Rotary, "A", None).unwrap_err();
        assert_eq!(error, "`A` needs a scale: how many N m one A makes");
        let error = factor(Column::Position, AxisKind::Rotary, "mm", None).unwrap_err();
        assert_eq!(
            error,
            "`mm` is not a unit of `position` on a rotary axis; allowed are mrad, rad, deg, rev, counts(number in a revolution)"
        );
        assert_eq!(
            factor(Column::Position, AxisKind::Rotary, "parsec", None).unwrap_err(),
            "`parsec` is not a unit; allowed are mrad, rad, deg, rev, counts(number in a revolution); on a linear axis mm, cm, um, \
             inch, m"
        );
        let error = factor(Column::EffortCmd, AxisKind::Linear, "Mn", Some(1.0)).unwrap_err();
        assert_eq!(
            error,
            "`Mn` is not a unit; allowed are MN, kN, mN, N, mA, A, mV, V; on a rotary axis MN m, mN m, kN m, N cm, N m, mA, A, \
             mV, V"
        );
        assert_eq!(factor(Column::EffortCmd, AxisKind::Linear, "MN", None), Ok(1e6));
        assert_eq!(factor(Column::Position, AxisKind::Linear, "inch", None), Ok(0.0254));
        assert!(factor(Column::Position, AxisKind::Rotary, "rad", Some(0.0)).unwrap_err().contains("other than 0"));
        assert!(factor(Column::Mode, AxisKind::Rotary, "rad", None).unwrap_err().contains("neither unit nor scale"));
    }
}
