//! Recordings cut into windows, and machines ready to be run over them.

use std::sync::Arc;

use nalgebra::DVector;
use plant::{Command, Er, FluidResponse, Mechanics, Model, State, Timeline};
use rayon::prelude::*;

use super::model;
use super::observer::Observer;
use super::whiten::{Noise, Whitener};
use super::windows::{HORIZON_S, SETTLE_S};
use crate::budget::Budget;
use crate::effects::Physics;
use crate::read::Recording;
use crate::residual::{Unknowns, horizon_s, recorded_commands, spans};
use crate::screen::{Motion, Problem};

/// One recording.
#[derive(Debug)]
pub(super) struct Track<'a> {
    pub t_s: &'a [f64],
    /// Measured positions with glitches repaired, rad (m).
    pub position: &'a [f64],
    recording: &'a Recording,
    observer: Observer<'a>,
}

/// One window of a recording.
#[derive(Debug)]
pub(super) struct Span {
    pub track: usize,
    pub start: usize,
    pub end: usize,
    /// Of the problem that the search solved.
    pub block: usize,
    /// Whether the rotor moves from one end to the other.
    pub moves: bool,
    pub whitener: Whitener,
    /// Position and speed of the smoothed motion at the first row.
    pub guess: [f64; 2],
}

impl Span {
    /// Rows less the two numbers of the start state of a rigid rotor.
    pub(super) fn freedom(&self) -> f64 {
        (self.end - self.start) as f64 - 2.0
    }
}

/// A machine over one recording.
#[derive(Debug)]
pub(super) struct Machine {
    model: Model,
    mechanics: Mechanics,
    timeline: Arc<Timeline>,
    pub unknowns: Unknowns,
    /// About the state inside the machine at the start of each window of the track, by its first row.
    inside: Option<Vec<State>>,
}

impl Machine {
    /// The start state of a window with a position and speed, and what is inside where the observer has it.
    pub(super) fn start(&self, span: &Span, rotor: [f64; 2]) -> DVector<f64> {
        self.unknowns.pack(rotor, &self.inside(span))
    }

    /// Start states from which a window may find a better one; `position` is that of the best so far. A load in a gap has no
    /// slope to follow from one side to the other.
    pub(super) fn starts(&self, span: &Span, position: f64) -> Vec<DVector<f64>> {
        let moving = span.guess;
        let rotors = [moving, [moving[0], 0.0], [position, moving[1]]];
        let mut starts = rotors.map(|rotor| self.start(span, rotor)).to_vec();
        starts.extend(self.unknowns.touching(moving, self.inside(span)));
        starts
    }

    fn inside(&self, span: &Span) -> State {
        self.inside.as_ref().map_or_else(State::default, |inside| inside[span.start])
    }
}

/// All windows of all recordings.
#[derive(Debug)]
pub(super) struct Tracks<'a> {
    pub tracks: Vec<Track<'a>>,
    pub spans: Vec<Span>,
    budget: &'a Budget,
}

impl<'a> Tracks<'a> {
    /// Windows of the recordings that a problem was built from, weighed as if the noise were that of the sensor alone.
    pub(super) fn new(problem: &'a Problem, recordings: &'a [Recording]) -> Self {
        let pairs = || recordings.iter().zip(&problem.motions);
        let tracks = pairs()
            .map(|(recording, motion)| Track {
                t_s: &recording.t_s,
                position: &motion.position,
                recording,
                observer: Observer::new(motion),
            })
            .collect();
        let spans = pairs().enumerate().flat_map(|(track, (recording, motion))| {
            let settled_s = recording.t_s[0] + SETTLE_S;
            let found = spans(recording, horizon_s(recording, HORIZON_S)).into_iter();
            found
                .filter(move |&(start, _)| recording.t_s[start] >= settled_s)
                .map(move |(start, end)| span(problem, motion, track, start, end))
        });
        let spans = spans.collect();
        Self { tracks, spans, budget: &problem.budget }
    }

    /// Rows of all windows less the start states: what noise alone would leave.
    pub(super) fn freedom(&self) -> f64 {
        self.spans.iter().map(Span::freedom).sum()
    }

    /// New weights.
    pub(super) fn weigh(&mut self, noise: &[Noise]) {
        let tracks = &self.tracks;
        self.spans.par_iter_mut().for_each(|span| {
            span.whitener = Whitener::new(&tracks[span.track].t_s[span.start..span.end], noise[span.track]);
        });
    }

    /// Prepares a machine for every recording, with the commands of `known` where they act the same.
    ///
    /// # Errors
    /// Values that the plant refuses.
    pub(super) fn machines(&self, physics: &Physics, known: Option<&[Machine]>) -> Result<Vec<Machine>, plant::Error> {
        let each = self.tracks.iter().enumerate();
        each.map(|(index, track)| {
            let model = model(physics, index);
            let acting = known.map(|known| &known[index]).filter(|known| actuation(&known.model) == actuation(&model));
            let timeline = match acting {
                Some(known) => Arc::clone(&known.timeline),
                None => {
                    let commands = recorded_commands(track.recording);
                    let before = commands.first().copied().unwrap_or_default();
                    let before = Command { speed_estimate: 0.0, ..before };
                    Arc::new(Timeline::new(&model, track.t_s, &commands, &before)?)
                }
            };
            let inside = physics.remembers().then(|| {
                let rows: Vec<usize> =
                    self.spans.iter().filter(|span| span.track == index).map(|span| span.start).collect();
                let mut states = vec![State::default(); track.t_s.len()];
                for (&row, state) in rows.iter().zip(track.observer.states(physics, &rows)) {
                    states[row] = state;
                }
                states
            });
            let unknowns = Unknowns::of(&model);
            Ok(Machine {
                mechanics: Mechanics::new(&model)?.counting(self.budget.counter()),
                model,
                timeline,
                unknowns,
                inside,
            })
        })
        .collect()
    }

    /// Measured minus simulated position of a window from a start state, rad (m).
    pub(super) fn residual(
        &self,
        span: &Span,
        machines: &[Machine],
        start: &DVector<f64>,
        into: &mut Vec<f64>,
    ) -> Result<(), plant::Error> {
        let (track, machine) = (&self.tracks[span.track], &machines[span.track]);
        let t_s = &track.t_s[span.start..span.end];
        let state = machine.unknowns.unpack(start);
        into.clear();
        into.resize(t_s.len(), 0.0);
        machine.mechanics.simulate(&machine.timeline, t_s[0], state, t_s, into)?;
        let measured = &track.position[span.start..span.end];
        into.iter_mut().zip(measured).for_each(|(value, measured)| *value = measured - *value);
        Ok(())
    }
}

fn span(problem: &Problem, motion: &Motion, track: usize, start: usize, end: usize) -> Span {
    let t_s = &motion.t_s[start..end];
    let noise = Noise { position: motion.noise.powi(2).max(1e-30), acceleration: 0.0 };
    let middle_s = 0.5 * (t_s[0] + t_s[t_s.len() - 1]);
    Span {
        track,
        start,
        end,
        block: problem.block(track, middle_s),
        moves: motion.cell_sign[start..end - 1].iter().all(|sign| *sign != 0.0),
        whitener: Whitener::new(t_s, noise),
        guess: [motion.smooth[start], motion.speed[start]],
    }
}

/// What of a model the timeline is made of.
fn actuation(model: &Model) -> Model {
    let er = model.er.as_ref().map(|er| match er.response {
        FluidResponse::Field(_) => Er { response: er.response, ..Er::new(0.0, 0.0, 0.0, 0.0) },
        _ => er.clone(),
    });
    Model {
        torque_gain: model.torque_gain,
        torque_offset: model.torque_offset,
        torque_limit: model.torque_limit,
        torque_deadband: model.torque_deadband,
        torque_delay_s: model.torque_delay_s,
        torque_lag_s: model.torque_lag_s,
        er,
        pulses: model.pulses.clone(),
        ..Model::new(1.0)
    }
}

/// Whether the torque, or what the sensor shows, depends on the position itself and not on its changes alone.
pub(super) fn knows_where(physics: &Physics) -> bool {
    !physics.cogging.is_empty() || physics.gravity.is_some() || physics.spring != 0.0 || physics.eccentricity.is_some()
}
