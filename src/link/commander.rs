//! What the link leaves for the ticks: the reference and where it comes from, a request, and how long the link is silent.

use crate::app::Orders;
use crate::motion::{MotionLimits, Pace, Profile};
use crate::{Counts, Faults, Request, State, Supervisor};

/// Where the reference comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// It stays where it is.
    Held,
    /// The link, whose silence is then a fault.
    Link,
    /// An experiment, counted from where the reference stood.
    Experiment { base: Counts, autonomous: bool },
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
    /// A reference that stays needs no link.
    autonomous: bool,
    target: Counts,
    profile: Profile,
    new_position: Counts,
    /// Ticks since the link was heard of.
    silent_ticks: u32,
    /// Ticks without a word after which the link is silent.
    patience_ticks: u32,
}

impl Commander {
    /// Reports `faults` until they are cleared; the link is silent once nothing was heard for `patience_ticks`, and before
    /// anything was.
    pub fn new(faults: Faults, patience_ticks: u32) -> Self {
        Self {
            orders: Orders { reported: faults, ..Orders::default() },
            source: Source::Held,
            autonomous: false,
            target: Counts(0),
            profile: Profile::at(Counts(0)),
            new_position: Counts(0),
            silent_ticks: patience_ticks,
            patience_ticks,
        }
    }

    /// Something valid was heard of the client that commands.
    pub fn heard(&mut self) {
        self.silent_ticks = 0;
    }

    /// Whether that client was heard of recently.
    pub fn link_alive(&self) -> bool {
        self.silent_ticks < self.patience_ticks
    }

    /// Makes a request in the next tick; a disable wins over whatever else is asked of the same tick. Clearing also
    /// forgets what the last reset was: the user has been told.
    pub fn request(&mut self, request: Request) {
        if self.orders.request == Request::Disable {
            return;
        }
        if request == Request::ClearFault {
            self.orders.reported = Faults::empty();
        }
        self.orders.request = request;
    }

    /// Asks for an enable. Unless `autonomous`, silence of the link is then a fault even while the reference stays.
    pub fn enable(&mut self, autonomous: bool) {
        self.autonomous = autonomous;
        self.request(Request::Enable);
    }

    /// Calls the position by another name in the next tick.
    pub fn set_position(&mut self, position: Counts) {
        self.new_position = position;
        self.request(Request::SetPosition);
    }

    /// Sends the reference to `target` at a pace, with at most so many N m; 0 for no bound but the parameter's.
    pub fn follow(&mut self, target: Counts, limits: &MotionLimits, pace: &Pace, torque_bound_nm: u8) {
        self.leave_experiment();
        self.profile.pace(limits, pace);
        self.source = Source::Link;
        self.target = target;
        self.orders.torque_bound_nm = torque_bound_nm;
    }

    /// Where the reference is going, counts.
    pub fn target(&self) -> Counts {
        self.target
    }

    /// The reference slows down and stays; with `autonomous`, silence is then no fault.
    pub fn hold(&mut self, autonomous: bool) {
        self.leave_experiment();
        self.autonomous = autonomous;
        self.source = Source::Held;
        self.target = self.profile.nearest_rest();
    }

    /// Runs an experiment from where the reference is.
    pub fn experiment(&mut self, autonomous: bool, torque_bound_nm: u8) {
        self.leave_experiment();
        self.source = Source::Experiment { base: self.orders.reference, autonomous };
        self.orders.torque_bound_nm = torque_bound_nm;
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
    pub fn orders(&mut self, state: &State, limits: &MotionLimits, offset: impl FnOnce() -> Option<Offset>) -> Orders {
        self.silent_ticks = self.silent_ticks.saturating_add(1);
        self.orders.link_alive = self.link_alive();
        if state.supervisor() != Supervisor::Running {
            // The axis starts where it stands, whatever was asked of it before.
            self.source = Source::Held;
            self.orders.torque_bound_nm = 0;
            self.rest_at(state.position());
        }
        let before = self.orders.reference;
        let wanted = self.wanted(offset);
        self.orders.reference = if state.homed() { limits.hold(wanted, before) } else { wanted };
        self.orders.reference_limited = self.orders.reference != wanted;
        self.orders.reference_from_link = match self.source {
            Source::Held => !self.autonomous,
            Source::Link => true,
            Source::Experiment { autonomous, .. } => !autonomous,
        };
        let mut orders = self.orders;
        if orders.request == Request::SetPosition {
            orders.reference = self.new_position;
        }
        self.orders.request = Request::None;
        orders
    }

    /// The reference before soft limits.
    fn wanted(&mut self, offset: impl FnOnce() -> Option<Offset>) -> Counts {
        match self.source {
            Source::Held | Source::Link => self.profile.next(self.target),
            Source::Experiment { base, .. } => match offset() {
                Some(Offset::Counts(offset)) => Counts(base.0.saturating_add(offset.0)),
                Some(Offset::End) => {
                    self.leave_experiment();
                    self.orders.reference
                }
                None => self.orders.reference,
            },
        }
    }

    fn leave_experiment(&mut self) {
        if matches!(self.source, Source::Experiment { .. }) {
            self.rest_at(self.orders.reference);
            self.source = Source::Held;
        }
    }

    fn rest_at(&mut self, reference: Counts) {
        self.orders.reference = reference;
        self.target = reference;
        self.profile = Profile::at(reference);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Config, Params};

    fn limits() -> MotionLimits {
        *Params::new(&Config::default()).unwrap().motion()
    }

    fn orders(commander: &mut Commander, state: &State, offsets: &mut impl Iterator<Item = Offset>) -> Orders {
        commander.orders(state, &limits(), || offsets.next())
    }

    fn idle(commander: &mut Commander, state: &State) -> Orders {
        orders(commander, state, &mut core::iter::empty())
    }

    #[test]
    fn silence_counts_ticks_since_the_last_word() {
        let mut commander = Commander::new(Faults::empty(), 3);
        assert!(!idle(&mut commander, &State::default()).link_alive, "nothing was heard yet");
        commander.heard();
        let ticks = [(); 4].map(|()| idle(&mut commander, &State::default()).link_alive);
        assert_eq!(ticks, [true, true, false, false]);
    }

    #[test]
    fn a_request_lasts_one_tick_and_clearing_forgets_the_reset() {
        let mut commander = Commander::new(Faults::ABNORMAL_RESET, 500);
        let state = State::default();
        assert_eq!(idle(&mut commander, &state).reported, Faults::ABNORMAL_RESET);
        commander.request(Request::ClearFault);
        let clearing = idle(&mut commander, &state);
        assert_eq!((clearing.request, clearing.reported), (Request::ClearFault, Faults::empty()));
        assert_eq!(idle(&mut commander, &state).request, Request::None);
    }

    #[test]
    fn a_disable_wins_over_an_enable_of_the_same_tick() {
        let mut commander = Commander::new(Faults::empty(), 500);
        for (first, second) in [(Request::Disable, Request::Enable), (Request::Enable, Request::Disable)] {
            commander.request(first);
            commander.request(second);
            assert_eq!(idle(&mut commander, &State::default()).request, Request::Disable, "{first:?}, {second:?}");
        }
    }

    #[test]
    fn an_experiment_adds_to_the_reference_waits_for_values_and_ends() {
        let running = State::running_at(Counts(100));
        let mut commander = Commander::new(Faults::empty(), 500);
        commander.follow(Counts(1000), &limits(), &Pace::default(), 0);
        assert!(idle(&mut commander, &running).reference_from_link);
        for _ in 0..200 {
            idle(&mut commander, &running);
        }
        commander.experiment(true, 0);
        let mut offsets = [Offset::Counts(Counts(5)), Offset::Counts(Counts(-7))].into_iter();
        let references = [(); 3].map(|()| orders(&mut commander, &running, &mut offsets).reference.0);
        assert_eq!(references, [1005, 993, 993]);
        let mut end = [Offset::End, Offset::Counts(Counts(9))].into_iter();
        let last = [(); 2].map(|()| orders(&mut commander, &running, &mut end));
        assert_eq!(last.map(|orders| orders.reference.0), [993; 2]);
    }

    #[test]
    fn every_source_of_motion_needs_the_link_unless_it_was_asked_for_without() {
        let running = State::running_at(Counts(0));
        for autonomous in [false, true] {
            let mut commander = Commander::new(Faults::empty(), 500);
            let supervised = |commander: &mut Commander| idle(commander, &running).reference_from_link;
            commander.enable(autonomous);
            assert_eq!(supervised(&mut commander), !autonomous, "enabled");
            commander.experiment(autonomous, 0);
            assert_eq!(supervised(&mut commander), !autonomous, "experiment");
            commander.hold(autonomous);
            assert_eq!(supervised(&mut commander), !autonomous, "hold");
            commander.follow(Counts(9), &limits(), &Pace::default(), 0);
            assert!(supervised(&mut commander), "a reference from the link always");
        }
    }

    #[test]
    fn a_reference_moves_within_speed_and_soft_limits_and_a_hold_slows_it_down() {
        let config = Config { position_max_rad: 0.1, ..Config::default() };
        let limits = *Params::new(&config).unwrap().motion();
        let running = State { homed: true, ..State::running_at(Counts(0)) };
        let mut commander = Commander::new(Faults::empty(), 500);
        let pace = Pace { speed_rad_s: 1.0, acceleration_rad_s2: 100.0 };
        commander.follow(Counts(100_000), &limits, &pace, 5);
        let mut last = Orders::default();
        for _ in 0..1000 {
            let now = commander.orders(&running, &limits, || None);
            assert!((now.reference.0 - last.reference.0).abs() <= 40, "1 rad/s are 39.1 counts a tick");
            last = now;
        }
        assert_eq!((last.reference, last.reference_limited, last.torque_bound_nm), (limits.high, true, 5));
        commander.follow(Counts(-50_000), &limits, &pace, 0);
        (0..100).for_each(|_| last = commander.orders(&running, &limits, || None));
        commander.hold(true);
        let held: [i32; 100] = core::array::from_fn(|_| commander.orders(&running, &limits, || None).reference.0);
        assert!((held[0] - last.reference.0).abs() <= 40 && held[60] == held[99], "{held:?}");
    }

    #[test]
    fn a_drive_that_stops_forgets_where_it_was_sent() {
        let mut commander = Commander::new(Faults::empty(), 500);
        commander.follow(Counts(1000), &limits(), &Pace::default(), 3);
        let stopped = idle(&mut commander, &State::default());
        assert_eq!((stopped.reference, stopped.torque_bound_nm), (Counts(0), 0));
        assert_eq!(idle(&mut commander, &State::running_at(Counts(0))).reference, Counts(0));
    }

    #[test]
    fn a_new_position_is_told_in_one_tick_only() {
        let mut commander = Commander::new(Faults::empty(), 500);
        commander.set_position(Counts(77));
        let told = idle(&mut commander, &State::default());
        assert_eq!((told.request, told.reference), (Request::SetPosition, Counts(77)));
        assert_eq!(idle(&mut commander, &State::default()).reference, Counts(0));
    }
}
