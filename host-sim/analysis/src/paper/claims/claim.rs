//! A claim with its verdict by one rule, and where in a range something is true.

use std::fmt::Write;

use recording::Error;

use crate::paper::case::{Fluid, Reading};
use crate::paper::scan::{Cell, GAINS_DELAYS_S, Law, Outcome, Point, SLOWNESSES, STEPS_RAD, Scan};
use crate::stability::LoopError;

/// Below this share of the places asked a claim holds "rarely"; at none it does not hold, at all it holds.
pub const RARELY: f64 = 0.1;

/// What a test says about a claim. One rule for all: the share of the places asked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// At every place asked.
    Holds,
    /// At some; at how many and which, in words.
    InPart(String),
    /// At less than [`RARELY`] of them.
    Rarely(String),
    /// At none.
    DoesNotHold(String),
    /// What is missing for a test.
    NotTestable(String),
}

impl Verdict {
    /// By the number of places at which a claim is true, and of those asked; `detail` says which, or why.
    pub(super) fn of(holds: usize, of: usize, detail: &str) -> Self {
        let share = holds as f64 / of.max(1) as f64;
        let semicolon = if detail.is_empty() { "" } else { "; " };
        let counted = || format!("at {holds} of {of} places ({:.0} %){semicolon}{detail}", 100.0 * share);
        match holds {
            0 => Self::DoesNotHold(format!("at none of {of} places{semicolon}{detail}")),
            _ if holds == of => Self::Holds,
            _ if share < RARELY => Self::Rarely(counted()),
            _ => Self::InPart(counted()),
        }
    }
}

/// One claim and its test.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Claim {
    /// Section or figure of the paper.
    pub section: &'static str,
    /// In the paper's words, shortened.
    pub statement: &'static str,
    /// How it was tested.
    pub test: &'static str,
    /// Over which range.
    pub range: String,
    /// What came out.
    pub figures: Vec<String>,
    /// What that says.
    pub verdict: Verdict,
}

/// A place of the scan in one reading of the viscosity's delay.
#[derive(Debug, Clone, Copy)]
pub(in crate::paper) struct View<'a> {
    /// The place.
    pub(in crate::paper) cell: &'a Cell,
    /// The reading.
    pub(in crate::paper) reading: Reading,
}

impl View<'_> {
    /// What a model did there.
    pub(super) fn of(&self, fluid: Fluid) -> &Outcome {
        self.cell.of(self.reading, fluid)
    }

    /// Where.
    pub(in crate::paper) fn point(&self) -> &Point {
        &self.cell.point
    }
}

/// Where in the scan something is true.
pub(super) struct Where {
    /// Places at which it is, and places asked, for each slowness of the plant.
    by_slowness: Vec<(usize, usize)>,
    /// With the plant as the gains assume: for each step the L at which it is not, s.
    fails: Vec<(f64, Vec<f64>)>,
}

impl Where {
    pub(super) fn of(scan: &Scan, law: Law, reading: Reading, holds: impl Fn(&View) -> bool) -> Self {
        let mut fails = STEPS_RAD.map(|step| (step, Vec::new())).to_vec();
        let by_slowness = SLOWNESSES.map(|slowness| {
            let (mut yes, mut of) = (0, 0);
            for cell in scan.at(law, slowness) {
                of += 1;
                if holds(&View { cell, reading }) {
                    yes += 1;
                } else if slowness == 1.0
                    && let Some((_, fails)) = fails.iter_mut().find(|(step, _)| *step == cell.point.step_rad)
                {
                    fails.push(cell.point.gains_delay_s);
                }
            }
            (yes, of)
        });
        Self { by_slowness: by_slowness.to_vec(), fails }
    }

    /// Places at which it is true, and places asked.
    pub(super) fn total(&self) -> (usize, usize) {
        self.by_slowness.iter().fold((0, 0), |(yes, of), one| (yes + one.0, of + one.1))
    }

    /// By the rule over all places, with `more` said where it does not hold everywhere.
    pub(super) fn verdict(&self, more: &str) -> Verdict {
        let (yes, of) = self.total();
        let mut detail = self.to_string();
        if self.by_slowness.first().is_some_and(|(yes, of)| *yes > 0 && yes < of) {
            detail.push_str("; plant as the gains assume: ");
            detail.push_str(&self.failures());
        }
        if !more.is_empty() {
            detail.push_str("; ");
            detail.push_str(more);
        }
        Verdict::of(yes, of, &detail)
    }

    /// Not at which steps and L, in words.
    fn failures(&self) -> String {
        let mut text = String::from("not for");
        for (step_rad, delays_s) in self.fails.iter().filter(|(_, delays)| !delays.is_empty()) {
            // Writing to a string cannot fail.
            let _ = write!(text, " {:.4} rad at L {} ms,", step_rad, ranges(delays_s));
        }
        text.pop();
        text
    }
}

/// `16 of 54, 20 of 56, 21 of 54 with the plant 1, 1.5, 2.2 times as slow`.
impl std::fmt::Display for Where {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts: Vec<String> = self.by_slowness.iter().map(|(yes, of)| format!("{yes} of {of}")).collect();
        let slownesses: Vec<String> = SLOWNESSES.iter().map(f64::to_string).collect();
        write!(f, "{} with the plant {} times as slow", counts.join(", "), slownesses.join(", "))
    }
}

/// Delays of the grid in ms, neighbours joined: `1.5 to 3, 8`.
fn ranges(delays_s: &[f64]) -> String {
    let index = |delay: &f64| GAINS_DELAYS_S.iter().position(|grid| grid == delay).unwrap_or_default();
    let runs = delays_s.chunk_by(|a, b| index(a) + 1 == index(b));
    let texts = runs.filter_map(|run| Some((run.first()?, run.last()?))).map(|(first, last)| {
        let (first, last) = (first * 1e3, last * 1e3);
        if first == last { format!("{first:.4}") } else { format!("{first:.4} to {last:.4}") }
    });
    let texts: Vec<String> = texts.map(|text| trim_zeros(&text)).collect();
    texts.join(" and ")
}

/// `5.0000` as `5`, in a text of such numbers.
pub(in crate::paper) fn trim_zeros(text: &str) -> String {
    let words = text.split(' ').map(|word| match word.contains('.') {
        true => word.trim_end_matches('0').trim_end_matches('.'),
        false => word,
    });
    words.collect::<Vec<_>>().join(" ")
}

/// A loop the analysis refuses, as an error of the tool.
pub(super) fn refused(error: LoopError) -> Error {
    Error::Usage(error.to_string())
}

/// The range of section VI in short; [`crate::paper::table::preamble`] has it in full.
pub(super) fn scanned(places: usize) -> String {
    format!("L 1.5 to 10 ms times steps of 5.5 mrad to 1 rad times plants 1, 1.5, 2.2 times as slow: {places} places")
}
