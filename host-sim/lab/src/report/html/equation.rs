//! A machine as the equations that it moves by, with its numbers.

use diagnosis::physics::Physics;
use plant::effects::Harmonic;
use plant::{Er, FluidResponse, Model};

use super::words::{number, short};
use crate::read::AxisKind;
use crate::report::Answer;

/// Writes numbers: those of the answer with the digits that their intervals leave and a star.
struct Numbers {
    /// Value and width of its interval.
    found: Vec<(f64, f64)>,
}

/// Letters of an axis.
struct Letters {
    inertia: &'static str,
    position: &'static str,
    speed: &'static str,
    effort: &'static str,
}

/// The equations of a machine along one recording, a line each.
pub(super) fn lines(physics: &Physics, answer: &Answer, axis: AxisKind) -> Vec<String> {
    let values = answer.effects.iter().flat_map(|effect| &effect.parameters);
    let of = Numbers { found: values.map(|value| (value.value, value.high - value.low)).collect() };
    let letters = match axis {
        AxisKind::Rotary => Letters { inertia: "J", position: "θ", speed: "ω", effort: "T" },
        AxisKind::Linear => Letters { inertia: "m", position: "x", speed: "v", effort: "F" },
    };
    let model = &physics.model;
    let others = others(physics, &of, &letters);
    let other = if others.is_empty() { "" } else { " + P" };
    let Letters { inertia, speed: w, effort: t, .. } = letters;
    let mut lines = vec![
        format!("{inertia} d{w}/dt = {t} − D{other},  {inertia} = {}", of.number(model.inertia)),
        drive(model, &of, &letters),
        drag(model, &of, &letters),
    ];
    lines.extend((!others.is_empty()).then(|| format!("P = {}", joined(&others))));
    lines.extend(model.er.as_ref().and_then(|er| fluid(er, &of)));
    lines.extend(shaft(model, &of));
    lines.extend(measured(physics, &of, &letters));
    lines
}

impl Numbers {
    fn number(&self, value: f64) -> String {
        // Values pass through the fit and the file unchanged but for rounding.
        let same = |found: &&(f64, f64)| (value.abs() - found.0.abs()).abs() <= 1e-9 * found.0.abs() && found.0 != 0.0;
        match self.found.iter().find(same) {
            Some((_, width)) => format!("{}*", number(value, *width)),
            None => short(value),
        }
    }

    /// `+ 3 x` or `− 3 x`; nothing for zero.
    fn term(&self, value: f64, of: &str) -> Option<String> {
        let sign = if value < 0.0 { '−' } else { '+' };
        (value != 0.0).then(|| format!("{sign} {}{of}", self.number(value.abs())))
    }

    fn sine(&self, sign: f64, sine: &Harmonic, position: &str) -> Option<String> {
        let order = if sine.order == 1.0 { String::new() } else { format!("{} ", self.number(sine.order)) };
        let phase = self.term(sine.phase_rad, "").map_or_else(String::new, |phase| format!(" {phase}"));
        self.term(sign * sine.amplitude, &format!(" sin({order}{position}{phase})"))
    }
}

/// Terms as one sum.
fn joined(terms: &[String]) -> String {
    let all = terms.join(" ");
    all.strip_prefix("+ ").map_or(all.clone(), str::to_owned)
}

/// What the drive makes of its command u.
fn drive(model: &Model, of: &Numbers, letters: &Letters) -> String {
    let (t, position) = (letters.effort, letters.position);
    let late = of.term(-model.torque_delay_s, "").map_or_else(String::new, |late| format!(" {late}"));
    let gain = if model.torque_gain == 1.0 { String::new() } else { format!("{} ", of.number(model.torque_gain)) };
    let mut terms = vec![format!("{gain}u(t{late})")];
    terms.extend(of.term(model.torque_offset, ""));
    let mut line = format!("{t} = {}", terms.join(" "));
    let ripple: Vec<String> = model.torque_ripple.iter().filter_map(|sine| of.sine(1.0, sine, position)).collect();
    if !ripple.is_empty() {
        line = format!("{t} = ({}) (1 {})", terms.join(" "), ripple.join(" "));
    }
    if model.torque_lag_s > 0.0 {
        line += &format!(", behind a lag of {} s", of.number(model.torque_lag_s));
    }
    if model.torque_deadband > 0.0 {
        line += &format!(", u less a dead band of {}", of.number(model.torque_deadband));
    }
    if let Some(limit) = model.torque_limit {
        line += &format!(",  |{t}| ≤ {}", of.number(limit));
    }
    line
}

/// What opposes the motion.
fn drag(model: &Model, of: &Numbers, letters: &Letters) -> String {
    let (w, t) = (letters.speed, letters.effort);
    let mut dry = Vec::new();
    let mut level = of.term(model.coulomb, "");
    if model.asymmetry.coulomb != 0.0 {
        let half = 0.5 * model.asymmetry.coulomb;
        level = Some(format!("+ {} {} sgn {w}", of.number(model.coulomb), of.term(half, "").unwrap_or_default()));
    }
    dry.extend(level);
    dry.extend(of.term(model.load_friction, &format!(" |{t}|")));
    if let Some(stribeck) = model.stribeck {
        dry.extend(of.term(stribeck.excess, &format!(" exp(−({w}/{})²)", of.number(stribeck.velocity))));
    }
    if let Some(er) = &model.er {
        let scale = if er.scale == 1.0 { String::new() } else { format!("{} ", of.number(er.scale)) };
        dry.push(format!("+ {scale}({} E² + {} E)", of.number(er.a), of.number(er.b)));
    }
    let mut terms = Vec::new();
    if !dry.is_empty() {
        terms.push(format!("+ ({}) sgn {w}", joined(&dry)));
    }
    terms.extend(of.term(model.viscous, &format!(" {w}")));
    terms.extend(of.term(model.quadratic_drag, &format!(" {w} |{w}|")));
    if terms.is_empty() {
        return "D = 0".to_owned();
    }
    let mut line = format!("D = {}", joined(&terms));
    if let Some(stiffness) = model.presliding_stiffness {
        line += &format!(", its dry part as a bristle of stiffness {}", of.number(stiffness));
    } else if !dry.is_empty() {
        line += "; at rest its dry part holds";
    }
    if model.viscous_warming.is_some() {
        line += "; its viscous part falls as the machine warms";
    }
    line
}

/// Torques that neither drive nor drag make.
fn others(physics: &Physics, of: &Numbers, letters: &Letters) -> Vec<String> {
    let (model, position) = (&physics.model, letters.position);
    let mut terms: Vec<String> = model.cogging.iter().filter_map(|sine| of.sine(1.0, sine, position)).collect();
    if let Some(gravity) = model.gravity {
        let sine = Harmonic { amplitude: gravity.amplitude, order: 1.0, phase_rad: gravity.phase_rad };
        terms.extend(of.sine(-1.0, &sine, position));
    }
    terms.extend(of.term(-model.spring_stiffness, &format!(" {position}")));
    terms.extend(physics.pushes.iter().filter_map(|push| {
        let (from_s, until_s) = (push.pulse.start_s, push.pulse.start_s + push.pulse.duration_s);
        let when = format!(" from {} to {} s", of.number(from_s), number(until_s, 1e-3));
        of.term(push.pulse.amplitude, &when)
    }));
    if let Some(tone) = &physics.tone {
        let largest = tone.phasors.iter().map(|(sine, cosine)| sine.hypot(*cosine)).fold(0.0, f64::max);
        terms.extend(of.term(largest, &format!(" sin(2π {} t + a phase)", of.number(tone.frequency_hz))));
    }
    terms
}

/// How the field follows its command.
fn fluid(er: &Er, of: &Numbers) -> Option<String> {
    let late = |dead_time_s: f64| {
        let late = of.term(-dead_time_s, "").map_or_else(String::new, |late| format!(" {late}"));
        format!("E_cmd(t{late})")
    };
    let gain = if er.field_gain == 1.0 { String::new() } else { format!("{} ", of.number(er.field_gain)) };
    match er.response {
        FluidResponse::Field(field) => {
            let command = format!("{gain}{}", late(field.dead_time_s));
            let mut line = if field.rise_s == 0.0 && field.fall_s == 0.0 {
                format!("E = {command}")
            } else if field.rise_s == field.fall_s {
                format!("dE/dt = ({command} − E) / {}", of.number(field.rise_s))
            } else {
                let (rise, fall) = (of.number(field.rise_s), of.number(field.fall_s));
                format!("dE/dt = ({command} − E) / τ,  τ = {rise} rising, {fall} falling")
            };
            if let Some(slew) = field.slew_kv_mm_s {
                line += &format!(",  |dE/dt| ≤ {}", of.number(slew));
            }
            Some(line)
        }
        FluidResponse::ViscosityDeadTime { dead_time_s, .. } => {
            Some(format!("the viscosity, not the field, acts {} s late", of.number(dead_time_s)))
        }
        FluidResponse::ViscosityLag { lag_s, .. } => {
            Some(format!("the viscosity, not the field, lags by {} s", of.number(lag_s)))
        }
    }
}

fn shaft(model: &Model, of: &Numbers) -> Option<String> {
    let shaft = model.shaft.filter(|shaft| shaft.inertia_ratio > 0.0)?;
    let gap = if shaft.gap > 0.0 { format!(" behind a gap of {}", of.number(shaft.gap)) } else { String::new() };
    Some(format!(
        "a load of {} of the motor's inertia swings{gap} at {} Hz, damping ratio {}",
        of.number(shaft.inertia_ratio),
        of.number(shaft.resonance_hz),
        of.number(shaft.damping_ratio)
    ))
}

/// What the log has of it.
fn measured(physics: &Physics, of: &Numbers, letters: &Letters) -> Option<String> {
    let (model, position) = (&physics.model, letters.position);
    let late_s = model.sensor.latency_s + physics.skew_s;
    let late = of.term(-late_s, "").map_or_else(String::new, |late| format!(" {late}"));
    let errors = model.sensor.eccentricity.iter().filter_map(|sine| of.sine(1.0, sine, position));
    let errors: Vec<String> = errors.collect();
    let mut parts = Vec::new();
    if late_s != 0.0 || !errors.is_empty() {
        parts.push(format!("measured = {position}(t{late}) {}", errors.join(" ")).trim_end().to_owned());
    }
    if physics.torque_filter_s > 0.0 {
        parts.push(format!("the torque column is behind a filter of {} s", of.number(physics.torque_filter_s)));
    }
    if let Some((share, size)) = physics.glitch {
        parts.push(format!("a share {} of the samples is wrong by about {}", of.number(share), of.number(size)));
    }
    (!parts.is_empty()).then(|| parts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::testing::effect;

    fn answer(value: f64, half: f64) -> Answer {
        let effect = effect("coulomb_friction", "c", value, half);
        Answer { effects: vec![effect], ..Answer::default() }
    }

    #[test]
    fn the_equation_has_the_terms_of_the_machine_and_marks_what_was_found() {
        let mut physics = Physics::new(Model { er: None, ..Model::paper() });
        physics.model.coulomb = 0.812_345;
        physics.model.viscous = 0.25;
        physics.model.cogging = vec![Harmonic { amplitude: 0.2, order: 10.0, phase_rad: -0.5 }];
        let lines = lines(&physics, &answer(0.812_345, 0.02), AxisKind::Rotary);
        assert_eq!(
            lines,
            [
                "J dω/dt = T − D + P,  J = 0.075",
                "T = u(t − 0.005),  |T| ≤ 30",
                "D = (0.812*) sgn ω + 0.25 ω; at rest its dry part holds",
                "P = 0.2 sin(10 θ − 0.5)",
            ]
        );
    }

    #[test]
    fn a_plain_inertia_and_a_damper() {
        let plain = lines(&Physics::new(Model::new(2.0)), &Answer::default(), AxisKind::Linear);
        assert_eq!(plain, ["m dv/dt = F − D,  m = 2", "F = u(t)", "D = 0"]);
        let mut physics = Physics::new(Model::paper());
        physics.model.er = Some(Er::new(0.0704, 0.47, 0.002, 0.003));
        let damped = lines(&physics, &Answer::default(), AxisKind::Rotary);
        assert_eq!(damped[2], "D = (0.763 + (0.0704 E² + 0.47 E)) sgn ω; at rest its dry part holds");
        assert_eq!(damped[3], "dE/dt = (E_cmd(t − 0.002) − E) / 0.003");
    }
}
