//! Units at the end of names, for hints that are not wrong by a factor: `t_ms` is not `t_s` misspelt.

use std::f64::consts::{PI, TAU};

use crate::nearest::{likeness, quoted};

/// Stems that are called alike are at least this alike.
const ALIKE: f64 = 0.6;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Time,
    Angle,
    Length,
    Torque,
    Force,
    Field,
    AngularSpeed,
    Speed,
    Temperature,
    Current,
    Voltage,
    /// Of an encoder; how many make a revolution (a metre) stands with it.
    Counts,
}

/// A unit as names end in it.
#[derive(Debug, PartialEq)]
struct Unit {
    suffix: &'static str,
    /// As a person writes it.
    written: &'static str,
    quantity: Quantity,
    /// One of it in the unit of the format.
    factor: f64,
}

const fn unit(suffix: &'static str, written: &'static str, quantity: Quantity, factor: f64) -> Unit {
    Unit { suffix, written, quantity, factor }
}

/// Units of logs; those of the format have the factor 1. A suffix that ends in another comes before it.
const UNITS: &[Unit] = &[
    unit("rad_s", "rad/s", Quantity::AngularSpeed, 1.0),
    unit("deg_s", "deg/s", Quantity::AngularSpeed, PI / 180.0),
    unit("rev_s", "rev/s", Quantity::AngularSpeed, TAU),
    unit("rpm", "rpm", Quantity::AngularSpeed, TAU / 60.0),
    unit("mm_s", "mm/s", Quantity::Speed, 1e-3),
    unit("m_s", "m/s", Quantity::Speed, 1.0),
    unit("kv_mm", "kV/mm", Quantity::Field, 1.0),
    unit("v_mm", "V/mm", Quantity::Field, 1e-3),
    unit("mv_m", "MV/m", Quantity::Field, 1.0),
    unit("kv_cm", "kV/cm", Quantity::Field, 0.1),
    unit("ms", "ms", Quantity::Time, 1e-3),
    unit("us", "us", Quantity::Time, 1e-6),
    unit("ns", "ns", Quantity::Time, 1e-9),
    unit("min", "min", Quantity::Time, 60.0),
    unit("s", "s", Quantity::Time, 1.0),
    unit("mrad", "mrad", Quantity::Angle, 1e-3),
    unit("rad", "rad", Quantity::Angle, 1.0),
    unit("deg", "deg", Quantity::Angle, PI / 180.0),
    unit("rev", "rev", Quantity::Angle, TAU),
    // No name ends in capitals: these are as a person writes them, and `mn` is no `MN`.
    unit("MNm", "MN m", Quantity::Torque, 1e6),
    unit("MN", "MN", Quantity::Force, 1e6),
    unit("mnm", "mN m", Quantity::Torque, 1e-3),
    unit("knm", "kN m", Quantity::Torque, 1e3),
    unit("ncm", "N cm", Quantity::Torque, 1e-2),
    unit("nm", "N m", Quantity::Torque, 1.0),
    unit("mm", "mm", Quantity::Length, 1e-3),
    unit("cm", "cm", Quantity::Length, 1e-2),
    unit("um", "um", Quantity::Length, 1e-6),
    unit("inch", "inch", Quantity::Length, 0.0254),
    unit("m", "m", Quantity::Length, 1.0),
    unit("kn", "kN", Quantity::Force, 1e3),
    unit("mn", "mN", Quantity::Force, 1e-3),
    unit("n", "N", Quantity::Force, 1.0),
    unit("c", "degrees Celsius", Quantity::Temperature, 1.0),
    unit("ma", "mA", Quantity::Current, 1e-3),
    unit("a", "A", Quantity::Current, 1.0),
    unit("mv", "mV", Quantity::Voltage, 1e-3),
    unit("v", "V", Quantity::Voltage, 1.0),
];

/// Suffixes of which the case of the first letter tells milli from mega; elsewhere one of the two is no unit of a log.
const CASE_TELLS: &[&str] = &["mn", "mnm", "mv_m"];

/// Other ways to write a unit, in small letters, without blanks and with `_` for `/`, and the suffix of the same unit.
const SPELLINGS: &[(&str, &str)] = &[
    ("sec", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("usec", "us"),
    ("\u{b5}s", "us"),
    ("\u{b5}m", "um"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("\u{b0}", "deg"),
    ("\u{b0}_s", "deg_s"),
    ("turns", "rev"),
    ("turn", "rev"),
    ("rotations", "rev"),
    // Not at the end of a name, where it is an input: `torque_in`.
    ("in", "inch"),
    ("inches", "inch"),
    ("n.m", "nm"),
    ("n-m", "nm"),
    ("rev_min", "rpm"),
    ("amps", "a"),
    ("volts", "v"),
    ("degc", "c"),
];

/// What a unit measures, and one of it in the unit of the format; of [`Quantity::Counts`], how many there are in a revolution
/// or a metre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measure {
    pub(crate) quantity: Quantity,
    pub(crate) factor: f64,
}

/// The unit a person wrote: `deg`, `mN m`, `rad/s`, `counts(8192)`; none where it is not known.
pub(crate) fn measure(text: &str) -> Option<Measure> {
    // A sign of multiplication means nothing, and the Greek letter is the sign of micro as well.
    let is_between = |c: char| c.is_whitespace() || matches!(c, '*' | '\u{b7}' | '\u{22c5}');
    let plain: String = text.chars().filter(|c| !is_between(*c)).collect();
    let plain = plain.replace('\u{3bc}', "\u{b5}").replace('/', "_");
    let lower = plain.to_lowercase();
    if let Some(inside) = lower.strip_prefix("counts(").and_then(|rest| rest.strip_suffix(')')) {
        let number = inside.parse::<f64>().ok().filter(|number| *number > 0.0 && number.is_finite())?;
        return Some(Measure { quantity: Quantity::Counts, factor: number });
    }
    let suffix = SPELLINGS.iter().find(|(other, _)| *other == lower).map_or(lower.as_str(), |(_, suffix)| suffix);
    let is_it = |unit: &&Unit| unit.suffix == plain || (unit.suffix == suffix && is_in_case(unit, &plain));
    let unit = UNITS.iter().find(is_it)?;
    Some(Measure { quantity: unit.quantity, factor: unit.factor })
}

/// Whether a unit that was found whatever the case of `text` is in the case that tells it.
fn is_in_case(unit: &Unit, text: &str) -> bool {
    !CASE_TELLS.contains(&unit.suffix) || unit.written.chars().next() == text.chars().next()
}

/// Every unit of a quantity, for a message.
pub(crate) fn written(quantities: &[Quantity]) -> String {
    let units = UNITS.iter().filter(|unit| quantities.contains(&unit.quantity)).map(|unit| unit.written);
    units.collect::<Vec<_>>().join(", ")
}

/// The unit a name tells, as [`measure`] takes it: at its end (`pos_mm`), or in brackets (`Position [mm]`, `t (s)`).
pub(crate) fn told(name: &str) -> Option<String> {
    let name = name.trim();
    let bracketed = |open: char, close: char| {
        let inside = name.strip_suffix(close)?.rsplit_once(open)?.1.trim();
        measure(inside).map(|_| inside.to_owned())
    };
    let last = || {
        // A letter alone behind a blank or a line is as often a part of the name: `axis_c`.
        ending(name).filter(|unit| unit.quantity != Quantity::Temperature).map(|unit| unit.written.to_owned())
    };
    bracketed('[', ']').or_else(|| bracketed('(', ')')).or_else(last)
}

/// Other stems of the columns that no recording can do without.
const SYNONYMS: &[(&str, &[&str])] = &[
    ("t", &["time", "timestamp", "seconds"]),
    ("position", &["pos", "angle", "theta", "q", "x"]),
    ("torque_cmd", &["torque", "tau", "u", "effort", "current"]),
    ("force_cmd", &["force", "f", "u", "effort", "current"]),
];

/// The stem of a name and its unit, if it ends in one.
fn parts(name: &str) -> (&str, Option<&'static Unit>) {
    let with = |unit: &'static Unit| {
        let stem = name.strip_suffix(unit.suffix)?.strip_suffix('_')?;
        (!stem.is_empty()).then_some((stem, unit))
    };
    UNITS.iter().find_map(with).map_or((name, None), |(stem, unit)| (stem, Some(unit)))
}

/// What of a name stands before brackets; all of it where there are none.
pub(crate) fn before_brackets(name: &str) -> &str {
    name.split(['[', '(']).next().unwrap_or(name)
}

/// A name without the unit in brackets or at its end.
pub(crate) fn stem(name: &str) -> &str {
    let plain = before_brackets(name).trim();
    let unit = ending(plain).filter(|_| plain.len() == name.trim().len());
    unit.and_then(|unit| plain.get(..plain.len().checked_sub(unit.suffix.len() + 1)?)).unwrap_or(plain)
}

/// The unit at the end of a name in any case; none where the case leaves milli or mega open.
fn ending(name: &str) -> Option<&'static Unit> {
    let unit = parts(&name.to_lowercase()).1?;
    let end = name.get(name.len().checked_sub(unit.suffix.len())?..)?;
    let is_mega = CASE_TELLS.contains(&unit.suffix) && unit.written.starts_with('m') && end.starts_with('M');
    if !is_mega {
        return Some(unit);
    }
    let in_capitals = !name.chars().any(char::is_lowercase);
    UNITS.iter().find(|unit| unit.suffix == end && !in_capitals)
}

/// What the unit at the end of a name measures; none without one.
pub(crate) fn quantity(name: &str) -> Option<Quantity> {
    ending(name).map(|unit| unit.quantity)
}

/// The name that probably is meant to be `wanted`, by its stem, whatever its unit.
pub(crate) fn called_alike<'a>(wanted: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let (stem, _) = parts(wanted);
    let synonyms = SYNONYMS.iter().find(|(of, _)| *of == stem).map_or(&[][..], |(_, others)| others);
    let scored = names.into_iter().map(|name| {
        let lower = name.to_lowercase();
        let (own, _) = parts(&lower);
        let score = if own == stem {
            2.0
        } else if synonyms.contains(&own) {
            1.5
        } else {
            likeness(own, stem).max(likeness(&lower, wanted))
        };
        (score, name)
    });
    let best = scored.max_by(|one, other| one.0.total_cmp(&other.0));
    best.filter(|(score, _)| *score >= ALIKE).map(|(_, name)| name)
}

/// What is to be done with `found` to make it `wanted`: a question where it is in the same unit, else how to convert it.
pub(crate) fn hint(found: &str, wanted: &str) -> String {
    let (quoted, is, (_, must)) = (quoted(found), ending(found), parts(wanted));
    match (is, must) {
        (_, None) => format!("is {quoted} meant to be it?"),
        (None, Some(must)) => format!("is {quoted} meant to be it? It must be in {}", must.written),
        (Some(is), Some(must)) if is == must => format!("is {quoted} meant to be it?"),
        (Some(is), Some(must)) if is.quantity == must.quantity => {
            let (factor, is, must) = (factor(is, must), is.written, must.written);
            format!("{quoted} is in {is}: multiply its values by {factor} and call it `{wanted}`, in {must}")
        }
        (Some(is), Some(must)) => format!("{quoted} is in {}, but {} is needed", is.written, must.written),
    }
}

/// The unit of the key `wanted` where `found` has another of the same quantity, and how to convert; else nothing.
pub(crate) fn other_unit(found: &str, wanted: &str) -> String {
    match (ending(found), parts(wanted).1) {
        (Some(is), Some(must)) if is != must && is.quantity == must.quantity => {
            format!(", in {}: multiply the value by {}", must.written, factor(is, must))
        }
        _ => String::new(),
    }
}

/// What one `is` is in `must`, in at most six digits.
fn factor(is: &Unit, must: &Unit) -> String {
    let factor = is.factor / must.factor;
    if factor < 1e-4 {
        return format!("{factor:e}");
    }
    format!("{factor:.6}").trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_stems_and_units() {
        for (name, stem, unit) in [
            ("t_s", "t", Some("s")),
            ("t_ms", "t", Some("ms")),
            ("velocity_rad_s", "velocity", Some("rad/s")),
            ("velocity_mm_s", "velocity", Some("mm/s")),
            ("field_cmd_kv_mm", "field_cmd", Some("kV/mm")),
            ("torque_cmd_nm", "torque_cmd", Some("N m")),
            ("force_cmd_n", "force_cmd", Some("N")),
            ("mode", "mode", None),
            ("seconds", "seconds", None),
        ] {
            let (found, unit_found) = parts(name);
            assert_eq!((found, unit_found.map(|unit| unit.written)), (stem, unit), "{name}");
        }
    }

    #[test]
    fn milli_is_not_mega_and_other_signs_are_read() {
        for (text, quantity, factor) in [
            ("mN", Quantity::Force, 1e-3),
            ("MN", Quantity::Force, 1e6),
            ("mN m", Quantity::Torque, 1e-3),
            ("mNm", Quantity::Torque, 1e-3),
            ("MN m", Quantity::Torque, 1e6),
            ("MNm", Quantity::Torque, 1e6),
            ("MV/m", Quantity::Field, 1.0),
            ("Nm", Quantity::Torque, 1.0),
            ("NM", Quantity::Torque, 1.0),
            ("N\u{b7}m", Quantity::Torque, 1.0),
            ("N\u{22c5}m", Quantity::Torque, 1.0),
            ("mN\u{b7}m", Quantity::Torque, 1e-3),
            ("kN*m", Quantity::Torque, 1e3),
            ("KN", Quantity::Force, 1e3),
            ("\u{b5}s", Quantity::Time, 1e-6),
            ("\u{3bc}s", Quantity::Time, 1e-6),
            ("\u{3bc}m", Quantity::Length, 1e-6),
            ("MM", Quantity::Length, 1e-3),
            ("MS", Quantity::Time, 1e-3),
            ("inch", Quantity::Length, 0.0254),
            ("in", Quantity::Length, 0.0254),
            ("m/s", Quantity::Speed, 1.0),
        ] {
            assert_eq!(measure(text), Some(Measure { quantity, factor }), "{text}");
        }
        for text in ["Mn", "MNM", "Mnm", "mV/m", "Counts(0)", "\u{b7}"] {
            assert_eq!(measure(text), None, "{text}");
        }
        for (name, unit) in [
            ("force_mn", Some("mN")),
            ("Force_mN", Some("mN")),
            ("Force_MN", Some("MN")),
            ("FORCE_MN", None),
            ("TIME_MS", Some("ms")),
            ("field_mv_m", Some("MV/m")),
            ("Force [MN]", Some("MN")),
            ("pos (in)", Some("in")),
            ("torque_in", None),
        ] {
            assert_eq!(told(name).as_deref(), unit, "{name}");
        }
        assert_eq!(
            hint("Force_MN", "force_cmd_n"),
            "`Force_MN` is in MN: multiply its values by 1000000 and call it `force_cmd_n`, in N"
        );
    }

    #[test]
    fn a_hint_names_the_unit_and_the_factor() {
        for (found, wanted, message) in [
            ("t_ms", "t_s", "`t_ms` is in ms: multiply its values by 0.001 and call it `t_s`, in s"),
            ("t_us", "t_s", "`t_us` is in us: multiply its values by 1e-6 and call it `t_s`, in s"),
            (
                "position_mm",
                "position_m",
                "`position_mm` is in mm: multiply its values by 0.001 and call it `position_m`, in m",
            ),
            (
                "angle_deg",
                "position_rad",
                "`angle_deg` is in deg: multiply its values by 0.017453 and call it `position_rad`, in rad",
            ),
            ("position_mm", "position_rad", "`position_mm` is in mm, but rad is needed"),
            ("time", "t_s", "is `time` meant to be it? It must be in s"),
            ("positon_rad", "position_rad", "is `positon_rad` meant to be it?"),
        ] {
            assert_eq!(hint(found, wanted), message);
            assert_eq!(called_alike(wanted, [found, "humidity"]), Some(found));
        }
        assert_eq!(called_alike("t_s", ["humidity", "mode"]), None);
    }
}
