//! The range over which the claims of section VI are tested: delay of the motor system, step, how much slower the plant
//! is than its gains assume, source of the speed, times every delay model.

use rayon::prelude::*;

use super::case::{Case, Fluid, Response, STEP_RAD, Speed};
use progress::Progress;
use recording::Error;

/// L that scales the gains, s.
pub const GAINS_DELAYS_S: [f64; 8] = [0.0015, 0.002, 0.003, 0.004, 0.005, 0.006, 0.008, 0.01];
/// Steps, rad.
pub const STEPS_RAD: [f64; 7] = [0.0055, 0.02, 0.05, 0.1, 0.2, STEP_RAD, 1.0];
/// Delay of the plant over the L of the gains, 1; 2.2 is control.md's 4.4 ms for gains of 2 ms.
pub const SLOWNESSES: [f64; 3] = [1.0, 1.5, 2.2];

/// One place of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// L that scales the gains, s.
    pub gains_delay_s: f64,
    /// Height of the step, rad.
    pub step_rad: f64,
    /// Delay of the plant over `gains_delay_s`, 1.
    pub slowness: f64,
    /// Speed the law uses.
    pub speed: Speed,
}

impl Point {
    /// The experiment at this place.
    #[must_use]
    pub fn case(&self, fluid: Fluid) -> Case {
        Case {
            fluid,
            gains_delay_s: self.gains_delay_s,
            plant_delay_s: self.gains_delay_s * self.slowness,
            step_rad: self.step_rad,
            speed: self.speed,
            ..Case::PAPER
        }
    }
}

/// What a delay model did at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Its figures.
    pub response: Response,
    /// Largest distance from the run without delay, as a share of the step.
    pub from_prompt: f64,
}

/// Every delay model at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Where.
    pub point: Point,
    /// In the order of [`Fluid::ALL`].
    outcomes: [Outcome; Fluid::ALL.len()],
}

impl Cell {
    /// What one model did.
    #[must_use]
    pub fn of(&self, fluid: Fluid) -> &Outcome {
        &self.outcomes[fluid as usize]
    }
}

/// The whole range.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Places where the rotor moved under every model, in a fixed order.
    pub cells: Vec<Cell>,
    /// Runs simulated.
    pub runs: usize,
    /// Places where friction holds the rotor against the whole step; they decide nothing.
    pub held: usize,
}

/// Runs every delay model at every place.
///
/// # Errors
/// A value the law or the plant does not take.
pub fn scan(progress: &Progress) -> Result<Scan, Error> {
    let points = points();
    let cells: Vec<Option<Cell>> = points
        .par_iter()
        .map(|point| {
            let cell = cell(*point);
            progress.advance(1);
            cell
        })
        .collect::<Result<_, _>>()?;
    let held = cells.iter().filter(|cell| cell.is_none()).count();
    Ok(Scan { cells: cells.into_iter().flatten().collect(), runs: points.len() * Fluid::ALL.len(), held })
}

/// Number of places.
#[must_use]
pub fn size() -> usize {
    2 * SLOWNESSES.len() * GAINS_DELAYS_S.len() * STEPS_RAD.len()
}

fn points() -> Vec<Point> {
    let mut points = Vec::with_capacity(size());
    for speed in [Speed::True, Speed::Counts] {
        for slowness in SLOWNESSES {
            for gains_delay_s in GAINS_DELAYS_S {
                points.extend(STEPS_RAD.map(|step_rad| Point { gains_delay_s, step_rad, slowness, speed }));
            }
        }
    }
    points
}

fn cell(point: Point) -> Result<Option<Cell>, Error> {
    let prompt: Vec<f64> = positions(&point.case(Fluid::None))?.0;
    let mut outcomes = Vec::with_capacity(Fluid::ALL.len());
    for fluid in Fluid::ALL {
        let (positions, response) = positions(&point.case(fluid))?;
        let Some(response) = response else { return Ok(None) };
        let apart = positions.iter().zip(&prompt).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        outcomes.push(Outcome { response, from_prompt: apart / point.step_rad });
    }
    Ok(outcomes.try_into().ok().map(|outcomes| Cell { point, outcomes }))
}

fn positions(case: &Case) -> Result<(Vec<f64>, Option<Response>), Error> {
    let rows = case.run()?;
    let response = case.response(&rows);
    Ok((rows.iter().map(|row| row.truth.position).collect(), response))
}

impl Scan {
    /// The places with this speed and slowness.
    pub fn at(&self, speed: Speed, slowness: f64) -> impl Iterator<Item = &Cell> + Clone {
        self.cells.iter().filter(move |cell| cell.point.speed == speed && cell.point.slowness == slowness)
    }
}
