//! What an engineer fits first: inertia, dry and viscous friction, offset, and gravity of a rotary axis, by linear least squares over
//! short spans of the torque balance.

use nalgebra::{DMatrix, DVector};

use super::windows::{period_s, slope};
use crate::read::{AxisKind, EffectEntry, Machine, Recording};

/// Length of a span, s: shorter, the acceleration is noise; longer, it is averaged away.
const SPAN_S: f64 = 0.05;

/// A column of the regression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Term {
    Inertia,
    Coulomb,
    Viscous,
    Offset,
    Sine,
    Cosine,
}

/// The machine with these fitted and nothing else; none where the recordings do not determine them.
pub(crate) fn fitted(nominal: &Machine, recordings: &[&Recording]) -> Option<Machine> {
    let mut terms = vec![Term::Inertia, Term::Coulomb, Term::Viscous, Term::Offset];
    if nominal.axis.kind == AxisKind::Rotary {
        terms.extend([Term::Sine, Term::Cosine]);
    }
    let spans: Vec<Span> = recordings.iter().flat_map(|recording| Span::all(recording)).collect();
    loop {
        let values = solve(&terms, &spans)?;
        // No friction drives: what comes out negative is left out.
        let wrong = terms
            .iter()
            .zip(&values)
            .position(|(term, value)| matches!(term, Term::Coulomb | Term::Viscous | Term::Inertia) && *value < 0.0);
        match wrong {
            Some(index) if terms[index] != Term::Inertia => drop(terms.remove(index)),
            Some(_) => return None,
            None => return Some(machine(nominal, &terms, &values)),
        }
    }
}

/// Means over a span, and the torque that they stand beside.
struct Span {
    torque: f64,
    acceleration: f64,
    sign: f64,
    speed: f64,
    sine: f64,
    cosine: f64,
}

impl Span {
    fn all(recording: &Recording) -> Vec<Self> {
        let rows = ((SPAN_S / period_s(recording)).round() as usize).max(2);
        let starts = (0..recording.rows().saturating_sub(rows + 1)).step_by(rows);
        let whole = |start: &usize| !recording.gaps.iter().any(|gap| (*start..start + rows).contains(gap));
        starts.filter(whole).map(|start| Self::of(recording, start, start + rows)).collect()
    }

    fn of(recording: &Recording, from: usize, to: usize) -> Self {
        let time_s = recording.t_s[to] - recording.t_s[from];
        let mean = |value: &dyn Fn(usize) -> f64| {
            (from..to).map(|row| value(row) * (recording.t_s[row + 1] - recording.t_s[row])).sum::<f64>() / time_s
        };
        let position = |row: usize| recording.position[row];
        Self {
            torque: mean(&|row| recording.effort_cmd[row]),
            acceleration: (slope(recording, to) - slope(recording, from)) / time_s,
            sign: mean(&|row| slope(recording, row).signum()),
            speed: (position(to) - position(from)) / time_s,
            sine: mean(&|row| position(row).sin()),
            cosine: mean(&|row| position(row).cos()),
        }
    }

    fn value(&self, term: Term) -> f64 {
        match term {
            Term::Inertia => self.acceleration,
            Term::Coulomb => self.sign,
            Term::Viscous => self.speed,
            Term::Offset => -1.0,
            Term::Sine => self.sine,
            Term::Cosine => self.cosine,
        }
    }
}

fn solve(terms: &[Term], spans: &[Span]) -> Option<Vec<f64>> {
    if spans.len() < 2 * terms.len() {
        return None;
    }
    let columns = DMatrix::from_fn(spans.len(), terms.len(), |row, column| spans[row].value(terms[column]));
    let torque = DVector::from_iterator(spans.len(), spans.iter().map(|span| span.torque));
    let values = columns.svd(true, true).solve(&torque, 1e-9).ok()?;
    values.iter().all(|value| value.is_finite()).then(|| values.iter().copied().collect())
}

fn machine(nominal: &Machine, terms: &[Term], values: &[f64]) -> Machine {
    let value = |term: Term| terms.iter().position(|known| *known == term).map_or(0.0, |index| values[index]);
    let mut machine = nominal.clone();
    let plant = &mut machine.plant;
    (plant.inertia, plant.coulomb, plant.viscous) = (value(Term::Inertia), value(Term::Coulomb), value(Term::Viscous));
    (plant.torque_gain, plant.torque_offset) = (1.0, value(Term::Offset));
    // Sine and cosine of the position as one gravity with its phase.
    let (sine, cosine) = (value(Term::Sine), value(Term::Cosine));
    machine.effects.clear();
    if sine != 0.0 || cosine != 0.0 {
        machine.effects.push(EffectEntry {
            id: "gravity_load".to_owned(),
            recording: None,
            parameters: vec![
                ("amplitude_nm".to_owned(), sine.hypot(cosine)),
                ("phase_rad".to_owned(), cosine.atan2(sine)),
            ],
        });
    }
    machine
}
