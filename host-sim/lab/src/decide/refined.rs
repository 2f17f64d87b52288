//! Values and intervals of the answer: those of the time domain where it holds, of the weak form elsewhere.

use super::Covariance;
use crate::read::Recording;
use crate::refit::TimeFit;
use crate::screen::{Active, Fit, Problem};

/// Share of windows far beyond the noise with which the time domain is no better witness than the weak form.
const FAR: f64 = 0.3;

/// The effects of the answer with the values that are reported.
#[derive(Debug, Clone)]
pub struct Refined {
    /// Effects and values.
    pub active: Vec<Active>,
    /// Of the free values.
    pub covariance: Covariance,
    /// The fit in the time domain, where it is the one that is reported.
    pub time: Option<TimeFit>,
}

impl Refined {
    /// Refits what a search found. `inflation` is how many neighbouring equations of the weak form count as one,
    /// `resolution` the smallest step of the position, rad (m).
    pub fn new(
        problem: &Problem,
        recordings: &[Recording],
        fit: &Fit,
        inflation: f64,
        resolution: f64,
        warnings: &mut Vec<String>,
    ) -> Self {
        let weak = || Self {
            active: fit.active.clone(),
            covariance: Covariance::new(problem, fit, inflation),
            time: None,
        };
        if fit.active.is_empty() {
            return weak();
        }
        let begun = std::time::Instant::now();
        let r = TimeFit::new(problem, recordings, &fit.active, resolution);
        if let Ok(t) = &r {
            let c = Covariance::of_time(t);
            let w = Covariance::new(problem, fit, inflation);
            eprintln!("TD {:.2} s sse {:.1} start {:.1} freedom {} far {:.3} heldout {:.1}", begun.elapsed().as_secs_f64(), t.sse, t.start_sse, t.freedom, t.far, t.heldout.iter().sum::<f64>());
            for i in 0..t.active.len() {
                eprintln!("   {:?} TD {:?} weak {:?}", t.active[i].effect, super::intervals(&t.active, &c, i), super::intervals(&fit.active, &w, i));
            }
        }
        match r {
            Ok(time) if time.far <= FAR && time.sse <= time.start_sse => {
                Self { active: time.active.clone(), covariance: Covariance::of_time(&time), time: Some(time) }
            }
            Ok(time) => {
                warnings.push(format!(
                    "values and intervals are those of the weak form: simulated, {:.0} % of the windows are far from the \
                     recording even with the best values",
                    100.0 * time.far
                ));
                weak()
            }
            Err(error) => {
                warnings.push(format!("values and intervals are those of the weak form: {error}"));
                weak()
            }
        }
    }
}
