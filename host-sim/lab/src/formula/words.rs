//! A formula as one line with units.

use super::terms::{Carrier, Form, Term};
use crate::read::AxisKind;
use crate::report::{FormulaTerm, Interval, Units, html::number};

/// The whole formula, and what its letters mean.
pub(super) fn sentence(terms: &[FormulaTerm], of: &[Term], axis: AxisKind) -> String {
    let mut text = format!("{} = ", Units::of(axis).effort_name);
    for (index, (term, of)) in terms.iter().zip(of).enumerate() {
        let Some(first) = term.parameters.first() else { continue };
        let sign = match (index, first.value < 0.0) {
            (0, false) => "",
            (0, true) => "-",
            (_, false) => " + ",
            (_, true) => " - ",
        };
        let size = number(first.value.abs(), first.high - first.low);
        let size = format!("{size} {}", first.unit);
        text += &format!("{sign}{}", product([size.trim_end().to_owned(), shown(of, &term.parameters, axis)]));
    }
    let meant = meanings(of, axis);
    if meant.is_empty() { text } else { format!("{text}, with {}", meant.join(", ")) }
}

/// A term without its coefficient; a parameter and a phase as letters.
pub(super) fn function(term: &Term, axis: AxisKind) -> String {
    let phase = if term.form == Form::Wave { " + phase" } else { "" };
    let letter = if term.adjustable(axis) { "p".to_owned() } else { value(term) };
    product([carrier(term, &letter), form(term, &letter, phase)])
}

/// The same with the values found.
fn shown(term: &Term, parameters: &[Interval], axis: AxisKind) -> String {
    let phase = parameters.iter().find(|p| p.id == "phase_rad").map_or_else(String::new, |phase| {
        let sign = if phase.value < 0.0 { '-' } else { '+' };
        format!(" {sign} {}", number(phase.value.abs(), phase.high - phase.low))
    });
    let own = parameters.last().filter(|_| term.adjustable(axis));
    let own = own.map_or_else(|| value(term), |p| format!("{} {}", number(p.value, p.high - p.low), p.unit));
    product([carrier(term, &own), form(term, &own, &phase)])
}

fn product<const N: usize>(factors: [String; N]) -> String {
    let factors: Vec<String> = factors.into_iter().filter(|factor| !factor.is_empty()).collect();
    factors.join(" \u{b7} ")
}

/// A whole order, or nothing to show.
fn value(term: &Term) -> String {
    format!("{:.0}", term.parameter)
}

fn carrier(term: &Term, p: &str) -> String {
    match term.carrier {
        Carrier::One => String::new(),
        Carrier::Sign => "sign(w)".to_owned(),
        Carrier::Speed => "w".to_owned(),
        Carrier::SpeedSquared => "w |w|".to_owned(),
        Carrier::SpeedCubed => "w\u{b3}".to_owned(),
        Carrier::Acceleration => "dw/dt".to_owned(),
        Carrier::Torque => "u".to_owned(),
        Carrier::TorqueSquared => "u |u|".to_owned(),
        Carrier::TorqueCubed => "u\u{b3}".to_owned(),
        Carrier::Load => "sign(w) |u|".to_owned(),
        Carrier::Drag => "D".to_owned(),
        Carrier::Field => "sign(w) E".to_owned(),
        Carrier::FieldSquared => "sign(w) E\u{b2}".to_owned(),
        Carrier::FieldTimesSpeed => "w E".to_owned(),
        Carrier::FieldTimesTorque => "u E".to_owned(),
        Carrier::Play => format!("(play(u, \u{b1}{p}) - u)"),
        Carrier::SlowField => format!("sign(w) lag(E, {p})"),
        Carrier::SlowPower => format!("D lag(D w, {p})"),
    }
}

fn form(term: &Term, p: &str, phase: &str) -> String {
    match term.form {
        Form::Constant => String::new(),
        // An order of one is not written.
        Form::Wave if p == "1" => format!("sin(x{phase})"),
        Form::Wave => format!("sin({p} x{phase})"),
        Form::Position => "x".to_owned(),
        Form::PositionSquared => "x\u{b2}".to_owned(),
        Form::PositionCubed => "x\u{b3}".to_owned(),
        Form::Time => "t".to_owned(),
        Form::From => format!("(1 from t = {p} on)"),
        Form::Slow => format!("exp(-(w / {p})\u{b2})"),
        Form::Young => format!("exp(-m / {p})"),
        Form::Rested => format!("r exp(-m / {p})"),
    }
}

/// What the letters used mean.
fn meanings(terms: &[Term], axis: AxisKind) -> Vec<String> {
    let units = Units::of(axis);
    let used = terms.iter().map(|term| product([carrier(term, ""), form(term, "", "")])).collect::<Vec<_>>().join(" ");
    let is_used = |letter: char| {
        let alone = |part: &str| part.chars().eq([letter]);
        used.split(|c: char| !c.is_alphabetic()).any(alone) || letter == 'w' && used.contains("dw")
    };
    let of_drive = format!("{} of the drive ({})", units.effort_name, units.effort);
    let of_fluid = format!("{} of the fluid against the motion ({})", units.effort_name, units.effort);
    let letters = [
        ('x', format!("position ({})", units.position)),
        ('w', format!("speed ({})", units.speed)),
        ('u', of_drive),
        ('E', "field (kV/mm)".to_owned()),
        ('D', of_fluid),
        ('t', "time (s)".to_owned()),
        ('m', "time since the motion began (s)".to_owned()),
        ('r', "rest before it (s)".to_owned()),
    ];
    letters
        .into_iter()
        .filter(|(letter, _)| is_used(*letter))
        .map(|(letter, name)| format!("{letter} {name}"))
        .collect()
}

/// Powers of torque (force), position, time and field in a function.
fn dimension(term: &Term) -> [i32; 4] {
    let carrier = match term.carrier {
        Carrier::One | Carrier::Sign => [0; 4],
        Carrier::Speed => [0, 1, -1, 0],
        Carrier::SpeedSquared => [0, 2, -2, 0],
        Carrier::SpeedCubed => [0, 3, -3, 0],
        Carrier::Acceleration => [0, 1, -2, 0],
        Carrier::Torque | Carrier::Load | Carrier::Drag | Carrier::Play => [1, 0, 0, 0],
        Carrier::TorqueSquared => [2, 0, 0, 0],
        Carrier::TorqueCubed => [3, 0, 0, 0],
        Carrier::Field | Carrier::SlowField => [0, 0, 0, 1],
        Carrier::FieldSquared => [0, 0, 0, 2],
        Carrier::FieldTimesSpeed => [0, 1, -1, 1],
        Carrier::FieldTimesTorque => [1, 0, 0, 1],
        Carrier::SlowPower => [2, 1, -1, 0],
    };
    let form = match term.form {
        Form::Constant | Form::Wave | Form::From | Form::Slow | Form::Young => [0; 4],
        Form::Position => [0, 1, 0, 0],
        Form::PositionSquared => [0, 2, 0, 0],
        Form::PositionCubed => [0, 3, 0, 0],
        Form::Time | Form::Rested => [0, 0, 1, 0],
    };
    std::array::from_fn(|index| carrier[index] + form[index])
}

/// Unit of a coefficient.
pub(super) fn coefficient_unit(term: &Term, axis: AxisKind) -> String {
    let units = Units::of(axis);
    let [effort, position, time, field] = dimension(term);
    let powers = [(units.effort, 1 - effort), ("s", -time), (units.position, -position), ("(kV/mm)", -field)];
    let part = |over: bool| -> Vec<String> {
        let those = powers.iter().filter(|(_, power)| if over { *power > 0 } else { *power < 0 });
        those.map(|(unit, power)| raised(unit, power.unsigned_abs())).collect()
    };
    let (over, under) = (part(true), part(false));
    let over = if over.is_empty() && !under.is_empty() { "1".to_owned() } else { over.join(" ") };
    match under.as_slice() {
        [] => over,
        [one] => format!("{over}/{one}"),
        several => format!("{over}/({})", several.join(" ")),
    }
}

fn raised(unit: &str, power: u32) -> String {
    let unit = if power > 1 && unit.contains(' ') { format!("({unit})") } else { unit.to_owned() };
    match power {
        2 => format!("{unit}\u{b2}"),
        3 => format!("{unit}\u{b3}"),
        _ => unit,
    }
}

/// Identifier and unit of the parameter of a carrier or form.
pub(super) fn parameter(term: &Term, axis: AxisKind) -> (&'static str, String) {
    let units = Units::of(axis);
    match (term.form, term.carrier) {
        (Form::Wave, _) => ("wave_number", format!("1/{}", units.position)),
        (Form::Slow, _) => ("speed", units.speed.to_owned()),
        (Form::From, _) => ("from_s", "s".to_owned()),
        (_, Carrier::Play) => ("half_width", units.effort.to_owned()),
        _ => ("time_s", "s".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(carrier: Carrier, form: Form) -> String {
        coefficient_unit(&Term { carrier, form, parameter: 1.0 }, AxisKind::Rotary)
    }

    #[test]
    fn coefficients_have_the_unit_that_makes_a_torque() {
        assert_eq!(unit(Carrier::Sign, Form::Wave), "N m");
        assert_eq!(unit(Carrier::One, Form::PositionCubed), "N m/rad\u{b3}");
        assert_eq!(unit(Carrier::SpeedSquared, Form::Constant), "N m s\u{b2}/rad\u{b2}");
        assert_eq!(unit(Carrier::Load, Form::Constant), "");
        assert_eq!(unit(Carrier::TorqueCubed, Form::Constant), "1/(N m)\u{b2}");
        assert_eq!(unit(Carrier::FieldTimesTorque, Form::Time), "1/(s (kV/mm))");
    }

    #[test]
    fn a_formula_is_one_line_that_says_what_its_letters_are() {
        let term = Term { carrier: Carrier::Sign, form: Form::Wave, parameter: 3.0 };
        let value = |id: &str, value: f64| Interval {
            id: id.to_owned(),
            value,
            low: value - 0.02,
            high: value + 0.02,
            unit: "N m".to_owned(),
        };
        let text = function(&term, AxisKind::Rotary);
        let terms = [FormulaTerm { text, parameters: vec![value("amplitude", 0.31), value("phase_rad", -0.4)] }];
        assert_eq!(
            sentence(&terms, &[term], AxisKind::Rotary),
            "torque = 0.310 N m \u{b7} sign(w) \u{b7} sin(3 x - 0.400), with x position (rad), w speed (rad/s)"
        );
        assert_eq!(terms[0].text, "sign(w) \u{b7} sin(3 x + phase)");
    }
}
