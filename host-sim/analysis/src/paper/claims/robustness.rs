//! Section VII: "it did not result in a destabilized state if the variations were within several dozen percent".

use rayon::prelude::*;

use super::claim::{Claim, Verdict, refused};
use super::region::{DEAD, DELAYS_S, LAG, PEAK_NM_S_RAD, closed};
use crate::paper::case::DELAY_S;
use crate::stability::limits::{Quantity, tolerances};
use crate::stability::{Fluid, Loop, LoopError, curves};
use recording::Error;

/// "Several dozen percent": what every quantity must bear alone, up and down.
pub(super) const DOZENS: [f64; 3] = [0.24, 0.36, 0.5];
/// Q1 of the range: least of (5), the figure's, the peak.
const VISCOSITIES: [f64; 5] = [0.158, 5.0, 10.0, 20.0, PEAK_NM_S_RAD];

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    Ok(vec![tolerant().map_err(refused)?, most_sensitive().map_err(refused)?])
}

fn cases() -> Vec<(f64, f64, Fluid)> {
    let mut cases = Vec::new();
    for delay_s in DELAYS_S {
        for q1 in VISCOSITIES {
            cases.extend([DEAD, LAG].map(|fluid| (delay_s, q1, fluid)));
        }
    }
    cases
}

/// Whether the loop stays stable with each quantity alone off by `part`, up and down.
pub(super) fn alone(closed: &Loop, part: f64) -> bool {
    let found = tolerances(closed);
    !found.is_empty()
        && found.iter().all(|tolerance| {
            let up = tolerance.upper.is_none_or(|limit| limit.factor > 1.0 + part);
            up && tolerance.lower.is_none_or(|limit| limit.factor < 1.0 - part)
        })
}

/// Whether it stays stable with all of them off by `part` together, in the worst of the corners.
fn together(nominal: &Loop, part: f64) -> Result<bool, LoopError> {
    let quantities =
        [Quantity::TorqueDelay, Quantity::FluidDelay, Quantity::BothGains, Quantity::Inertia, Quantity::Q1];
    for corner in 0..1_u32 << quantities.len() {
        let mut moved = *nominal;
        for (bit, quantity) in quantities.iter().enumerate() {
            let factor = if corner >> bit & 1 == 1 { 1.0 + part } else { 1.0 - part };
            moved = quantity.set(&moved, quantity.of(&moved) * factor)?;
        }
        if !curves::is_inside(&moved) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The cases, and whether each stays stable with quantities off by each of [`DOZENS`]: alone, then together.
struct Judged(Vec<((f64, f64, Fluid), [bool; 6])>);

impl Judged {
    fn new() -> Result<Self, LoopError> {
        let judge = |(delay_s, q1, fluid)| {
            let closed = closed(delay_s, 0.2, q1, fluid)?;
            let [a, b, c] = DOZENS;
            let joint = |part| together(&closed, part);
            let verdicts = [alone(&closed, a), alone(&closed, b), alone(&closed, c), joint(a)?, joint(b)?, joint(c)?];
            Ok(((delay_s, q1, fluid), verdicts))
        };
        cases().into_par_iter().map(judge).collect::<Result<_, LoopError>>().map(Self)
    }

    /// Of the cases chosen, how many stay stable, and how many there are.
    fn count(&self, column: usize, chosen: impl Fn(f64, Fluid) -> bool) -> (usize, usize) {
        let rows = self.0.iter().filter(|((_, q1, fluid), _)| chosen(*q1, *fluid));
        (rows.clone().filter(|(_, verdict)| verdict[column]).count(), rows.count())
    }

    fn in_words(&self, column: usize) -> String {
        let text = |(holds, of): (usize, usize)| format!("{holds} of {of}");
        let [at_ten, at_peak] = [10.0, PEAK_NM_S_RAD].map(|at| text(self.count(column, |q1, _| q1 == at)));
        let all = text(self.count(column, |_, _| true));
        format!("{all} places ({at_ten} at Q1 10, {at_peak} at Q1 {PEAK_NM_S_RAD})")
    }

    fn verdict(&self) -> Verdict {
        let column = 1;
        let (holds, of) = self.count(column, |_, _| true);
        let (lag, lags) = self.count(column, |_, fluid| fluid == LAG);
        let (dead, deads) = self.count(column, |_, fluid| fluid == DEAD);
        Verdict::of(
            holds,
            of,
            &format!("+-36 % one at a time: {lag} of {lags} with a lag, {dead} of {deads} with a dead time"),
        )
    }
}

fn tolerant() -> Result<Claim, LoopError> {
    let judged = Judged::new()?;
    let mut figures = Vec::new();
    for (k, part) in DOZENS.iter().enumerate() {
        let percent = 100.0 * part;
        figures.push(format!("+-{percent:.0} %, one at a time: stable at {}", judged.in_words(k)));
        figures.push(format!("+-{percent:.0} %, all together: stable at {}", judged.in_words(k + DOZENS.len())));
    }
    for (name, fluid) in [("dead time", DEAD), ("lag", LAG)] {
        let limits = limits(&closed(DELAY_S, 0.2, 10.0, fluid)?);
        figures.push(format!("L 5 ms, Q1 10, {name} 5 ms, limits alone: {limits}"));
    }
    Ok(Claim {
        section: "VII",
        statement: "Variations of the model within several dozen percent do not destabilise the loop",
        test: "tolerance of L, L_Q or T_Q, K_P, K_D, both gains, J and Q1 alone, and corners of L, L_Q or T_Q, gains, J, Q1 \
               together; Q0 0.2",
        range: "L 1 to 10 ms times Q1 0.158, 5, 10, 20, 55 times dead time 5 and lag 5 ms; +-24, 36, 50 %".to_owned(),
        figures,
        verdict: judged.verdict(),
    })
}

/// Limits of each quantity alone, as factors.
fn limits(closed: &Loop) -> String {
    let texts = tolerances(closed).into_iter().map(|tolerance| {
        let lower = tolerance.lower.map_or("any less".to_owned(), |limit| format!("{:.2}", limit.factor));
        let upper = tolerance.upper.map_or("any more".to_owned(), |limit| format!("{:.2}", limit.factor));
        format!("{} {lower} to {upper}", symbol(tolerance.quantity))
    });
    texts.collect::<Vec<_>>().join(", ")
}

fn symbol(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::TorqueDelay => "L",
        Quantity::FluidDelay => "L_Q or T_Q",
        Quantity::Kp => "K_P",
        Quantity::Kd => "K_D",
        Quantity::BothGains => "both gains",
        Quantity::Inertia => "J",
        Quantity::Q1 => "Q1",
    }
}

/// The quantity that loses the loop by the smallest factor; none for a loop that is lost already.
pub(super) fn nearest(closed: &Loop) -> Option<Quantity> {
    let distances = tolerances(closed).into_iter().filter_map(|tolerance| {
        let sides = [tolerance.lower, tolerance.upper].into_iter().flatten();
        let near = sides.map(|limit| limit.factor.ln().abs()).min_by(f64::total_cmp)?;
        Some((tolerance.quantity, near))
    });
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(quantity, _)| quantity)
}

fn most_sensitive() -> Result<Claim, LoopError> {
    let mut found: Vec<(&str, usize)> = Vec::new();
    let mut of = 0;
    for (delay_s, q1, fluid) in cases() {
        let Some(quantity) = nearest(&closed(delay_s, 0.2, q1, fluid)?) else { continue };
        of += 1;
        match found.iter_mut().find(|(name, _)| *name == symbol(quantity)) {
            Some((_, count)) => *count += 1,
            None => found.push((symbol(quantity), 1)),
        }
    }
    let fluid_delay = found.iter().find(|(name, _)| *name == "L_Q or T_Q").map_or(0, |(_, count)| *count);
    found.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let figures = found.iter().map(|(name, count)| format!("{name} is lost first at {count} of {of} stable places"));
    let verdict = Verdict::of(fluid_delay, of, "places at which L_Q or T_Q is nearest to its limit");
    Ok(Claim {
        section: "VII",
        statement: "The loop is greatly affected by variation of the model, especially the lag time or time constant",
        test: "which quantity is nearest to its limit, as a factor",
        range: "as above, where the loop is stable".to_owned(),
        figures: figures.collect(),
        verdict,
    })
}
