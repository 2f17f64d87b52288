//! What the link leaves for the ticks: the reference and where it comes from, a request, and how long the link is silent.

use crate::app::Orders;
use crate::{Counts, Faults, Request, State, Supervisor};

/// Where the reference comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// It stays where it is.
    Held,
    /// The link, whose silence is then a fault.
    Link,
    /// An experiment, counted from where the reference stood.
    Experiment { base: Counts },
}

/// One value of an experiment, computed ahead of the tick in thread mode: sixteen sines do not belong into an interrupt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Offset {
    /// From where the reference stood, counts.
    Counts(Counts),
    /// The experiment is over; the reference stays.
    End,
}

/// Makes the [`Orders`] of each tick of what the link asked for. The interrupt owns it; thread mode borrows it between
/// two ticks.
#[derive(Debug)]
pub struct Commander {
    orders: Orders,
    source: Source,
    /// Ticks since the link was heard of.
    silent_ticks: u32,
    /// Ticks without a word after which the link is silent.
    patience_ticks: u32,
}

impl Commander {
    /// Reports `faults` until they are cleared; the link is silent once nothing was heard for `patience_ticks`, and before
    /// anything was.
    pub fn new(faults: Faults, patience_ticks: u32) -> Self {
        let orders = Orders { reported: faults, ..Orders::default() };
        Self { orders, source: Source::Held, silent_ticks: patience_ticks, patience_ticks }
    }

    /// Something valid was heard on the link.
    pub fn heard(&mut self) {
        self.silent_ticks = 0;
    }

    /// Makes a request in the next tick. Clearing also forgets what the last reset was: the user has been told.
    pub fn request(&mut self, request: Request) {
        if request == Request::ClearFault {
            self.orders.reported = Faults::empty();
        }
        self.orders.request = request;
    }

    /// The reference, from the link.
    pub fn follow(&mut self, reference: Counts) {
        self.source = Source::Link;
        self.orders.reference = reference;
    }

    /// The reference stays where it is, and silence is no fault.
    pub fn hold(&mut self) {
        self.source = Source::Held;
    }

    /// Runs an experiment from where the reference stands.
    pub fn experiment(&mut self) {
        self.source = Source::Experiment { base: self.orders.reference };
    }

    /// The reference, counts.
    pub fn reference(&self) -> Counts {
        self.orders.reference
    }

    /// A frame was lost on its way to the log.
    pub fn lost_frame(&mut self) {
        self.orders.lost = self.orders.lost.saturating_add(1);
    }

    /// What the tick is told that begins in `state`. `offset` gives the next value of an experiment, and is asked only
    /// while one runs; without a value the reference waits for it.
    #[inline]
    pub fn orders(&mut self, state: &State, offset: impl FnOnce() -> Option<Offset>) -> Orders {
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        self.orders.link_alive = self.silent_ticks < self.patience_ticks;
        if state.supervisor() != Supervisor::Running {
            // The axis starts where it stands, whatever was asked of it before.
            self.source = Source::Held;
            self.orders.reference = state.position();
        }
        if let Source::Experiment { base } = self.source {
            match offset() {
                Some(Offset::Counts(offset)) => self.orders.reference = Counts(base.0.saturating_add(offset.0)),
                Some(Offset::End) => self.source = Source::Held,
                None => {}
            }
        }
        self.orders.reference_from_link = matches!(self.source, Source::Link);
        let orders = self.orders;
        self.orders.request = Request::None;
        orders
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn orders(commander: &mut Commander, state: &State, offsets: &mut impl Iterator<Item = Offset>) -> Orders {
        commander.orders(state, || offsets.next())
    }

    #[test]
    fn silence_counts_ticks_since_the_last_word() {
        let mut commander = Commander::new(Faults::empty(), 3);
        let alive = |commander: &mut Commander| commander.orders(&State::default(), || None).link_alive;
        assert!(!alive(&mut commander), "nothing was heard yet");
        commander.heard();
        let ticks = [(); 4].map(|()| alive(&mut commander));
        assert_eq!(ticks, [true, true, false, false]);
    }

    #[test]
    fn a_request_lasts_one_tick_and_clearing_forgets_the_reset() {
        let mut commander = Commander::new(Faults::ABNORMAL_RESET, 500);
        let state = State::default();
        assert_eq!(orders(&mut commander, &state, &mut core::iter::empty()).reported, Faults::ABNORMAL_RESET);
        commander.request(Request::ClearFault);
        let clearing = orders(&mut commander, &state, &mut core::iter::empty());
        assert_eq!((clearing.request, clearing.reported), (Request::ClearFault, Faults::empty()));
        assert_eq!(orders(&mut commander, &state, &mut core::iter::empty()).request, Request::None);
    }

    #[test]
    fn an_experiment_adds_to_the_reference_waits_for_values_and_ends() {
        let running = State::running_at(Counts(100));
        let mut commander = Commander::new(Faults::empty(), 500);
        commander.follow(Counts(1000));
        assert!(orders(&mut commander, &running, &mut core::iter::empty()).reference_from_link);
        commander.experiment();
        let mut offsets = [Offset::Counts(Counts(5)), Offset::Counts(Counts(-7))].into_iter();
        let references = [(); 3].map(|()| orders(&mut commander, &running, &mut offsets).reference.0);
        assert_eq!(references, [1005, 993, 993]);
        let mut end = [Offset::End, Offset::Counts(Counts(9))].into_iter();
        let last = [(); 2].map(|()| orders(&mut commander, &running, &mut end));
        assert_eq!(last.map(|orders| (orders.reference.0, orders.reference_from_link)), [(993, false); 2]);
    }

    #[test]
    fn a_drive_that_stops_forgets_where_it_was_sent() {
        let mut commander = Commander::new(Faults::empty(), 500);
        commander.follow(Counts(1000));
        let stopped = orders(&mut commander, &State::default(), &mut core::iter::empty());
        assert_eq!((stopped.reference, stopped.reference_from_link), (Counts(0), false));
        let enabled = orders(&mut commander, &State::running_at(Counts(0)), &mut core::iter::empty());
        assert_eq!((enabled.reference, enabled.reference_from_link), (Counts(0), false));
    }
}
