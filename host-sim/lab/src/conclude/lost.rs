//! Logs that are slower than the loop they are of: most of what was commanded is not in them.

use diagnosis::problem::SLOWER;

use crate::precheck::windows::median_period_s;
use crate::read::{Machine, Recording};
use crate::report::{Answer, Verdict};

/// A recording whose rows are further apart than the ticks of its loop.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Lost {
    name: String,
    period_s: f64,
    tick_s: f64,
}

impl Lost {
    /// The slowest of some recordings, if commands are lost in it; where all that it holds are the same, none was.
    pub(super) fn of(machine: &Machine, files: &[&Recording]) -> Option<Self> {
        let tick_s = machine.axis.sample_period_s;
        let changes = |file: &&&Recording| file.effort_cmd.windows(2).any(|pair| pair[0] != pair[1]);
        let periods = files.iter().filter(changes).map(|file| (median_period_s(&file.t_s), &file.name));
        let (period_s, name) = periods.max_by(|a, b| a.0.total_cmp(&b.0))?;
        (period_s >= SLOWER * tick_s).then(|| Self { name: name.clone(), period_s, tick_s })
    }

    fn ticks(&self) -> f64 {
        (self.period_s / self.tick_s).round()
    }

    /// What the user should know of it, and do.
    pub(super) fn note(&self) -> String {
        let Self { name, period_s, tick_s } = self;
        let period_s = (1e6 * period_s).round() / 1e6;
        format!(
            "{name}: rows are {period_s} s apart and the loop has a tick every {tick_s} s (`sample_period_s` of the machine file), so \
             one command of {} is in the log; it is taken for the mean of those around it, and no effect is certain; log every tick, \
             or set sample_period_s to {period_s} if a command is held until the next row",
            self.ticks()
        )
    }

    /// Whatever is found may come from the commands that nobody knows.
    pub(super) fn doubt(&self, answer: &mut Answer) {
        let sentence = format!("Commands between the rows: the log holds one of {}.", self.ticks());
        answer.effects.iter_mut().for_each(|effect| effect.nuisances.push(sentence.clone()));
        if answer.verdict.is_certain() {
            answer.verdict = Verdict::Ambiguous;
        }
    }
}
