//! A claim with its verdict, and where in a range something is true.

use std::fmt::Write;

use recording::Error;

use crate::paper::scan::{Cell, GAINS_DELAYS_S, STEPS_RAD};
use crate::stability::LoopError;

/// What a test says about a claim.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Over the whole range.
    Holds,
    /// Over part of the range, in words.
    HoldsOnly(String),
    /// Nowhere, or not for the reason given; in words.
    DoesNotHold(String),
    /// What is missing for a test.
    NotTestable(String),
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

/// Where in a range something is true.
pub(super) struct Where {
    /// Places at which it is.
    pub(super) holds: usize,
    /// Places asked.
    pub(super) of: usize,
    /// For each step of the range, the L at which it is not, s.
    fails: Vec<(f64, Vec<f64>)>,
}

impl Where {
    pub(super) fn of<'a>(cells: impl Iterator<Item = &'a Cell>, holds: impl Fn(&Cell) -> bool) -> Self {
        let mut found = Self { holds: 0, of: 0, fails: STEPS_RAD.map(|step| (step, Vec::new())).to_vec() };
        for cell in cells {
            found.of += 1;
            if holds(cell) {
                found.holds += 1;
            } else if let Some((_, fails)) = found.fails.iter_mut().find(|(step, _)| *step == cell.point.step_rad) {
                fails.push(cell.point.gains_delay_s);
            }
        }
        found
    }

    pub(super) fn verdict(&self) -> Verdict {
        match self.holds {
            0 => Verdict::DoesNotHold("at no place of the range".to_owned()),
            holds if holds == self.of => Verdict::Holds,
            holds => Verdict::HoldsOnly(format!("at {holds} of {} places; {}", self.of, self.failures())),
        }
    }

    /// Not at which steps and L, in words.
    pub(super) fn failures(&self) -> String {
        let mut text = String::from("not for");
        for (step_rad, delays_s) in self.fails.iter().filter(|(_, delays)| !delays.is_empty()) {
            // Writing to a string cannot fail.
            let _ = write!(text, " {:.4} rad at L {} ms;", step_rad, ranges(delays_s));
        }
        text.pop();
        text
    }
}

/// `part of whole`, in places.
impl std::fmt::Display for Where {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of {}", self.holds, self.of)
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
    texts.join(", ")
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
    format!("L 1.5 to 10 ms times steps of 5.5 mrad to 1 rad, plant as the gains assume: {places} places")
}
