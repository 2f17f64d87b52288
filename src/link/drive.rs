//! What the link's server asks of a drive.

use super::{Pace, Refusal};
use crate::events::Event;
use crate::experiment::Sequence;
use crate::motion::MotionLimits;
use crate::storage::StorageError;
use crate::{Config, Counts, Frame, Params, Request, State, Supervisor};

/// What the commands act on: the image's tick, log and flash; in tests a stand-in.
pub trait Drive {
    /// Which image it is.
    fn build(&self) -> [u8; 8];
    /// A number nobody can guess, for a session.
    fn random(&mut self) -> u32;
    /// State of the law before the next tick.
    fn state(&self) -> State;
    /// The last tick; none before the first.
    fn last_frame(&self) -> Option<Frame>;
    /// A packet of the client that commands came in: the link is alive.
    fn heard(&mut self);
    /// Whether that client was heard of recently.
    fn link_alive(&self) -> bool;
    /// Makes a request in the next tick.
    fn request(&mut self, request: Request);
    /// Asks for an enable; with `autonomous` the link may be silent while the reference stays.
    fn enable(&mut self, autonomous: bool);
    /// Calls the position by another name.
    fn set_position(&mut self, position: Counts);
    /// Where the reference is going.
    fn target(&self) -> Counts;
    /// Sends the reference there.
    fn follow(&mut self, target: Counts, pace: &Pace, torque_bound_nm: u8);
    /// The reference slows down and stays; an experiment ends.
    fn hold(&mut self, autonomous: bool);
    /// Runs an experiment from where the reference is.
    fn run(&mut self, sequence: Sequence, torque_bound_nm: u8, autonomous: bool);
    /// Brings the chips up again.
    ///
    /// # Errors
    /// [`Refusal::Hardware`].
    fn reinitialise(&mut self) -> Result<(), Refusal>;
    /// Replaces the parameters of the law between two ticks; `forced` is for the log.
    ///
    /// # Errors
    /// The state that forbids it.
    fn set_params(&mut self, params: Params, forced: bool) -> Result<(), Supervisor>;
    /// What bounds a reference, from the parameters of the law.
    fn motion(&self) -> MotionLimits;
    /// The parameters in flash.
    ///
    /// # Errors
    /// See [`StorageError`].
    fn load(&mut self) -> Result<Config, StorageError>;
    /// Stores parameters in flash, however long that takes; only asked while not running.
    ///
    /// # Errors
    /// See [`StorageError`].
    fn save(&mut self, config: &Config) -> Result<(), StorageError>;
    /// The newest fault of the event log but `back`; none where there are fewer.
    fn event(&mut self, back: u8) -> Option<Event>;
    /// Makes room in the event log where the next fault would find none, however long that takes: ticks pause and the position
    /// is lost. Only asked in the fault state.
    fn make_room_for_events(&mut self);
    /// Whether a recording runs.
    fn recording(&self) -> bool;
    /// Starts a recording of the law with its parameters, over the link or in the log.
    fn start_recording(&mut self, run: u32, over_link: bool, config: &Config);
    /// Ends the recording, if there is one.
    fn stop_recording(&mut self);
}
