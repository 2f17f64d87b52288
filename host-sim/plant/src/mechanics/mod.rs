//! Motion of the rotor under what acts on it.

mod collocation;
mod events;
mod exact;
mod fluid;
mod general;
mod phi;
mod root;
mod series;
mod state;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::sensor::SensorModel;
use crate::{Error, Model, Segment, Timeline};
use exact::Exact;
pub use fluid::room;
use general::General;
pub use state::{Motion, State};

/// The moving part of a model, ready to run over any [`Timeline`] built from the same model.
#[derive(Debug, Clone)]
pub struct Mechanics {
    path: Path,
    sensor: SensorModel,
    /// Where the work of every simulation is added.
    work: Option<Arc<AtomicU64>>,
    /// The most there may be.
    most: u64,
}

/// How the motion is integrated.
#[derive(Debug, Clone)]
enum Path {
    Exact(Exact),
    General(Box<General>),
}

impl Mechanics {
    /// Prepares a model.
    ///
    /// # Errors
    /// [`Error::Parameter`] where the model does not hold water.
    pub fn new(model: &Model) -> Result<Self, Error> {
        model.validate()?;
        let path = if Exact::covers(model) {
            Path::Exact(Exact::new(model))
        } else {
            Path::General(Box::new(General::new(model)))
        };
        Ok(Self { path, sensor: model.sensor.clone(), work: None, most: u64::MAX })
    }

    /// The same, adding the work of every simulation to a counter: steps of a law with a closed form, and iterations of one
    /// without, those in the location of events too. It depends on nothing but model, commands and times, unlike a clock.
    #[must_use]
    pub fn counting(self, work: &Arc<AtomicU64>) -> Self {
        Self { work: Some(Arc::clone(work)), ..self }
    }

    /// The same, with [`Error::TooStiff`] from any simulation that has brought the counter beyond `most`, within a sample.
    #[must_use]
    pub fn at_most(self, most: u64) -> Self {
        Self { most, ..self }
    }

    /// The systematic part of the sensor.
    pub fn sensor(&self) -> &SensorModel {
        &self.sensor
    }

    /// Moves `state` through `segment` from `from_s` to `to_s`, absolute times within it.
    #[inline]
    pub(crate) fn run(&self, segment: &Segment, from_s: f64, to_s: f64, state: &mut State) -> u64 {
        let (from_s, to_s) = (from_s - segment.start_s, to_s - segment.start_s);
        match &self.path {
            Path::Exact(flow) => events::run(flow, segment, from_s, to_s, state),
            Path::General(flow) => events::run(&**flow, segment, from_s, to_s, state),
        }
    }

    /// Runs from `state` at `start_s` and writes the position the sensor reports at each of `sample_times_s` to
    /// `positions`, rad (m): eccentric and late as the model says, without noise and steps; returns the state at the last
    /// sample. Delays and lags of the commands are warm, they live in the timeline. Where the sensor is late, `state` is
    /// the one it reports at `start_s`, so the true time of the run is earlier by the latency.
    ///
    /// Sample times must not run back nor lie before `start_s`. Nothing is allocated.
    ///
    /// # Errors
    /// [`Error::Length`] where the slices differ, [`Error::Time`] where time runs back.
    pub fn simulate(
        &self,
        timeline: &Timeline,
        start_s: f64,
        state: State,
        sample_times_s: &[f64],
        positions: &mut [f64],
    ) -> Result<State, Error> {
        if sample_times_s.len() != positions.len() {
            let (left_len, right_len) = (sample_times_s.len(), positions.len());
            return Err(Error::Length { left: "sample_times_s", left_len, right: "positions", right_len });
        }
        let mut state = state.with_motion();
        let mut now_s = start_s - self.sensor.latency_s;
        let mut cursor = timeline.at(now_s);
        for (&sample_s, position) in sample_times_s.iter().zip(positions) {
            let sample_s = sample_s - self.sensor.latency_s;
            if !(sample_s >= now_s && sample_s.is_finite()) {
                return Err(Error::Time { previous_s: now_s, t_s: sample_s });
            }
            let mut steps = 0;
            while now_s < sample_s {
                let segment = cursor.segment(now_s);
                let end_s = segment.end_s.min(sample_s);
                steps += self.run(segment, now_s, end_s, &mut state);
                now_s = end_s;
            }
            *position = self.sensor.distorted(state.position);
            if let Some(work) = &self.work
                && work.fetch_add(steps, Ordering::Relaxed) > self.most
            {
                return Err(Error::TooStiff);
            }
        }
        Ok(state)
    }
}
