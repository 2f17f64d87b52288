//! Identification of a machine by experiments on its own drive.
//!
//! | experiment | what the drive does | what follows, and how |
//! |---|---|---|
//! | friction | ramps at four speeds without a field | c, viscous friction, torque offset: least squares on means of the torque at constant speed, exact |
//! | fields | ramps at five constant fields, at the highest of them at three speeds | a, b of equation (2): the same least squares; the constant of (5) follows from them |
//! | motion | a multisine without a field | inertia and delay of the motor: least squares on momentum, then the likelihood of `diagnosis` |
//! | field steps | a multisine that switches a constant field where the speed crosses a threshold | dead time, rise and fall of the field: the likelihood, of both motions together |
//!
//! A constant field needs nothing of the drive but parameters: with a law that wants more than the limit at any speed, the field is
//! the limit while the axis moves, and 0 above `off_speed_rad_s`. The torque is counted as commanded: inertia, friction and the
//! fluid's law are to its scale.

mod dynamic;
mod momentum;
mod plan;
mod report;
mod steady;

pub use dynamic::{FieldTimes, Motion};
pub use plan::{Plan, Planned};
pub use report::{applied, commented, machine, text};
pub use steady::Steady;

use er_servo::Config;

use crate::Error;
use crate::read::Recording;
use crate::session::Session;

/// A value with its 95 % interval.
pub use diagnosis::confidence_set::Interval;

/// What was found.
#[derive(Debug, Clone)]
pub struct Identified {
    /// Friction and the law of the fluid.
    pub steady: Steady,
    /// Constant of equation (5) for this fluid, ln(N m s/rad).
    pub er_q0: Interval,
    /// Inertia and delay of the motor.
    pub motion: Motion,
    /// Times of the field.
    pub field: FieldTimes,
    /// From the sampling of the position until the drive's outputs change, s, as its image says.
    pub sample_to_output_s: f64,
    /// Every experiment, in the order it was run.
    pub recordings: Vec<Recording>,
}

impl Identified {
    /// The recordings of the motions that are not at constant speed.
    pub fn moved(&self) -> impl Iterator<Item = &Recording> {
        self.recordings.iter().filter(|recording| [plan::MOTION, plan::FIELD_STEPS].contains(&recording.name.as_str()))
    }
}

/// What happens meanwhile.
#[derive(Debug)]
pub enum Event<'a> {
    /// This begins.
    Stage(&'a str),
    /// A recording has come; whatever becomes of the rest, it may be kept.
    Recorded(&'a Recording),
    /// The machine has been found, by a drive that had these parameters.
    Found(&'a Config, &'a Identified),
}

/// Is told of every event; an error ends the work.
pub type Told<'a> = dyn FnMut(Event<'_>) -> Result<(), Error> + 'a;

/// Runs the experiments and fits. Parameters of the law are as before afterwards, whatever happened.
///
/// # Errors
///
/// A drive that refuses or trips, Ctrl-C, no room for the motion, recordings that do not determine the machine, `told`.
pub fn identify(session: &mut Session, plan: &Plan, told: &mut Told) -> Result<Identified, Error> {
    let before = session.config()?;
    let runs = plan.runs(&before)?;
    let (up_rad, down_rad) = plan.room_rad();
    session.has_room(&before, up_rad, down_rad)?;
    let measured = measure(session, plan, &runs, told);
    let recordings = session.restored(&before, measured)?;
    told(Event::Stage("fits"))?;
    let to_output_s = session.sample_to_output_s();
    let found = session.computed(move || fit(&before, to_output_s, &runs, recordings))??;
    told(Event::Found(&before, &found))?;
    Ok(found)
}

fn measure(session: &mut Session, plan: &Plan, runs: &[Planned], told: &mut Told) -> Result<Vec<Recording>, Error> {
    let mut recordings = Vec::with_capacity(runs.len());
    for run in runs {
        told(Event::Stage(&format!("{}: {:.0} s", run.name, run.experiment.duration_s)))?;
        session.set(&run.parameters)?;
        let recording = session.experiment(&run.name, run.experiment, plan.max_torque_nm)?;
        told(Event::Recorded(&recording))?;
        recordings.push(recording);
    }
    Ok(recordings)
}

/// Fits what was measured, on a drive whose outputs change `sample_to_output_s` after a sample; the recordings are in the order
/// of the runs.
///
/// # Errors
///
/// Recordings that do not determine the machine.
pub fn fit(
    before: &Config,
    sample_to_output_s: f64,
    runs: &[Planned],
    recordings: Vec<Recording>,
) -> Result<Identified, Error> {
    let of =
        |wanted: fn(&plan::Purpose) -> bool| runs.iter().zip(&recordings).filter(move |(run, _)| wanted(&run.purpose));
    let ramps = of(|purpose| matches!(purpose, plan::Purpose::Steady { .. }));
    let steady = steady::fit(ramps, report::peak_field_kv_mm(before))?;
    let found = |name: &str, wanted: fn(&plan::Purpose) -> bool| {
        of(wanted).next().map(|(_, recording)| recording).ok_or_else(|| Error::Usage(format!("{name}: was not run")))
    };
    let motion = found("motion", |purpose| *purpose == plan::Purpose::Motion)?;
    let steps = found("field steps", |purpose| *purpose == plan::Purpose::FieldSteps)?;
    let (motion, field) = dynamic::fit(before, &steady, motion, steps)?;
    let er_q0 = report::constant_of_5(before, &steady);
    Ok(Identified { steady, er_q0, motion, field, sample_to_output_s, recordings })
}
