//! Motion of the rotor under what acts on it.

mod events;
mod exact;
mod phi;
mod state;

use crate::{Error, Model, Segment, Timeline};
use exact::Exact;
pub use state::{Motion, State};

/// The moving part of a model, ready to run over any [`Timeline`] built from the same model.
#[derive(Debug, Clone)]
pub struct Mechanics {
    path: Path,
}

/// How the motion is integrated.
#[derive(Debug, Clone)]
enum Path {
    Exact(Exact),
}

impl Mechanics {
    /// Prepares a model.
    ///
    /// # Errors
    /// [`Error::Parameter`] where the model does not hold water.
    pub fn new(model: &Model) -> Result<Self, Error> {
        model.validate()?;
        Ok(Self { path: Path::Exact(Exact::new(model)) })
    }

    /// Moves `state` through `segment` from `from_s` to `to_s`, absolute times within it.
    #[inline]
    pub(crate) fn run(&self, segment: &Segment, from_s: f64, to_s: f64, state: &mut State) {
        let (from_s, to_s) = (from_s - segment.start_s, to_s - segment.start_s);
        match &self.path {
            Path::Exact(flow) => events::run(flow, segment, from_s, to_s, state),
        }
    }

    /// Runs from `state` at `start_s` and writes the position at each of `sample_times_s` to `positions`, rad (m);
    /// returns the state at the last sample. Delays and lags of the commands are warm, they live in the timeline.
    ///
    /// Sample times must not run back nor lie before `start_s`. Nothing is allocated.
    ///
    /// # Errors
    /// [`Error::Length`] where the slices differ, [`Error::Time`] where time runs back.
    pub fn simulate(
        &self,
        timeline: &Timeline,
        start_s: f64,
        mut state: State,
        sample_times_s: &[f64],
        positions: &mut [f64],
    ) -> Result<State, Error> {
        if sample_times_s.len() != positions.len() {
            let (left_len, right_len) = (sample_times_s.len(), positions.len());
            return Err(Error::Length { left: "sample_times_s", left_len, right: "positions", right_len });
        }
        let mut cursor = timeline.at(start_s);
        let mut now_s = start_s;
        for (&sample_s, position) in sample_times_s.iter().zip(positions) {
            if !(sample_s >= now_s && sample_s.is_finite()) {
                return Err(Error::Time { previous_s: now_s, t_s: sample_s });
            }
            while now_s < sample_s {
                let segment = cursor.segment(now_s);
                let end_s = segment.end_s.min(sample_s);
                self.run(segment, now_s, end_s, &mut state);
                now_s = end_s;
            }
            *position = state.position;
        }
        Ok(state)
    }
}
