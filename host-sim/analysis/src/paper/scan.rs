//! The range over which the claims of section VI are tested: delay of the motor system, step, how much slower the plant
//! is than its gains assume, source of the speed, whether the brake holds at rest, times every delay model, those of the
//! viscosity in both readings.

use rayon::prelude::*;

use super::case::{Case, Fluid, Reading, Response, STEP_RAD, Speed};
use crate::simulate::Row;
use progress::Progress;
use recording::Error;

/// L that scales the gains, s.
pub const GAINS_DELAYS_S: [f64; 8] = [0.0015, 0.002, 0.003, 0.004, 0.005, 0.006, 0.008, 0.01];
/// Steps, rad.
pub const STEPS_RAD: [f64; 7] = [0.0055, 0.02, 0.05, 0.1, 0.2, STEP_RAD, 1.0];
/// Delay of the plant over the L of the gains, 1; 2.2 is control.md's 4.4 ms for gains of 2 ms.
pub const SLOWNESSES: [f64; 3] = [1.0, 1.5, 2.2];
/// Runs at one place: every model, and those of the viscosity a second time as printed.
pub const RUNS_A_PLACE: usize = Fluid::ALL.len() + VISCOUS.len();

/// The models whose two readings differ.
const VISCOUS: [Fluid; 3] = [Fluid::QDead5, Fluid::QDead50, Fluid::QLag5];

/// How the law runs: source of its speed, brake at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Law {
    /// Speed the law uses.
    pub speed: Speed,
    /// The brake also holds at rest.
    pub hold: bool,
}

impl Law {
    /// The paper's equations: true speed, brake only while moving away. Verdicts are of this.
    pub const PAPER: Self = Self { speed: Speed::True, hold: false };
    /// The paper's with a brake that also holds at rest, which it leaves open.
    pub const HOLDING: Self = Self { speed: Speed::True, hold: true };
    /// As flashed.
    pub const FLASHED: Self = Self { speed: Speed::Counts, hold: false };
    /// All that are scanned.
    pub const ALL: [Self; 3] = [Self::PAPER, Self::HOLDING, Self::FLASHED];

    /// In figures of claims.
    #[must_use]
    pub fn name(self) -> &'static str {
        match (self.speed, self.hold) {
            (Speed::True, false) => "true speed",
            (Speed::True, true) => "brake holding at rest",
            (Speed::Counts, _) => "speed from counts",
        }
    }
}

/// One place of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// L that scales the gains, s.
    pub gains_delay_s: f64,
    /// Height of the step, rad.
    pub step_rad: f64,
    /// Delay of the plant over `gains_delay_s`, 1.
    pub slowness: f64,
    /// How the law runs.
    pub law: Law,
}

impl Point {
    /// The experiment at this place.
    #[must_use]
    pub fn case(&self, fluid: Fluid, reading: Reading) -> Case {
        Case {
            fluid,
            reading,
            gains_delay_s: self.gains_delay_s,
            plant_delay_s: self.gains_delay_s * self.slowness,
            step_rad: self.step_rad,
            speed: self.law.speed,
            hold: self.law.hold,
            ..Case::PAPER
        }
    }
}

/// What a delay model did at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Its figures.
    pub response: Response,
    /// Position at the end, rad.
    pub rest_rad: f64,
    /// Half from peak to peak over the last fifth of the run, rad.
    pub swing_rad: f64,
    /// Largest distance from the run without delay, as a share of the step.
    pub from_prompt: f64,
    /// Largest distance from the run with E dead 2 + lag 3 ms, as a share of the step.
    pub from_both: f64,
    /// Share of the damper's commanded torque that acts while the rotor arrives, 1; none where none is commanded.
    pub arrival: Option<f64>,
}

/// How far delay models (but Q dead 50 ms, which differs whatever the friction) are apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// Spread of the rest positions, rad.
    pub rest_rad: f64,
    /// Most dips of the speed.
    pub dips: usize,
}

/// Every delay model at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Where.
    pub point: Point,
    /// The models apart without dry friction, in the order of [`Reading::ALL`]; none where it was not run, with the law as flashed or holding.
    pub frictionless: Option<[Apart; Reading::ALL.len()]>,
    /// In the order of [`Fluid::ALL`].
    outcomes: [Outcome; Fluid::ALL.len()],
    /// In the order of [`VISCOUS`].
    as_printed: [Outcome; VISCOUS.len()],
}

impl Cell {
    /// What one model did in a reading.
    #[must_use]
    pub fn of(&self, reading: Reading, fluid: Fluid) -> &Outcome {
        let viscous = VISCOUS.iter().position(|of| *of == fluid).filter(|_| reading == Reading::AsPrinted);
        viscous.map_or(&self.outcomes[fluid as usize], |index| &self.as_printed[index])
    }

    /// The models apart without dry friction; none where it was not run.
    #[must_use]
    pub fn apart_without_friction(&self, reading: Reading) -> Option<Apart> {
        self.frictionless.map(|apart| apart[reading as usize])
    }

    /// The models apart with the dry friction of the machine.
    #[must_use]
    pub fn apart(&self, reading: Reading) -> Apart {
        let models = Fluid::ALL.into_iter().filter(|fluid| *fluid != Fluid::QDead50);
        apart(models.map(|fluid| self.of(reading, fluid)).map(|outcome| (outcome.rest_rad, outcome.response.dips)))
    }
}

fn apart(models: impl Iterator<Item = (f64, usize)>) -> Apart {
    let (mut low, mut high, mut dips) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for (rest_rad, of_one) in models {
        (low, high, dips) = (rest_rad.min(low), rest_rad.max(high), dips.max(of_one));
    }
    Apart { rest_rad: high - low, dips }
}

/// The whole range.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Places where the rotor moved under every model, in a fixed order.
    pub cells: Vec<Cell>,
    /// Runs at the places where the rotor moved.
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
    let cells: Vec<Cell> = cells.into_iter().flatten().collect();
    let frictionless = cells.iter().filter(|cell| cell.frictionless.is_some()).count();
    // But for Q dead 50 ms, in either reading.
    let runs = cells.len() * RUNS_A_PLACE + frictionless * (RUNS_A_PLACE - 2);
    Ok(Scan { cells, runs, held })
}

/// Number of places.
#[must_use]
pub fn size() -> usize {
    Law::ALL.len() * SLOWNESSES.len() * GAINS_DELAYS_S.len() * STEPS_RAD.len()
}

fn points() -> Vec<Point> {
    let mut points = Vec::with_capacity(size());
    for law in Law::ALL {
        for slowness in SLOWNESSES {
            for gains_delay_s in GAINS_DELAYS_S {
                points.extend(STEPS_RAD.map(|step_rad| Point { gains_delay_s, step_rad, slowness, law }));
            }
        }
    }
    points
}

/// Runs every model at one place; none where friction holds the rotor against the whole step under any.
///
/// # Errors
/// A value the law or the plant does not take.
pub fn cell(point: Point) -> Result<Option<Cell>, Error> {
    let prompt = point.case(Fluid::None, Reading::AsAFluid).run()?;
    let both = point.case(Fluid::EDead2Lag3, Reading::AsAFluid).run()?;
    let outcome = |fluid, reading| {
        let case = point.case(fluid, reading);
        let rows = case.run()?;
        Ok::<_, Error>(Outcome::of(&case, &rows, &prompt, &both))
    };
    let mut outcomes = Vec::with_capacity(Fluid::ALL.len());
    for fluid in Fluid::ALL {
        let Some(found) = outcome(fluid, Reading::AsAFluid)? else { return Ok(None) };
        outcomes.push(found);
    }
    let mut as_printed = Vec::with_capacity(VISCOUS.len());
    for fluid in VISCOUS {
        let Some(found) = outcome(fluid, Reading::AsPrinted)? else { return Ok(None) };
        as_printed.push(found);
    }
    let frictionless = if point.law == Law::PAPER { Some(without_friction(point)?) } else { None };
    let (Ok(outcomes), Ok(as_printed)) = (outcomes.try_into(), as_printed.try_into()) else { return Ok(None) };
    Ok(Some(Cell { point, frictionless, outcomes, as_printed }))
}

fn without_friction(point: Point) -> Result<[Apart; Reading::ALL.len()], Error> {
    let outcome = |fluid, reading| {
        let case = Case { coulomb_nm: 0.0, ..point.case(fluid, reading) };
        let rows = case.run()?;
        let rest_rad = rows.last().map_or(0.0, |row| row.truth.position);
        Ok::<_, Error>((rest_rad, case.response(&rows).map_or(0, |response| response.dips)))
    };
    let mut models = Vec::new();
    for fluid in Fluid::ALL.into_iter().filter(|fluid| *fluid != Fluid::QDead50) {
        let bounded = outcome(fluid, Reading::AsAFluid)?;
        let printed = if VISCOUS.contains(&fluid) { outcome(fluid, Reading::AsPrinted)? } else { bounded };
        models.push([bounded, printed]);
    }
    Ok(Reading::ALL.map(|reading| apart(models.iter().map(|model| model[reading as usize]))))
}

impl Outcome {
    /// None where friction holds the rotor where it is.
    fn of(case: &Case, rows: &[Row], prompt: &[Row], both: &[Row]) -> Option<Self> {
        let position = |row: &Row| row.truth.position;
        let furthest = |other: &[Row]| {
            let apart = rows.iter().zip(other).map(|(x, y)| (position(x) - position(y)).abs());
            apart.fold(0.0, f64::max) / case.step_rad
        };
        let late = rows[rows.len() - rows.len() / 5..].iter().map(position);
        let (low, high) = late.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        Some(Self {
            response: case.response(rows)?,
            rest_rad: rows.last().map(position)?,
            swing_rad: 0.5 * (high - low),
            from_prompt: furthest(prompt),
            from_both: furthest(both),
            arrival: share_on_arrival(rows),
        })
    }
}

/// Share of the commanded torque of the damper that acts while the rotor arrives: from the last time it is faster than
/// 1.5 rad/s, or from the start, to the largest command.
fn share_on_arrival(rows: &[Row]) -> Option<f64> {
    let start = rows.iter().rposition(|row| row.truth.velocity.abs() > 1.5).map_or(0, |last| last + 1);
    let arrival = rows.get(start..)?;
    let command_nm = |row: &Row| super::claims::torque_nm(f64::from(row.outputs.field_kv_mm));
    let (last, _) = arrival.iter().enumerate().max_by(|a, b| command_nm(a.1).total_cmp(&command_nm(b.1)))?;
    let until = arrival.get(..=last)?;
    let commanded: f64 = until.iter().map(command_nm).sum();
    // The torque in a row is that before the row's command acts: the command of the row before.
    let acted: f64 = arrival.iter().skip(1).take(until.len()).map(|row| row.er_torque_nm).sum();
    (commanded > 0.0).then_some(acted / commanded)
}

impl Scan {
    /// The places with this law and slowness.
    pub fn at(&self, law: Law, slowness: f64) -> impl Iterator<Item = &Cell> + Clone {
        self.cells.iter().filter(move |cell| cell.point.law == law && cell.point.slowness == slowness)
    }
}
