//! Commands known in advance, turned into what acts on the rotor.

use crate::actuation::Actuation;
use crate::{Command, Error, Model, Segment};

/// How long before its first row a recording can be simulated, s, with the command assumed there.
const HISTORY_S: f64 = 10.0;

/// The segments of a whole recording: built once, then run any number of times by [`crate::Mechanics`].
#[derive(Debug, Clone)]
pub struct Timeline {
    segments: Vec<Segment>,
}

impl Timeline {
    /// Each command acts from its time to the next, the last one forever, whatever the spacing. `before` was held since
    /// ever when the first one came: [`Command::default`] for a machine at rest, the first row for a recording cut from
    /// the middle.
    ///
    /// # Errors
    /// [`Error::Parameter`] for the model, [`Error::Command`] for a command that is no number, [`Error::Time`] where
    /// time does not run forward, [`Error::Length`] where times and commands differ in number.
    pub fn new(model: &Model, times_s: &[f64], commands: &[Command], before: &Command) -> Result<Self, Error> {
        model.validate()?;
        if times_s.len() != commands.len() {
            let (left_len, right_len) = (times_s.len(), commands.len());
            return Err(Error::Length { left: "times_s", left_len, right: "commands", right_len });
        }
        let first_s = times_s.first().copied().unwrap_or(0.0);
        if !first_s.is_finite() {
            return Err(Error::Time { previous_s: 0.0, t_s: first_s });
        }
        before.check(first_s)?;
        let mut actuation = Actuation::new(model, before, first_s - HISTORY_S);
        let mut segments = Vec::with_capacity(2 * times_s.len() + 2);
        for (&t_s, command) in times_s.iter().zip(commands) {
            let previous_s = actuation.now_s();
            if !(t_s > previous_s && t_s.is_finite()) {
                return Err(Error::Time { previous_s, t_s });
            }
            command.check(t_s)?;
            while actuation.now_s() < t_s {
                segments.push(actuation.next_segment(t_s));
            }
            actuation.command(command);
        }
        while actuation.now_s() < f64::INFINITY {
            segments.push(actuation.next_segment(f64::INFINITY));
        }
        Ok(Self { segments })
    }

    /// Every segment, in order and without gaps, the last one without end.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// A place to read on from.
    pub(crate) fn at(&self, t_s: f64) -> Cursor<'_> {
        let index = self.segments.partition_point(|segment| segment.end_s <= t_s);
        Cursor { segments: &self.segments, index }
    }
}

/// A place in a timeline that only moves forward.
pub(crate) struct Cursor<'a> {
    segments: &'a [Segment],
    index: usize,
}

impl<'a> Cursor<'a> {
    /// The segment that holds from `t_s` on; the first one for times before it.
    #[inline]
    pub(crate) fn segment(&mut self, t_s: f64) -> &'a Segment {
        while self.segments[self.index].end_s <= t_s {
            self.index += 1;
        }
        &self.segments[self.index]
    }
}
