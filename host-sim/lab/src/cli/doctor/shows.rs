//! Which effects the motion of a log can show.

use diagnosis::effects::find;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;

use super::{Check, State};
use crate::first_model::{FirstModel, Load};
use crate::guide::{Clear, Shown, shown};
use crate::read::{Axis, AxisKind, Machine, Recording};
use crate::report::html::measure;

/// Fewest rows of a log that noise is estimated on, as a diagnosis has it.
const FEWEST_ROWS: usize = 40;

/// What the motion shows of the machine, by its file or else by the `first` model with the delay of its effort, s; nothing where that
/// is none. A delay that is left out would be noise, under which nothing shows.
pub(super) fn shows(
    recording: &Recording,
    axis: &Axis,
    machine: Option<&Machine>,
    first: Option<(&FirstModel, f64)>,
) -> Vec<Check> {
    let physics = match (machine, first) {
        (Some(machine), _) => Some(Physics::nominal(machine, &[&recording.name])),
        (None, Some((model, delay_s))) if !model.reversed => physics(axis, model, delay_s),
        _ => None,
    };
    let Some(physics) = physics.filter(|_| recording.rows() >= FEWEST_ROWS) else { return Vec::new() };
    let linear = axis.kind == AxisKind::Linear;
    let problem = Problem::new(physics, vec![Recorded::new(recording)], 1, axis.resolution, linear);
    shown(&problem.sampled(axis.sample_period_s)).map_or_else(Vec::new, |shown| checks(&shown))
}

/// The machine of the first model. An inertia that the motion does not tell is the largest that it allows.
fn physics(axis: &Axis, model: &FirstModel, delay_s: f64) -> Option<Physics> {
    let inertia = if model.inertia.is_known() && model.inertia.value > 0.0 {
        model.inertia.value
    } else {
        model.inertia.value.abs() + model.inertia.within
    };
    let told = |value: crate::first_model::Value| if value.kept { value.value } else { 0.0 };
    let mut nominal = plant::Model::new(inertia);
    nominal.coulomb = told(model.coulomb).max(0.0);
    nominal.viscous = told(model.viscous).max(0.0);
    nominal.torque_offset = told(model.offset);
    nominal.torque_delay_s = delay_s;
    let mut physics = Physics::new(nominal);
    if let Some((id, given)) = model.load.map(Load::effect)
        && let Some(effect) = find(id)
        && let Some(values) = (effect.fitted)(&given, None)
    {
        (effect.put)(&mut physics, &values);
    }
    (axis.sample_period_s > 0.0 && inertia.is_finite() && inertia > 0.0).then_some(physics)
}

fn checks(shown: &Shown) -> Vec<Check> {
    let list = |ids: &[&str]| if ids.is_empty() { "nothing".to_owned() } else { ids.join(", ") };
    let mut checks = vec![Check::new(
        if shown.shows.is_empty() { State::Bad } else { State::Good },
        "shows",
        format!("{}: a clear one would be seen", list(&shown.shows)),
    )];
    if !shown.alike.is_empty() {
        let pair = |(id, others): &(&str, Vec<&str>)| format!("{id} from {}", others.join(" or "));
        let pairs: Vec<String> = shown.alike.iter().map(pair).collect();
        checks.push(Check::new(State::Note, "not told", format!("apart by this motion: {}", pairs.join("; "))));
    }
    if !shown.hidden.is_empty() {
        let size = |one: &Clear| format!("{} at {} {}", one.id, one.parameter, measure(one.value));
        let sizes: Vec<String> = shown.hidden.iter().map(size).collect();
        let found =
            format!("{}: larger ones may be seen; move so that they act, or leave them aside", sizes.join(", "));
        checks.push(Check::new(State::Note, "cannot show", found));
    }
    checks
}
