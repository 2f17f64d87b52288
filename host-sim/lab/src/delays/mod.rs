//! Which delay the fluid has: none, a dead time or a lag of the coefficient of viscosity or of the field, or both of the
//! field; by the likelihood of the crate `diagnosis`, with its confidence set, and with the experiment that would tell apart
//! what these recordings do not.

mod contenders;
mod figure;
mod plan;
mod standing;
mod text;

use diagnosis::confidence_set::intervals;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::ranking::{Contender, Ranked, rank};
use diagnosis::recorded::Recorded;
use plant::{FieldResponse, FluidResponse};
use serde::Serialize;

use crate::Error;
use crate::asked::recorded;
use crate::progress::Course;
use crate::read::vocabulary;
use crate::read::{AxisKind, Machine, Recording};

pub(crate) use contenders::late_viscosities;
pub use figure::figure;
pub use plan::{Plan, Simulated};
use standing::Standing;

/// What is asked.
#[derive(Debug)]
pub struct Request<'a> {
    /// The machine; its own delays of the field are set aside.
    pub machine: &'a Machine,
    /// Recordings to fit, one at least.
    pub recordings: &'a [Recording],
    /// Recordings that only judge.
    pub holdout: &'a [Recording],
}

/// One value of a delay model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Value {
    /// Effect and parameter, such as `field_lag.lag_s`.
    pub id: String,
    /// Estimate, s.
    pub value_s: f64,
    /// 95 % interval, s.
    pub low_s: f64,
    /// Its upper end, s.
    pub high_s: f64,
}

/// What became of one delay model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// Its name.
    pub name: &'static str,
    /// Fitted values.
    pub values: Vec<Value>,
    /// Log-likelihood by which the best is better, 0 for the best.
    pub behind: f64,
    /// Probability that chance alone makes the best that much better; 1 for the best.
    pub p_value: f64,
    /// The recordings do not tell it from the best.
    pub in_set: bool,
    /// In the set, and either no special case of it is, or each of its delays is away from zero.
    pub needed: bool,
}

/// What the recordings say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// One model is left.
    Named,
    /// Several are left.
    Ambiguous,
}

/// The answer.
#[derive(Debug, Serialize)]
pub struct Answer {
    /// One model or several.
    pub verdict: Verdict,
    /// Every model, likeliest first.
    pub candidates: Vec<Candidate>,
    /// Experiments by how well they would tell apart what is left, best first; none where one model is left.
    pub plans: Vec<Plan>,
    /// What the pictures are drawn from.
    #[serde(skip)]
    pub drawn: Drawn,
}

/// Curves of the pictures.
#[derive(Debug, Default)]
pub struct Drawn {
    /// For each model its log-likelihood below the best one's, summed up to a time, s.
    pub evidence: Vec<(&'static str, Vec<(f64, f64)>)>,
    /// For each model that is left the position in the best experiment less that of the first, over time, s and rad (m).
    pub apart: Vec<(&'static str, Vec<(f64, f64)>)>,
    /// The sensor's step, rad (m).
    pub resolution: f64,
}

/// Ranks the delay models.
///
/// # Errors
/// A machine without a damper or on a linear axis, recordings that never drive the field or that nothing can be computed from.
pub fn answer(request: &Request<'_>) -> Result<Answer, Error> {
    answer_on(request, &Course::unseen())
}

/// The same, which shows how far it is.
///
/// # Errors
/// As [`answer`].
pub fn answer_on(request: &Request<'_>, course: &Course) -> Result<Answer, Error> {
    course.enter("preparing");
    let machine = request.machine;
    let problem = problem(request)?;
    let contenders = contenders::all();
    let count = course.count("models of delay", contenders.len() as u64);
    let ranked = rank(&problem, &contenders, || count.advance());
    if ranked.is_empty() {
        return Err(Error::Usage("the nominal machine cannot be followed along these recordings".to_owned()));
    }
    let left: Vec<Contender> = ranked.iter().filter(|one| Standing::of(&ranked, one).needed).map(fitted).collect();
    let (mut plans, mut apart) = (Vec::new(), Vec::new());
    if left.len() > 1 {
        let simulated = Simulated::new(machine, &problem, &ranked[0].step.assessed.refitted.noise, left);
        plans = simulated.plans(course)?;
        if let Some(best) = plans.first() {
            apart = simulated.apart(best)?;
        }
    }
    Ok(Answer {
        verdict: if plans.is_empty() { Verdict::Named } else { Verdict::Ambiguous },
        candidates: ranked.iter().map(|one| candidate(&ranked, one)).collect(),
        plans,
        drawn: Drawn { evidence: evidence(&problem, &ranked), apart, resolution: machine.axis.resolution },
    })
}

/// The machine without the delays of its field, and the recordings.
fn problem(request: &Request<'_>) -> Result<Problem, Error> {
    let Request { machine, recordings, holdout } = *request;
    let refuse = |key: &str, message: &str| Err(Error::input(&machine.file, None, key, message));
    if machine.axis.kind != AxisKind::Rotary {
        return refuse("axis.kind", "the control law drives a rotary axis; delays of the fluid are told on one");
    }
    let files: Vec<&Recording> = recordings.iter().chain(holdout).collect();
    let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    let mut physics = Physics::nominal(machine, &names);
    let Some(er) = &mut physics.model.er else {
        return refuse("plant.er", "is missing; without a damper there is no delay to tell");
    };
    er.response = match er.response {
        FluidResponse::Field(field) => {
            FluidResponse::Field(FieldResponse { slew_kv_mm_s: field.slew_kv_mm_s, ..FieldResponse::default() })
        }
        _ => FluidResponse::Field(FieldResponse::default()),
    };
    let recorded: Vec<Recorded> = files.iter().map(|file| recorded(machine, file)).collect();
    let problem = Problem::new(physics, recorded, recordings.len(), machine.axis.resolution, false);
    if problem.excitation.field_peak <= 0.0 {
        return Err(Error::Usage(format!(
            "{}: the field is never driven, or not recorded (field_cmd_kv_mm)",
            names.join(", ")
        )));
    }
    Ok(problem)
}

/// A contender that begins at what was fitted.
fn fitted(ranked: &Ranked) -> Contender {
    Contender { name: ranked.name, starts: vec![ranked.step.assessed.refitted.hypothesis.clone()] }
}

fn candidate(all: &[Ranked], ranked: &Ranked) -> Candidate {
    let Standing { in_set, needed } = Standing::of(all, ranked);
    let assessed = &ranked.step.assessed;
    let mut values = Vec::new();
    for (at, entry) in assessed.refitted.hypothesis.entries.iter().enumerate() {
        let kinds = vocabulary::effect(entry.effect.id).map_or(&[][..], |kind| kind.parameters);
        values.extend(kinds.iter().zip(intervals(assessed, at)).map(|(kind, interval)| Value {
            id: format!("{}.{}", entry.effect.id, kind.id(AxisKind::Rotary)),
            value_s: interval.value,
            low_s: interval.low,
            high_s: interval.high,
        }));
    }
    Candidate {
        name: ranked.name,
        values,
        behind: ranked.behind.map_or(0.0, |behind| behind.difference),
        p_value: ranked.behind.map_or(1.0, |behind| behind.p_value()),
        in_set,
        needed,
    }
}

/// Where in the recordings, one behind the other, each model falls behind the best.
fn evidence(problem: &Problem, ranked: &[Ranked]) -> Vec<(&'static str, Vec<(f64, f64)>)> {
    let rows = |one: &Ranked| -> Vec<f64> {
        let all = &one.step.assessed.refitted.evaluation.innovations;
        all.iter().flat_map(|of| of.log_likelihood.iter().copied()).collect()
    };
    let mut times: Vec<f64> = Vec::new();
    for recorded in problem.recordings.iter() {
        let before = times.last().map_or(0.0, |last| last + recorded.period_s());
        times.extend(recorded.t_s.iter().map(|t_s| before + t_s - recorded.t_s[0]));
    }
    let best = rows(&ranked[0]);
    let curve = |one: &Ranked| {
        let mut sum = 0.0;
        let points = times.iter().zip(best.iter().zip(rows(one)));
        (
            one.name,
            points
                .map(|(t_s, (best, own))| {
                    sum += best - own;
                    (*t_s, sum)
                })
                .collect(),
        )
    };
    ranked.iter().map(curve).collect()
}
