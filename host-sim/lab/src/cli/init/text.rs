//! The machine file of `init`, with a comment on every line, and what it prints.

use std::fmt::Write as _;
use std::path::Path;

use super::{Findings, name};
use crate::cli::effort_units::EffortUnits;
use crate::cli::velocity_check::wrong_velocity;
use crate::first_model::{FirstModel, Load, Value};
use crate::precheck::windows::median_period_s;
use crate::precheck::{Purpose, Severity, check, wrong_rate};
use crate::read::{AxisKind, Machine, vocabulary};
use crate::report::Units;

/// In four digits, as many as a first guess has.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded:?}")
}

/// Half the width of an interval: two digits, as everywhere.
fn width(within: f64) -> String {
    let rounded: f64 = format!("{within:.1e}").parse().unwrap_or(within);
    format!("{rounded:?}")
}

/// One setting of the machine file: key, value, comment.
struct Line {
    key: &'static str,
    value: String,
    comment: String,
}

/// The text of the machine file.
pub(super) fn machine_file(findings: &Findings<'_>) -> String {
    let logs: Vec<String> =
        findings.logs.iter().map(|log| log.display().to_string().replace(['\n', '\r'], " ")).collect();
    let mut text = format!("# A first model, guessed from {}.\n", logs.join(", "));
    text += "# Correct what you know better: lines with UNSURE first.\n";
    let name = toml::Value::String(name(findings.logs));
    let _ = write!(text, "schema = 1\nname = {name}\n\n[axis]\nkind = \"{}\"\n", findings.axis.kind.name());
    for Line { key, value, comment } in axis(findings) {
        let _ = writeln!(text, "{key} = {value} # {comment}");
    }
    text += "\n[plant]\n";
    for Line { key, value, comment } in plant(findings) {
        let _ = writeln!(text, "{key} = {value} # {comment}");
    }
    if !findings.mapping.is_empty() {
        text += "\n# What the columns of the logs are: name, unit, and a factor on top of the unit.\n[columns]\n";
        for guess in &findings.guesses {
            let unsure = if guess.unsure { "UNSURE: " } else { "" };
            let because = guess.because.replace(['\n', '\r'], " ");
            let _ = writeln!(text, "{} # {unsure}{because}", guess.mapped.to_toml(findings.axis.kind));
        }
    }
    if let Some((model, load)) = findings.model.as_ref().and_then(|model| Some((model, model.load?))) {
        effect(&mut text, findings, model, load);
    }
    text
}

/// What holds the axis as an effect of a machine file.
fn effect(text: &mut String, findings: &Findings<'_>, model: &FirstModel, load: Load) {
    let units = effort_units(findings);
    let (holds, first, unit) = match load {
        Load::Gravity(amplitude, _) => {
            ("Weight on an arm: amplitude sin(position + phase) is what holds it.", amplitude, units.effort)
        }
        Load::Spring(stiffness) => (
            "A spring, or what pulls back like one: stiffness times position is what holds it.",
            stiffness,
            units.stiffness,
        ),
    };
    let (id, values) = load.effect();
    let _ = write!(text, "\n# {holds}\n[[effects]]\nid = \"{id}\"\n");
    let kinds = vocabulary::effect(id).map_or(&[][..], |kind| kind.parameters);
    let mut comment = format!(" # {}", interval(model, first, &unit));
    for (kind, value) in kinds.iter().zip(values) {
        let _ = writeln!(text, "{} = {}{comment}", kind.id(findings.axis.kind), digits(value));
        comment.clear();
    }
}

fn axis(findings: &Findings<'_>) -> [Line; 2] {
    let steps: Vec<f64> = findings
        .recordings
        .iter()
        .flat_map(|recording| recording.t_s.windows(2).map(|pair| pair[1] - pair[0]))
        .collect();
    let period_s = findings.axis.sample_period_s;
    let mut away: Vec<f64> = steps.iter().map(|step| (step - period_s).abs()).collect();
    away.sort_by(f64::total_cmp);
    let jitter = away.get(away.len() * 9 / 10).map_or(0.0, |away| 100.0 * away / period_s);
    let unit = Units::of(findings.axis.kind).position;
    let resolution = findings.axis.resolution;
    let told = if resolution > 0.0 { "step of the position" } else { "no steps are seen; continuous" };
    [
        Line {
            key: "sample_period_s",
            value: digits(period_s),
            comment: format!("s; median of {} steps, nine in ten within {jitter:.1} %", steps.len()),
        },
        Line { key: "resolution", value: digits(resolution), comment: format!("{unit}; {told}") },
    ]
}

fn interval(model: &FirstModel, value: Value, unit: &str) -> String {
    let if_right = if model.is_trusted() { "" } else { " if the rest were right" };
    let unsure = if value.is_known() && model.is_trusted() { "" } else { "UNSURE: " };
    format!("{unsure}{unit}, +- {} (95 %){if_right}", width(value.within))
}

fn effort_units(findings: &Findings<'_>) -> EffortUnits {
    EffortUnits::of(findings.axis.kind, &findings.mapping)
}

fn plant(findings: &Findings<'_>) -> Vec<Line> {
    let EffortUnits { inertia, effort, viscous, .. } = effort_units(findings);
    let Some(model) = &findings.model else {
        let comment = format!("UNSURE: {inertia}; nothing in the logs tells it: put in what you know");
        return vec![Line { key: "inertia", value: "1.0".to_owned(), comment }];
    };
    let line = |key, value: Value, unit: &str| {
        if value.kept {
            return Line { key, value: digits(value.value), comment: interval(model, value, unit) };
        }
        // Friction that drives is none.
        let negative = value.value + value.within <= 0.0 && key != "torque_offset";
        let fitted = format!("fitted {} +- {}", digits(value.value), width(value.within));
        let comment = match value.within.is_finite() {
            _ if negative => format!("{unit}; {fitted}, which none is"),
            _ if value.is_known() => format!("UNSURE: {unit}; {fitted}, which is more than ever acts: left out"),
            true => format!("UNSURE: {unit}; {fitted}, so the logs do not tell it: left out"),
            false => format!("UNSURE: {unit}; the logs do not tell it: left out"),
        };
        Line { key, value: digits(0.0), comment }
    };
    let mut lines = vec![
        inertia_line(model, &inertia),
        line("coulomb", model.coulomb, &effort),
        line("viscous", model.viscous, &viscous),
        line("torque_offset", model.offset, &effort),
    ];
    if model.one_way {
        let together =
            "the motion is in one direction only: friction and offset cannot be told apart, and are here as an offset";
        lines[1].comment = format!("UNSURE: {effort}; {together}");
        lines[3].comment = format!("UNSURE: {effort}; {together}");
    }
    lines
}

fn inertia_line(model: &FirstModel, unit: &str) -> Line {
    let value = model.inertia;
    if value.value > 0.0 {
        return Line { key: "inertia", value: digits(value.value), comment: interval(model, value, unit) };
    }
    // An inertia must be above 0; the largest that fits is one.
    let most = (value.value + value.within).abs().max(value.within * 0.5).max(f64::MIN_POSITIVE);
    let most = if most.is_finite() { most } else { 1.0 };
    let comment = format!("UNSURE: {unit}; the motion does not tell it, at most about this");
    Line { key: "inertia", value: digits(most), comment }
}

/// What is printed: every guess with why and how sure, and what to do next.
pub(super) fn summary(findings: &Findings<'_>, machine: &Machine, file: &Path) -> String {
    let mut text = String::from("columns\n");
    let kind = findings.axis.kind;
    for guess in &findings.guesses {
        let unsure = if guess.unsure { "UNSURE  " } else { "        " };
        let (key, name, unit) = (guess.mapped.column.key(kind), &guess.mapped.name, &guess.mapped.unit);
        let scale = if guess.mapped.scale == 1.0 { String::new() } else { format!(" x {}", guess.mapped.scale) };
        let _ = writeln!(text, "{unsure}{key:16} `{name}` in {unit}{scale}; {}", guess.because);
    }
    let _ = writeln!(text, "axis\n        {:16} {}", "kind", kind.name());
    let mut lines = |title: &str, lines: Vec<Line>| {
        text += title;
        for Line { key, value, comment } in lines {
            let (unsure, comment) = comment
                .strip_prefix("UNSURE: ")
                .map_or(("        ", comment.as_str()), |comment| ("UNSURE  ", comment));
            let _ = writeln!(text, "{unsure}{key:16} {value} {comment}");
        }
    };
    lines("", axis(findings).into());
    lines("first model, by robust least squares\n", plant(findings));
    let units = effort_units(findings);
    text += &how_good(findings.model.as_ref(), kind, &units);
    if !units.scale_is_known {
        let EffortUnits { effort, .. } = &units;
        let own = Units::of(kind).effort;
        let _ = writeln!(text, "note: how many {own} one {effort} makes is not known: all values are in {effort}");
    }
    if let (count @ 1.., Some(first)) = (findings.rows_above, findings.recordings.first()) {
        let _ = writeln!(text, "note: {}: {count} rows above the header are left out", first.name);
    }
    for recording in &findings.recordings {
        text.extend(recording.notes().iter().map(|note| format!("note: {note}\n")));
        text.extend(wrong_velocity(recording).map(|wrong| format!("note: {}: {wrong}\n", recording.name)));
    }
    text + &format!("wrote {}\n{}\n", file.display(), next(findings, machine, file))
}

/// What to do with the file; where the logs are of no use to a diagnosis, with them.
fn next(findings: &Findings<'_>, machine: &Machine, file: &Path) -> String {
    let slow = findings.recordings.iter().find_map(|recording| {
        let period_s = median_period_s(&recording.t_s);
        Some(format!("{}: {:.1} Hz is {}", recording.name, 1.0 / period_s, wrong_rate(period_s)?))
    });
    let refused = || {
        let found = check(machine, &findings.recordings, &[], Purpose::Diagnose);
        let error = found.into_iter().find(|finding| finding.severity == Severity::Error)?;
        Some(format!("{error}, before servo-lab diagnose can take it"))
    };
    let diagnosis = || {
        let logs: Vec<String> = findings.logs.iter().map(|log| log.display().to_string()).collect();
        format!("look at it, then servo-lab diagnose --machine {} {}", file.display(), logs.join(" "))
    };
    format!("next: {}", slow.or_else(refused).unwrap_or_else(diagnosis))
}

/// Gravity or a spring, and how much of the effort the model explains.
fn how_good(model: Option<&FirstModel>, kind: AxisKind, units: &EffortUnits) -> String {
    let Some(model) = model else {
        return "UNSURE  nothing moves enough for a first model, or no effort acts\n".to_owned();
    };
    let mut text = String::new();
    let line = |name, value: Value, unit| {
        format!("        {name:16} {} {}", digits(value.value), interval(model, value, unit))
    };
    let _ = match model.load {
        Some(Load::Gravity(amplitude, phase_rad)) => {
            writeln!(text, "{}, phase {} rad", line("gravity", amplitude, &units.effort), digits(phase_rad))
        }
        Some(Load::Spring(stiffness)) => writeln!(text, "{}", line("spring", stiffness, &units.stiffness)),
        None => Ok(()),
    };
    let (percent, effort) = (100.0 * model.explained, Units::of(kind).effort_name);
    let note = if !model.is_trusted() {
        ": too little to trust it; is the torque column the right one, is its unit, does the axis accelerate?"
    } else {
        ""
    };
    let _ = writeln!(text, "        it explains {percent:.1} % of the variance of the {effort}{note}");
    if model.reversed {
        text += "UNSURE  the effort pushes against the acceleration: turn its sign with *-1 in --map\n";
    }
    text
}
