//! Motion through one segment: sliding and sticking, with every change between them located in time.

use std::cell::Cell;
use std::ops::Deref;

use super::root::root;
use super::state::{Motion, State};
use crate::Segment;

/// A law of motion that events are located on. Times `t` count from the start of the segment, s.
pub(crate) trait Flow {
    /// State `h` seconds of sliding after `x`, all in one motion and one regime, and the work that took, in steps of a law
    /// with a closed form.
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> (State, u32);

    /// Acceleration while sliding, rad/s^2 (m/s^2).
    fn acceleration(&self, segment: &Segment, t: f64, x: &State) -> f64;

    /// At standstill: the torque that pushes the rotor, and the drag that holds it against pushes in that direction.
    fn rest_balance(&self, segment: &Segment, t: f64, x: &State) -> Balance;

    /// Longest step from `x` with full accuracy, s.
    fn longest_step(&self, segment: &Segment, t: f64, x: &State) -> f64;

    /// Whether the balance at standstill has one sign change at most on a segment, so that its ends tell.
    fn rest_is_monotone(&self, segment: &Segment) -> bool;

    /// Settles what jumps at the start of a segment or is new at a start state: regime, clipped bristles.
    fn enter(&self, _segment: &Segment, _t: f64, _x: &mut State) {}

    /// Positive as long as the regime of `x` holds; infinite where there is nothing to leave.
    fn guard(&self, _segment: &Segment, _t: f64, _x: &State) -> f64 {
        f64::INFINITY
    }

    /// Puts a state whose guard has reached zero into its next regime.
    fn leave_regime(&self, _segment: &Segment, _t: f64, _x: &mut State) {}
}

/// A law of motion whose work is counted wherever a step is taken, in the location of an event too.
struct Metered<'a, F> {
    flow: &'a F,
    work: Cell<u64>,
}

impl<F: Flow> Metered<'_, F> {
    #[inline]
    fn step(&self, segment: &Segment, t: f64, x: &State, h: f64) -> State {
        let (state, work) = self.flow.step(segment, t, x, h);
        self.work.set(self.work.get() + u64::from(work));
        state
    }
}

impl<F> Deref for Metered<'_, F> {
    type Target = F;

    #[inline]
    fn deref(&self) -> &F {
        self.flow
    }
}

/// Torques at standstill, N m (N).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Balance {
    /// Motor and position-dependent torque together.
    pub push: f64,
    /// Largest drag against that push.
    pub hold: f64,
}

impl Balance {
    /// Negative once the rotor breaks away.
    fn margin(&self) -> f64 {
        self.hold - self.push.abs()
    }

    fn motion(&self) -> Motion {
        if self.margin() < 0.0 { Motion::along(self.push) } else { Motion::Stuck }
    }
}

/// Shortest advance of an event, s. It only acts where torques balance to the last bit and the location of the event
/// has no digits left; the rotor moves less than 1e-17 rad in it.
const LEAST_ADVANCE_S: f64 = 1e-11;
/// Turns of a segment after which events crowd: a law that chatters between two regimes, each of which throws it back.
const PATIENCE: i32 = 64;
/// The shortest advance then doubles every so many turns, so that a segment always ends: chatter becomes its own mean.
const TURNS_TO_DOUBLE: i32 = 4;

/// Shortest step that a law may ask for, s: laws are followed down to 50 us, and a number at the end of what a double holds
/// may ask for none at all.
const LEAST_STEP_S: f64 = 1e-6;

/// Shortest advance of an event after so many turns within one segment, s.
fn least_advance_s(turns: i32) -> f64 {
    LEAST_ADVANCE_S * 2.0_f64.powi(((turns - PATIENCE) / TURNS_TO_DOUBLE).max(0))
}

/// Moves `x` from `from_s` to `to_s` within the segment; both count from its start. Gives the work of it.
#[inline]
pub(crate) fn run<F: Flow>(flow: &F, segment: &Segment, from_s: f64, to_s: f64, x: &mut State) -> u64 {
    let flow = &Metered { flow, work: Cell::new(0) };
    let mut t = from_s;
    let mut turns = 0;
    flow.enter(segment, t, x);
    while t < to_s {
        let least_s = least_advance_s(turns);
        t = match x.motion {
            Motion::Stuck => rest(flow, segment, (t, to_s), least_s, x),
            Motion::Forward | Motion::Backward => slide(flow, segment, (t, to_s), least_s, x),
        };
        turns += 1;
    }
    flow.work.get()
}

/// Waits for break-away; returns the time reached. The rotor has not moved, but a load behind it may have.
fn rest<F: Flow>(flow: &Metered<'_, F>, segment: &Segment, (t, to_s): (f64, f64), least_s: f64, x: &mut State) -> f64 {
    let balance = flow.rest_balance(segment, t, x);
    x.motion = balance.motion();
    if x.motion != Motion::Stuck {
        flow.enter(segment, t, x);
        return t;
    }
    let longest = if flow.rest_is_monotone(segment) { f64::INFINITY } else { 0.25 * flow.longest_step(segment, t, x) };
    let (mut h, mut end) = cut(t, to_s, longest);
    let mut next = flow.step(segment, t, x, h);
    if let Some(left) = leave_within(flow, segment, t, x, (h, least_s), &next) {
        (h, end, next) = (left.0, t + left.0, left.1);
    }
    let last = flow.rest_balance(segment, end, &next).margin();
    if last < 0.0 {
        let margin = |h: f64| flow.rest_balance(segment, t + h, &flow.step(segment, t, x, h)).margin();
        let h = root(margin, (0.0, balance.margin()), (h, last)).max(least_s).min(h);
        end = t + h;
        next = flow.step(segment, t, x, h);
        next.motion = Motion::along(flow.rest_balance(segment, end, &next).push);
        flow.enter(segment, end, &mut next);
    }
    *x = next;
    end
}

/// A step of at most `longest` that ends exactly at `to_s` if it reaches it: its length and its end.
#[inline]
fn cut(t: f64, to_s: f64, longest: f64) -> (f64, f64) {
    let longest = longest.max(LEAST_STEP_S);
    if longest < to_s - t { (longest, t + longest) } else { (to_s - t, to_s) }
}

/// Slides until the first event or `to_s`; returns the time reached.
#[inline]
fn slide<F: Flow>(flow: &Metered<'_, F>, segment: &Segment, (t, to_s): (f64, f64), least_s: f64, x: &mut State) -> f64 {
    let (mut h, mut end) = cut(t, to_s, flow.longest_step(segment, t, x));
    let mut next = flow.step(segment, t, x, h);
    let mut stop = stop_within(flow, segment, t, x, h, &next);
    match stop {
        Stop::Never => {}
        Stop::AtOnce { wait_s } => {
            let wait_s = wait_s.max(least_s).min(to_s - t);
            (x.velocity, x.motion) = (0.0, Motion::Stuck);
            *x = flow.step(segment, t, x, wait_s);
            return t + wait_s;
        }
        Stop::After(stop_s) => {
            let stop_s = stop_s.max(least_s).min(h);
            (h, end) = (stop_s, t + stop_s);
            next = flow.step(segment, t, x, h);
        }
    }
    if let Some(left) = leave_within(flow, segment, t, x, (h, least_s), &next) {
        (end, next, stop) = (t + left.0, left.1, Stop::Never);
    }
    *x = next;
    if matches!(stop, Stop::After(_)) {
        x.velocity = 0.0;
        x.motion = flow.rest_balance(segment, end, x).motion();
        flow.enter(segment, end, x);
    }
    end
}

/// The end of the regime within a step of `h`, if it ends there: when, and the state in the next regime.
#[inline]
fn leave_within<F: Flow>(
    flow: &Metered<'_, F>,
    segment: &Segment,
    t: f64,
    x: &State,
    (h, least_s): (f64, f64),
    next: &State,
) -> Option<(f64, State)> {
    let last = flow.guard(segment, t + h, next);
    if last >= 0.0 {
        return None;
    }
    let first = flow.guard(segment, t, x);
    let guard = |h: f64| flow.guard(segment, t + h, &flow.step(segment, t, x, h));
    // A state that has just come in over one edge stands on it, and leaves over another later: the way in is no exit.
    let inside = if first > 0.0 { Some((0.0, first)) } else { just_inside(&guard, h) };
    let h = inside.map_or(0.0, |inside| root(guard, inside, (h, last))).max(least_s).min(h);
    let mut state = flow.step(segment, t, x, h);
    flow.leave_regime(segment, t + h, &mut state);
    Some((h, state))
}

/// The earliest point of a geometric row within `h` at which a guard that begins at zero is positive.
#[cold]
fn just_inside(guard: &impl Fn(f64) -> f64, h: f64) -> Option<(f64, f64)> {
    let times = std::iter::successors(Some(LEAST_ADVANCE_S), |time| Some(8.0 * time)).take_while(|time| *time < h);
    times.map(|time| (time, guard(time))).find(|(_, value)| *value > 0.0)
}

/// Whether and when sliding comes to a stop within a step.
enum Stop {
    Never,
    /// After that time, s.
    After(f64),
    /// The rotor could not even start; the balance tips back after `wait_s`.
    AtOnce {
        wait_s: f64,
    },
}

/// Finds the first zero of the speed. The speed along the motion has one interior extremum at most in a step (exact for
/// the nominal machine, where w' exp(viscous t / J) is monotone), so the ends and that extremum tell everything.
#[inline]
fn stop_within<F: Flow>(flow: &Metered<'_, F>, segment: &Segment, t: f64, x: &State, h: f64, next: &State) -> Stop {
    let sign = x.motion.sign();
    let start = sign * x.velocity;
    let end = sign * next.velocity;
    let first_slope = sign * flow.acceleration(segment, t, x);
    // The nominal speed never falls faster than at the start and rises again within a step (see above), which bounds its
    // dip by the first slope; the factor two is a margin for the other laws.
    if end > 0.0 && start + 2.0 * first_slope * h > 0.0 {
        return Stop::Never;
    }
    let state = |h: f64| flow.step(segment, t, x, h);
    let speed = |h: f64| sign * state(h).velocity;
    let slope = |h: f64| sign * flow.acceleration(segment, t + h, &state(h));
    let last_slope = sign * flow.acceleration(segment, t + h, next);
    if end > 0.0 {
        if first_slope >= 0.0 || last_slope <= 0.0 {
            return Stop::Never;
        }
        let dip = root(slope, (0.0, first_slope), (h, last_slope));
        let lowest = speed(dip);
        return if lowest > 0.0 { Stop::Never } else { Stop::After(root(speed, (0.0, start), (dip, lowest))) };
    }
    if start > 0.0 {
        return Stop::After(root(speed, (0.0, start), (h, end)));
    }
    // Just broken away: the speed rises from zero before it can return to it.
    if first_slope <= 0.0 || last_slope >= 0.0 {
        return Stop::AtOnce { wait_s: 0.0 };
    }
    let top = root(slope, (0.0, first_slope), (h, last_slope));
    let highest = speed(top);
    if highest > 0.0 { Stop::After(root(speed, (top, highest), (h, end))) } else { Stop::AtOnce { wait_s: top } }
}
