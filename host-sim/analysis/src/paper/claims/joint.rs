//! Is there one machine on which all claims of sections VI and VII hold? Every place of the scan with the true speed, both
//! brakes and both readings, times Q1 for the claims on the linear loop; then from the best places on in finer steps.

use std::collections::HashMap;

use rayon::prelude::*;

use super::claim::{Claim, Verdict, View, refused, trim_zeros};
use super::delays::{FURTHEST, TESTS, Test};
use super::region::{DEAD, LAG, plant};
use super::robustness::{DOZENS, alone, nearest};
use crate::paper::case::{Fluid as Model, INERTIA_KG_M2, Reading, Speed};
use crate::paper::scan::{Cell, Law, Point, SLOWNESSES, Scan, cell};
use crate::stability::limits::Quantity;
use crate::stability::region::{Window, stable_region};
use crate::stability::{Fluid, Loop, LoopError, NormalisedGains, curves};
use recording::Error;

/// Q1 of the linear loop, N m s/rad: the figure's, half and twice of it, the peak of (5).
const VISCOSITIES_NM_S_RAD: [f64; 4] = [5.0, 10.0, 20.0, 55.147];
/// Claims on the linear loop, in the order of [`linear`].
const LINEAR: [&str; 4] = [
    "the regions get smaller (V, VII)",
    "the gains are inside (V, VII)",
    "36 % alone does not destabilise (VII)",
    "L_Q or T_Q matters most (VII)",
];
/// Best places from which the search goes on, and how often.
const STARTS: usize = 4;
const ROUNDS: usize = 3;
/// Factor of its steps in L, slowness and height of the step.
const RATIO: f64 = 1.2;

/// The tests of one place of the scan: those of section VI, the furthest model, rest under every model.
fn tests() -> Vec<Test> {
    let at_rest = Test {
        section: "VII",
        statement: "no model is left swinging",
        test: "",
        show: &[],
        holds: |view| {
            let friction_error_rad = view.point().case(Model::None, view.reading).friction_error_rad();
            Model::ALL.into_iter().all(|model| view.of(model).swing_rad < 0.1 * friction_error_rad)
        },
    };
    TESTS.into_iter().chain([FURTHEST, at_rest]).collect()
}

/// The claims on the linear loop at a plant, gains and Q1.
fn linear(point: &Point, q1: f64) -> Result<[bool; LINEAR.len()], LoopError> {
    let plant_delay_s = point.gains_delay_s * point.slowness;
    let gains = NormalisedGains::PAPER.physical(INERTIA_KG_M2, point.gains_delay_s);
    let closed = |fluid| Loop::new(plant(plant_delay_s, 0.2, q1, fluid), gains);
    let area =
        |fluid| Ok::<_, LoopError>(stable_region(&plant(plant_delay_s, 0.2, q1, fluid), Window::SPECIFIED)?.area());
    let none = area(Fluid::None)?;
    let delayed = [closed(DEAD)?, closed(LAG)?];
    Ok([
        area(DEAD)? < none && area(LAG)? < none,
        delayed.iter().all(curves::is_inside),
        delayed.iter().all(|closed| alone(closed, DOZENS[1])),
        delayed.iter().any(|closed| nearest(closed) == Some(Quantity::FluidDelay)),
    ])
}

/// Every claim at one machine.
#[derive(Clone)]
pub(in crate::paper) struct Machine {
    /// Where.
    pub(in crate::paper) point: Point,
    /// How the viscosity's delay is read.
    pub(in crate::paper) reading: Reading,
    /// Of the linear loop, N m s/rad.
    pub(in crate::paper) q1: f64,
    /// In the order of [`names`].
    holds: Vec<bool>,
}

impl Machine {
    /// How many claims hold.
    pub(in crate::paper) fn count(&self) -> usize {
        self.holds.iter().filter(|holds| **holds).count()
    }

    fn in_words(&self) -> String {
        let Point { gains_delay_s, step_rad, slowness, law } = self.point;
        let place = trim_zeros(&format!(
            "gains for {:.3} ms, plant {slowness:.3} times as slow, step {:.3} mrad",
            gains_delay_s * 1e3,
            step_rad * 1e3
        ));
        let brake = if law.hold { "holding" } else { "strict" };
        format!("{place}, {brake} brake, Q1 {}, {}", self.q1, self.reading.name())
    }
}

/// The claims by name.
fn names() -> Vec<String> {
    let nonlinear = tests().into_iter().map(|test| format!("{} ({})", test.statement, test.section));
    nonlinear.chain(LINEAR.map(str::to_owned)).collect()
}

/// The linear claims known so far: they depend on L, slowness and Q1 alone.
type Known = HashMap<(u64, u64), Vec<(f64, [bool; LINEAR.len()])>>;

fn key(point: &Point) -> (u64, u64) {
    (point.gains_delay_s.to_bits(), point.slowness.to_bits())
}

fn linear_claims(points: &[Point]) -> Result<Known, Error> {
    let mut unique: Vec<Point> = Vec::new();
    for point in points {
        if unique.iter().all(|other| key(other) != key(point)) {
            unique.push(*point);
        }
    }
    let known = unique.par_iter().map(|point| {
        let of = |q1: f64| Ok((q1, linear(point, q1)?));
        let all = VISCOSITIES_NM_S_RAD.into_iter().map(of).collect::<Result<Vec<_>, LoopError>>();
        Ok((key(point), all.map_err(refused)?))
    });
    known.collect()
}

/// A place as machines, one for each reading and Q1.
fn machines(cell: &Cell, known: &Known) -> Vec<Machine> {
    let tests = tests();
    let mut machines = Vec::new();
    for reading in Reading::ALL {
        let view = View { cell, reading };
        let nonlinear: Vec<bool> = tests.iter().map(|test| (test.holds)(&view)).collect();
        for (q1, linear) in known.get(&key(&cell.point)).into_iter().flatten() {
            let holds = nonlinear.iter().chain(linear).copied().collect();
            machines.push(Machine { point: cell.point, reading, q1: *q1, holds });
        }
    }
    machines
}

/// What the search found.
pub(in crate::paper) struct Joint {
    /// Every machine of the grid.
    pub(in crate::paper) grid: Vec<Machine>,
    /// The best after the finer search.
    best: Machine,
    /// Machines asked on the way there.
    finer: usize,
}

/// Asks every machine, then goes on from the best ones.
///
/// # Errors
/// A value the law, the plant or the stability analysis does not take.
pub(in crate::paper) fn search(scan: &Scan) -> Result<Option<Joint>, Error> {
    let cells = || scan.cells.iter().filter(|cell| cell.point.law.speed == Speed::True);
    let known = linear_claims(&cells().map(|cell| cell.point).collect::<Vec<_>>())?;
    let mut grid = Vec::new();
    for cell in cells() {
        // Without friction a holding brake was not run; its place takes the strict one's.
        let twin = Point { law: Law::PAPER, ..cell.point };
        let strict = cells().find(|other| other.point == twin).and_then(|other| other.frictionless);
        let mut whole = cell.clone();
        whole.frictionless = strict;
        grid.extend(machines(&whole, &known));
    }
    let mut starts: Vec<&Machine> = Vec::new();
    let mut ranked: Vec<&Machine> = grid.iter().collect();
    ranked.sort_by_key(|machine| std::cmp::Reverse(machine.count()));
    for machine in ranked {
        if starts.len() < STARTS && starts.iter().all(|other| other.point != machine.point) {
            starts.push(machine);
        }
    }
    let climbed = starts.into_par_iter().map(climb).collect::<Result<Vec<_>, Error>>()?;
    let finer = climbed.iter().map(|(_, asked)| asked).sum();
    let best = climbed.into_iter().map(|(machine, _)| machine).max_by_key(Machine::count);
    Ok(best.map(|best| Joint { grid, best, finer }))
}

/// To the best neighbour, as long as it is better.
fn climb(start: &Machine) -> Result<(Machine, usize), Error> {
    let (mut here, mut asked) = (start.clone(), 0);
    for _ in 0..ROUNDS {
        let point = here.point;
        let mut neighbours = Vec::new();
        for ratio in [RATIO, RATIO.recip()] {
            neighbours.push(Point { gains_delay_s: point.gains_delay_s * ratio, ..point });
            neighbours.push(Point { slowness: point.slowness * ratio, ..point });
            neighbours.push(Point { step_rad: point.step_rad * ratio, ..point });
        }
        let known = linear_claims(&neighbours)?;
        let mut better = here.clone();
        for neighbour in neighbours {
            let Some(mut found) = cell(neighbour)? else { continue };
            if found.frictionless.is_none() {
                found.frictionless =
                    cell(Point { law: Law::PAPER, ..neighbour })?.and_then(|strict| strict.frictionless);
            }
            let candidates = machines(&found, &known);
            asked += candidates.len();
            if let Some(candidate) = candidates.into_iter().max_by_key(Machine::count)
                && candidate.count() > better.count()
            {
                better = candidate;
            }
        }
        if better.count() == here.count() {
            break;
        }
        here = better;
    }
    Ok((here, asked))
}

/// Pairs of claims that both hold somewhere and never together.
fn exclusive(grid: &[Machine], names: &[String]) -> Vec<String> {
    let together = |i: usize, k: usize| grid.iter().any(|machine| machine.holds[i] && machine.holds[k]);
    let mut pairs = Vec::new();
    for (i, one) in names.iter().enumerate() {
        for (k, other) in names.iter().enumerate().skip(i + 1) {
            if together(i, i) && together(k, k) && !together(i, k) {
                pairs.push(format!("never together: \"{one}\" and \"{other}\""));
            }
        }
    }
    pairs
}

pub(super) fn claims(joint: Option<&Joint>) -> Vec<Claim> {
    let Some(joint) = joint else { return Vec::new() };
    let names = names();
    let of = names.len();
    let all = joint.grid.iter().filter(|machine| machine.count() == of).count();
    let failing = |machine: &Machine| {
        let failed = names.iter().zip(&machine.holds).filter(|(_, holds)| !**holds).map(|(name, _)| name.as_str());
        failed.collect::<Vec<_>>().join("; ")
    };
    let mut figures = Vec::new();
    for reading in Reading::ALL {
        for hold in [false, true] {
            for slowness in SLOWNESSES {
                let here = joint.grid.iter().filter(|machine| {
                    let point = machine.point;
                    machine.reading == reading && point.law.hold == hold && point.slowness == slowness
                });
                if let Some(best) = here.max_by_key(|machine| machine.count()) {
                    figures.push(format!("at most {} of {of}: {}", best.count(), best.in_words()));
                }
            }
        }
    }
    let best = &joint.best;
    let (most, place) = (best.count(), best.in_words());
    figures.push(format!("in finer steps from the best ({} machines more): {most} of {of}, {place}", joint.finer));
    figures.push(format!("there fail: {}", failing(best)));
    for (index, name) in names.iter().enumerate() {
        let holds = joint.grid.iter().filter(|machine| machine.holds[index]).count();
        figures.push(format!("at {holds} of {} machines: {name}", joint.grid.len()));
    }
    figures.extend(exclusive(&joint.grid, &names));
    vec![Claim {
        section: "VI, VII",
        statement: "All claims of sections VI and VII that can be tested hold on one machine",
        test: "each claim of section VI as above, and of VII, at each machine; steps of 20 % from the four best on",
        range: format!(
            "L 1.5 to 10 ms, plants 1, 1.5, 2.2 times as slow, steps of 5.5 mrad to 1 rad, strict and holding brake, Q1 5, 10, \
             20, 55, both readings: {} machines",
            joint.grid.len()
        ),
        figures,
        verdict: Verdict::of(all, joint.grid.len(), &format!("at most {most} of {of} hold together: {place}")),
    }]
}
