//! The control that the paper asks for in its last sentence, beside its own law: what becomes possible when the delays of
//! motor and fluid are known.
//!
//! The modes live outside the flashed step, as something that replaces the torque and the field it commands
//! ([`crate::simulate::ClosedLoop::tick_beside`]): they show what is to be gained, and nothing here runs on the drive. Position, speed
//! estimate, limits and faults stay those of the flashed law.
//!
//! - Field lead: the field is asked for the state at which it will act, and its lag is inverted within its limits.
//! - Predictor: the PD law acts on the state at which its torque will act, found from the torques and fields under way.
//!   Smith's predictor in the time domain; friction and damper are in its model, and a torque from outside is estimated and
//!   cancelled, for a push that the prediction does not know moves the rotor unseen.
//! - Smooth Q: a torque over speed that ends at 1.5 rad/s without a jump, and a field at rest wherever dry friction holds
//!   the rotor already, so that it costs no residual.
//! - Steady brake: braking grows with the speed away from the reference and fades over the fluid's own time.

mod law;
mod measure;
mod model;
mod report;

use er_servo::Counts;
use plant::{Er, FluidResponse, Model};
use rayon::prelude::*;

use crate::paper::case::{A, B};
use crate::simulate::{Row, Setup, run_beside};
use law::Beside;
pub use law::Mode;
pub use measure::{Figures, LINES};
use recording::Error;

/// Each delay may be off by this share, up and down: the "several dozen percent" of section VII.
pub const UNCERTAINTY: f64 = 0.36;

/// What is compared, the paper's law first.
pub const MODES: [Mode; 10] = [
    Mode::PAPER,
    Mode { name: "gains x 1.25", key: "gains-1.25", gains: 1.25, ..Mode::PAPER },
    Mode { name: "field lead", key: "lead", leads: true, ..Mode::PAPER },
    Mode { name: "predictor", key: "predictor", predicts: true, ..Mode::PAPER },
    Mode { name: "predictor, gains x 1.25", key: "predictor-gains-1.25", predicts: true, gains: 1.25, ..Mode::PAPER },
    Mode { name: "smooth Q", key: "smooth-q", smooth: true, ..Mode::PAPER },
    Mode { name: "steady brake", key: "steady-brake", steady_brake: true, ..Mode::PAPER },
    Mode {
        name: "predictor, lead, gains x 1.25",
        key: "predictor-lead-gains-1.25",
        predicts: true,
        leads: true,
        gains: 1.25,
        ..Mode::PAPER
    },
    ALL,
    Mode { name: "all, gains x 1.25", key: "all-gains-1.25", gains: 1.25, ..ALL },
];

/// Every part with the paper's gains.
const ALL: Mode =
    Mode { name: "all", key: "all", leads: true, predicts: true, smooth: true, steady_brake: true, ..Mode::PAPER };

/// The mode of that key.
#[must_use]
pub fn find(key: &str) -> Option<&'static Mode> {
    MODES.iter().find(|mode| mode.key == key)
}

/// Runs a closed loop under a mode: the flashed law with the mode's gains, and what the mode puts in the place of its commands.
///
/// The mode is told the paper's machine, whatever machine `setup` is: [`is_told`] tells whether that is the same.
///
/// # Errors
/// A value the law or the plant does not take; a fluid whose viscosity is delayed, which no mode commands.
pub fn run(mode: &Mode, setup: &Setup, reference: impl IntoIterator<Item = Counts>) -> Result<Vec<Row>, Error> {
    let er = setup.model.er.as_ref();
    if er.is_some_and(|er| !matches!(er.response, FluidResponse::Field(_))) {
        let message = "a mode commands a field, and this fluid delays a viscosity that the law asks for";
        return Err(Error::Usage(message.to_owned()));
    }
    let setup = Setup { config: mode.config(&setup.config), ..setup.clone() };
    let mut beside = Beside::new(*mode, &setup.config).map_err(|error| Error::Usage(error.to_string()))?;
    run_beside(&setup, reference, |reference, outputs| beside.tick(reference, outputs))
}

/// Whether a machine is the one that the modes are told: rotor, friction, damper and delays of the paper's.
#[must_use]
pub fn is_told(machine: &Model) -> bool {
    let told = Model { er: Some(Er::new(A, B, model::DEAD_TIME_S, model::LAG_S)), ..Model::paper() };
    *machine == told
}

/// One mode with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The mode.
    pub mode: Mode,
    /// With the delays it was told.
    pub nominal: Figures,
    /// The worst of each figure over every delay off by [`UNCERTAINTY`], alone and together.
    pub worst: Figures,
}

/// All modes on the machine the paper ends on: E dead 2 + lag 3 ms, L 5 ms, speed from counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// In the order of [`MODES`].
    pub entries: Vec<Entry>,
}

impl Comparison {
    /// The mode that is no worse than the paper's law on any line and better on most, of several the one with fewest parts; none
    /// where each costs something.
    #[must_use]
    pub fn winner(&self) -> Option<&Entry> {
        let rank = |entry: &&Entry| {
            let (lost, won) = self.against_paper(entry.nominal, entry.worst);
            (lost.is_empty() && won > 0).then_some((won, usize::MAX - entry.mode.parts()))
        };
        self.entries.iter().skip(1).filter(|entry| rank(entry).is_some()).max_by_key(rank)
    }
}

/// Runs every mode with the delays it was told and with delays that are off.
///
/// # Errors
/// A value the law or the plant does not take.
pub fn compare() -> Result<Comparison, Error> {
    let entry = |mode: &Mode| {
        let factors = [1.0 - UNCERTAINTY, 1.0, 1.0 + UNCERTAINTY];
        let mut places = Vec::new();
        for motor in factors {
            for dead in factors {
                places.extend(factors.map(|lag| [motor, dead, lag]));
            }
        }
        let figures = places.into_par_iter().map(|factors| measure::figures(mode, factors));
        let figures = figures.collect::<Result<Vec<_>, Error>>()?;
        let worst = figures.iter().copied().reduce(Figures::worst).unwrap_or_default();
        // The middle of the grid is where no delay is off.
        let nominal = figures.get(figures.len() / 2).copied().unwrap_or_default();
        Ok(Entry { mode: *mode, nominal, worst })
    };
    Ok(Comparison { entries: MODES.iter().map(entry).collect::<Result<Vec<_>, Error>>()? })
}
