//! Where a fit fails: the windows it leaves far from the recording, by which start values of further effects are compared
//! before they are fitted to everything.

use nalgebra::DVector;
use rayon::prelude::*;

use super::optimum::TimeFit;
use super::point::Gauge;
use super::track::{Span, Tracks};
use crate::effects::Pulse;
use crate::read::Recording;
use crate::screen::{Active, Problem, minimise};

/// A window with more than this times its freedom is far.
const FAR: f64 = 1.5;
/// Fewer are what a little luck makes of stick and slip,
const FEW: usize = 3;
/// unless one has more than this times its freedom: luck made no more than 4.1 of one in seven sets of clean recordings, a push
/// that is over within two windows of a rotor that holds made 10 to 83.
const LONE: f64 = 8.0;
/// So many far windows, spread evenly, are enough to compare values by.
const ENOUGH: usize = 60;
/// Two far windows with no more than this many between them are one event.
const BRIDGED: usize = 1;
/// Events that are looked into.
const EVENTS: usize = 2;
/// A start moves by this in the unit of the simplex, s.
const START_S: f64 = 0.04;
/// Twice the logarithm of how much less likely a start or a duration may be: 95 %.
const LIKELY: f64 = 3.84;
/// Steps by which a start or an end is moved away, s,
const STEP_S: f64 = 0.002;
/// and how far at most, s.
const FELT_S: f64 = 0.2;
/// The search for a push goes on from so many of the best of a grid,
const DESCENTS: usize = 6;
/// with so many evaluations each.
const EVALUATIONS: usize = 120;

/// The far windows of a fit and their neighbours.
#[derive(Debug)]
pub struct Probe<'a> {
    gauge: Gauge<'a>,
    events: Vec<Event>,
}

/// A run of far windows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Index.
    pub recording: usize,
    /// s.
    pub start_s: f64,
    /// s.
    pub end_s: f64,
}

impl<'a> Probe<'a> {
    /// Of the windows that `fit` leaves far; none where there are few.
    pub fn new(problem: &'a Problem, recordings: &'a [Recording], fit: &TimeFit) -> Option<Self> {
        let mut gauge = fit.gauge(problem, recordings);
        let spans = &gauge.tracks.spans;
        let far: Vec<bool> = spans.iter().zip(&fit.losses).map(|(span, loss)| *loss > FAR * span.freedom()).collect();
        let count = far.iter().filter(|far| **far).count();
        let lone = || spans.iter().zip(&fit.losses).any(|(span, loss)| *loss > LONE * span.freedom());
        if count < FEW && !lone() {
            return None;
        }
        let events = events(&gauge.tracks, &far, &fit.losses);
        let near = |index: usize| far[index.saturating_sub(1)..far.len().min(index + 2)].contains(&true);
        let kept: Vec<bool> = (0..far.len()).map(near).collect();
        let stride = count.div_ceil(ENOUGH);
        let of_event = |span: &Span, t_s: f64| {
            let holds = |event: &Event| event.recording == span.track && (event.start_s..=event.end_s).contains(&t_s);
            events.iter().any(holds)
        };
        let Tracks { tracks, spans, .. } = &mut gauge.tracks;
        let mut index = 0;
        spans.retain(|span| {
            index += 1;
            kept[index - 1] && (index % stride == 0 || of_event(span, tracks[span.track].t_s[span.start]))
        });
        Some(Self { gauge, events })
    }

    /// Of windows spread evenly over the recordings, in units of the sensor's noise: all of them count by their root, so that
    /// none decides alone.
    pub fn spread(problem: &'a Problem, recordings: &'a [Recording]) -> Self {
        let mut tracks = Tracks::new(problem, recordings);
        let stride = tracks.spans.len().div_ceil(ENOUGH);
        let mut index = 0;
        tracks.spans.retain(|_| {
            index += 1;
            index % stride == 0
        });
        Self { gauge: Gauge { problem, tracks }, events: Vec::new() }
    }

    /// Of the windows of `fit` that its effect at `index`, a push, may reach, as far as one is felt out; none for another
    /// effect.
    pub fn around(problem: &'a Problem, recordings: &'a [Recording], fit: &TimeFit, index: usize) -> Option<Self> {
        let push = fit.active.get(index).filter(|entry| entry.effect.is_event())?;
        let (recording, start_s) = (push.values[0] as usize, push.values[1]);
        let end_s = start_s + push.values[2];
        let mut gauge = fit.gauge(problem, recordings);
        let Tracks { tracks, spans, .. } = &mut gauge.tracks;
        spans.retain(|span| {
            let t_s = &tracks[span.track].t_s;
            let (first_s, last_s) = (t_s[span.start], t_s[span.end - 1]);
            span.track == recording && last_s > start_s - FELT_S && first_s < end_s + FELT_S
        });
        Some(Self { gauge, events: Vec::new() })
    }

    /// What values leave of these windows; none where the plant refuses them.
    pub fn loss(&self, active: &[Active]) -> Option<f64> {
        let point = self.gauge.first(active).and_then(|first| self.gauge.settled(first, 2)).ok()?;
        Some(point.loss())
    }

    /// The push that leaves least of these windows on top of what `with` has beside it; `level` is the torque that holds the
    /// rotor during an event, N m (N).
    pub fn push(
        &self,
        with: impl Fn(&Pulse) -> Vec<Active> + Sync,
        level: impl Fn(&Event) -> f64,
    ) -> Option<(f64, Vec<Active>)> {
        let cost = |pulse: &Pulse| self.loss(&with(pulse)).unwrap_or(f64::INFINITY);
        let tried: Vec<Pulse> = self.events.iter().flat_map(|event| grid(event, level(event))).collect();
        let mut costs: Vec<(f64, Pulse)> = tried.into_par_iter().map(|pulse| (cost(&pulse), pulse)).collect();
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        costs.truncate(DESCENTS);
        let reached = costs.into_par_iter().map(|(_, start)| {
            let at = |x: &DVector<f64>| Pulse {
                start_s: start.start_s + START_S * x[0],
                duration_s: start.duration_s * x[1].exp(),
                amplitude: start.amplitude * x[2].exp(),
                ..start
            };
            let (loss, best) = minimise(&DVector::zeros(3), EVALUATIONS, |x| cost(&at(x)));
            (loss, with(&at(&best)))
        });
        reached.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl Probe<'_> {
    /// The same where the effect at `index`, a push, leaves less of these windows when it begins or ends at another time: a
    /// rotor that holds for a part of the push has no slope to follow there. None where it is best as it is.
    pub fn elsewhere(&self, active: &[Active], index: usize) -> Option<Vec<Active>> {
        let push = active.get(index).filter(|entry| entry.effect.is_event())?;
        let least = self.loss(active)?;
        let times = steps().flat_map(|step_s| moves(push, step_s)).filter(|&(_, for_s)| for_s > 0.0);
        let tried = times.collect::<Vec<_>>().into_par_iter().filter_map(|(from_s, for_s)| {
            let moved = pushed(active, index, [from_s, for_s, push.values[3]]);
            Some((self.loss(&moved)?, moved))
        });
        let best = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
        (best.0 < least - LIKELY).then_some(best.1)
    }

    /// Of the effect at `index`, a push: the earliest and latest start (its end kept) and the shortest and longest duration
    /// (its start kept), s, that leave these windows as they are but for noise, with the push as strong or with its impulse
    /// kept. None for another effect.
    pub fn reach(&self, active: &[Active], index: usize) -> Option<[(f64, f64); 2]> {
        let push = active.get(index).filter(|entry| entry.effect.is_event())?;
        let (start_s, duration_s, amplitude) = (push.values[1], push.values[2], push.values[3]);
        let least = self.loss(active)?;
        let allowed = |from_s: f64, for_s: f64| {
            let alike = [amplitude, amplitude * duration_s / for_s];
            let leaves = |size| self.loss(&pushed(active, index, [from_s, for_s, size])).unwrap_or(f64::INFINITY);
            for_s > 0.0 && alike.into_iter().any(|size| leaves(size) < least + LIKELY)
        };
        // Only a refused value is surely outside.
        let farthest = |which: usize| {
            let refused = steps().find(|&step_s| {
                let (from_s, for_s) = moves(push, step_s)[which];
                !allowed(from_s, for_s)
            });
            refused.unwrap_or(FELT_S)
        };
        let [earlier, later, longer, shorter] = [0, 1, 2, 3].map(farthest);
        let start = (start_s - earlier, start_s + later);
        // The end may move with either.
        Some([start, (duration_s - shorter.max(later), duration_s + longer.max(earlier))])
    }
}

/// How far a start or an end is moved, s.
fn steps() -> impl Iterator<Item = f64> {
    (1..=(FELT_S / STEP_S).round() as u32).map(|step| f64::from(step) * STEP_S)
}

/// Start and duration of a push, s, that begins earlier or later, ends later or earlier.
fn moves(push: &Active, step_s: f64) -> [(f64, f64); 4] {
    let (start_s, duration_s) = (push.values[1], push.values[2]);
    [
        (start_s - step_s, duration_s + step_s),
        (start_s + step_s, duration_s - step_s),
        (start_s, duration_s + step_s),
        (start_s, duration_s - step_s),
    ]
}

/// Effects with other values of the push at `index`: start, duration, amplitude.
fn pushed(active: &[Active], index: usize, values: [f64; 3]) -> Vec<Active> {
    let mut moved = active.to_vec();
    moved[index].values[1..].copy_from_slice(&values);
    moved
}

/// Pushes that an event may be: from its begin or a little later, all along or a part of it, a little or far stronger than
/// what holds the rotor.
fn grid(event: &Event, level: f64) -> Vec<Pulse> {
    let long_s = (event.end_s - event.start_s).max(0.02);
    let mut all = Vec::new();
    for start_s in [0.0, 0.025].map(|later_s| event.start_s + later_s) {
        for duration_s in [1.0, 0.7, 0.4].map(|part| part * long_s) {
            for size in [1.05, 1.3, 1.8, 2.6, 4.0] {
                let push = |amplitude| Pulse { recording: event.recording, start_s, duration_s, amplitude };
                all.extend([push(size * level), push(-size * level)]);
            }
        }
    }
    all
}

/// The runs of far windows with the most excess.
fn events(tracks: &Tracks<'_>, far: &[bool], losses: &[f64]) -> Vec<Event> {
    let spans = &tracks.spans;
    let mut runs: Vec<(f64, usize, usize)> = Vec::new();
    for index in (0..spans.len()).filter(|&index| far[index]) {
        let excess = losses[index] - spans[index].freedom();
        match runs.last_mut() {
            Some((sum, _, last)) if spans[*last].track == spans[index].track && index - *last <= BRIDGED + 1 => {
                *sum += excess;
                *last = index;
            }
            _ => runs.push((excess, index, index)),
        }
    }
    runs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let times = runs.into_iter().take(EVENTS).map(|(_, first, last)| {
        let t_s = &tracks.tracks[spans[first].track].t_s;
        Event { recording: spans[first].track, start_s: t_s[spans[first].start], end_s: t_s[spans[last].end - 1] }
    });
    times.collect()
}
