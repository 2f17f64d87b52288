//! The command link: what is said over USART2, and how it is framed.
//!
//! A packet is a postcard message with a CRC-32 behind it, stuffed by COBS, ended by a zero byte:
//!
//! ```text
//! COBS( postcard(Packet or Reply), CRC-32 little-endian ) 0x00
//! ```
//!
//! A [`Command::Hello`] opens a session; the drive chooses its number. Every later packet carries that number and a
//! sequence number above the last one, so that neither a packet of an earlier session nor one that is sent twice is carried
//! out. The last packet of a session may be sent again when its answer was lost: it is answered again, not carried out
//! again. While the client of a session is heard of and the drive moves, another client only gets a session that may read,
//! and stop the drive. What cannot be understood is dropped and counted ([`Counters`]); it never reaches a tick.
//!
//! [`Server`] is the drive's side without its hardware, [`Commander`] what it leaves for the ticks.

mod commander;
mod drive;
mod framing;
mod numbers;
mod server;

pub use commander::{Commander, Offset};
pub use drive::Drive;
pub use framing::{Malformed, Received, Receiver, TooLong, encode, encode_telemetry};
pub use numbers::Neighbours;
pub use server::Server;

use serde::{Deserialize, Serialize};

use crate::events::Event;
use crate::experiment::Experiment;
pub use crate::motion::Pace;
use crate::{Config, ConfigError, Params};

/// Baud rate, 8N1.
pub const BAUD: u32 = 921_600;
/// Version of the messages; another one is refused.
pub const PROTOCOL: u16 = 6;
/// Longest packet as it is sent, the zero included.
pub const PACKET_BYTES: usize = 128;
/// Longest packet of telemetry as it is sent.
pub const TELEMETRY_BYTES: usize = 256;
/// What it carries at most: without the check, the byte that stuffing adds to less than 254, and the zero.
pub const TELEMETRY_PLAIN_BYTES: usize = 248;
/// The drive stops when the client that commands it was not heard of for this long, s, unless it was asked to go on alone.
pub const SILENCE_S: f32 = 0.25;

/// What the drive is asked to do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Opens a session; session and sequence of the packet are ignored. Forgets parameters that were staged and not
    /// applied.
    Hello,
    /// Ends the session: another client need not wait until this one is silent.
    Bye,
    /// Ready to running.
    Enable {
        /// The link may be silent while the reference stays.
        autonomous: bool,
    },
    /// Running to ready, through a stop of the axis where the parameters say so. Any session may.
    Disable,
    /// Brings chips that failed up again, and leaves the fault state once no cause is left. Where the event log is full, which
    /// takes hundreds of faults, it is tidied before: ticks pause for up to a second, and the position is lost.
    ClearFault,
    /// Calls the position by another name, from which on the axis is homed; only while ready.
    SetPosition {
        /// What the position is now, counts.
        counts: i32,
    },
    /// Sends the reference somewhere; only while running. From then on silence of the link is a fault.
    Reference {
        /// Where to.
        target: Target,
        /// How fast.
        pace: Pace,
        /// Greatest torque until the next command, whole N m; 0 for no bound but the parameter's.
        torque_bound_nm: u8,
    },
    /// The reference slows down and stays; ends an experiment.
    Hold {
        /// The link may be silent from then on.
        autonomous: bool,
    },
    /// Runs an experiment from where the reference is; only while running.
    Run {
        /// Which.
        experiment: Experiment,
        /// Greatest torque meanwhile, whole N m; 0 for no bound but the parameter's.
        torque_bound_nm: u8,
        /// The link may be silent meanwhile.
        autonomous: bool,
    },
    /// Reads a parameter of the staged set, by its index in [`crate::parameters::TABLE`].
    ReadParameter {
        /// Index.
        index: u8,
    },
    /// Writes a parameter of the staged set; it acts with [`Command::Apply`].
    WriteParameter {
        /// Index.
        index: u8,
        /// Value in the parameter's unit.
        value: f32,
    },
    /// Makes the staged parameters those of the law; neither while running nor while recording.
    Apply {
        /// Even if the loop would be unstable or near it; this is logged.
        force: bool,
    },
    /// Stages the parameters the image was built with.
    Defaults,
    /// Stages the parameters in flash.
    Load,
    /// Writes the parameters of the law to flash; only while not running. Ticks pause for up to a second.
    Save,
    /// Starts a recording under a run number.
    StartRecording {
        /// Told in the recording.
        run: u32,
        /// Over this link, as [`crate::telemetry`], in place of the log.
        over_link: bool,
    },
    /// Ends the recording.
    StopRecording,
    /// Asks for a [`Status`].
    Status,
    /// Asks for a fault of the event log.
    Event {
        /// 0 for the newest, and so on back.
        back: u8,
    },
}

/// Where a reference goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Target {
    /// To a position, counts; only once the axis is homed.
    Absolute(i32),
    /// So many counts on from where it was going.
    Relative(i32),
}

/// A command in its session.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Packet {
    /// The session, from [`Answer::Hello`].
    pub session: u32,
    /// Above that of the packet before.
    pub sequence: u32,
    /// The command.
    pub command: Command,
}

/// Why a command was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The session is another one, or none is open: send [`Command::Hello`].
    Session,
    /// Only while running.
    NotRunning,
    /// Not while running.
    Running,
    /// Not while recording.
    Recording,
    /// No parameter of that index.
    Index,
    /// The parameter is out of its range, or does not fit the others.
    Value,
    /// Flash holds no parameters, or those of another version.
    NothingStored,
    /// Flash could not be written or read.
    Storage,
    /// A chip did not come up again.
    Hardware,
    /// The chips still settle.
    Booting,
    /// A fault is latched.
    Fault,
    /// There is no fault to clear.
    NoFault,
    /// The high-voltage interlock is open.
    InterlockOpen,
    /// The emergency stop is pressed.
    StopPressed,
    /// The motor's amplifier is not ready.
    AmplifierNotReady,
    /// Only while ready.
    NotReady,
    /// The position does not count from the user's zero.
    NotHomed,
    /// The reference is beyond the soft limits.
    BeyondLimits,
    /// Another client commands the drive.
    Observer,
    /// The parameters would make the loop unstable, or nearly.
    Unstable,
    /// The image has another value built in.
    BuiltIn,
    /// The stored parameters are damaged.
    ParametersDamaged,
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Session => "no session, or another one was opened since: say hello again",
            Self::NotRunning => "the drive is not running: enable it first",
            Self::Running => "the drive is running: disable it first",
            Self::Recording => "a recording runs: stop it first",
            Self::Index => "there is no parameter of that index",
            Self::Value => "the value is out of its range or does not fit the other parameters",
            Self::NothingStored => "the flash holds no parameters, or none that this image can use",
            Self::Storage => "the flash could not be written or read",
            Self::Hardware => "a chip did not come up: see the log, check its supply and wiring",
            Self::Booting => "the drive is booting: ask again in a moment",
            Self::Fault => "a fault is latched: read the status, remove its cause, clear it",
            Self::NoFault => "there is no fault to clear",
            Self::InterlockOpen => "the high-voltage interlock is open: close it",
            Self::StopPressed => "the emergency stop is pressed: release it",
            Self::AmplifierNotReady => "the motor's amplifier is not ready: check its supply, let it cool",
            Self::NotReady => "only while the drive is ready: disable it, or clear its fault, first",
            Self::NotHomed => "the axis is not homed: set its position first, or move it relative to where it is",
            Self::BeyondLimits => "beyond position_min_rad or position_max_rad",
            Self::Observer => "another client commands the drive: it may be read and stopped, nothing else",
            Self::Unstable => "the loop would be unstable, or nearly: see the margins of the gains, or force it",
            Self::BuiltIn => "period_s and speed_from_converter are built into the image and cannot be set",
            Self::ParametersDamaged => "the stored parameters are damaged: write a full set and apply it first",
        })
    }
}

impl core::error::Error for Refusal {}

/// What became of the bytes on the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Packets carried out or refused.
    pub packets: u32,
    /// Packets that were cut short, damaged, or no message.
    pub damaged: u32,
    /// Runs of bytes too long for a packet.
    pub overlong: u32,
    /// Packets of another session, or sent before; none of them is carried out, nor keeps the link alive.
    pub replayed: u32,
    /// Commands that were refused.
    pub refused: u32,
}

/// Where the parameters of the law came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ParameterSource {
    /// The image: the flash is empty, or the link asked for them.
    BuiltIn,
    /// The flash.
    Flash,
    /// The link; they are gone with the next reset unless they are saved.
    Link,
    /// The link, against the advice of the stability margins.
    Forced,
    /// The flash, where it was saved although it had been forced against the advice of the stability margins.
    StoredForced,
    /// The image, because what the flash holds is damaged or of another release.
    Damaged,
    /// An older set in flash, because the newest is of another release.
    RolledBack,
}

impl ParameterSource {
    /// Of a set that is in flash. A record does not say whether it was forced; its margins do.
    pub fn stored(config: &Config) -> Self {
        match Params::for_image(config, false) {
            Err(ConfigError::Unstable(_)) => Self::StoredForced,
            _ => Self::Flash,
        }
    }
}

impl core::fmt::Display for ParameterSource {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::BuiltIn => "built in",
            Self::Flash => "flash",
            Self::Link => "link, not saved",
            Self::Forced => "link, forced against the stability margins, not saved",
            Self::StoredForced => "flash, forced against the stability margins",
            Self::Damaged => "built in, because the flash holds a damaged or foreign set",
            Self::RolledBack => "an older set in flash, because the newest is of another release",
        })
    }
}

/// How the drive is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Tick.
    pub tick: u32,
    /// 0 boot, 1 ready, 2 running, 3 fault, 4 stopping.
    pub state: u8,
    /// Latched faults, bits of [`crate::Faults`].
    pub faults: u32,
    /// Fault byte of the resolver converter.
    pub resolver_faults: u8,
    /// Input flags, bits of [`crate::InputFlags`].
    pub flags: u8,
    /// Position, counts.
    pub position: i32,
    /// Reference, counts.
    pub reference: i32,
    /// Torque command, N m.
    pub torque_nm: f32,
    /// Field command, kV/mm.
    pub field_kv_mm: f32,
    /// Field at the monitor, code.
    pub monitor: u16,
    /// Worst cycle count of a tick.
    pub worst_cycles: u32,
    /// Frames the log lost.
    pub lost: u16,
    /// Whether a recording runs.
    pub recording: bool,
    /// Whether the position counts from the user's zero.
    pub homed: bool,
    /// Where the parameters of the law came from.
    pub parameters: ParameterSource,
    /// The link itself.
    pub counters: Counters,
}

/// What the drive answers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// The session is open.
    Hello {
        /// Number of the session.
        session: u32,
        /// The session may read and stop the drive, as another client commands it.
        observer: bool,
        /// [`PROTOCOL`].
        protocol: u16,
        /// Layout of the telemetry frame.
        frame_schema: u8,
        /// Number of parameters.
        parameters: u8,
        /// Which image it is.
        build: [u8; 8],
        /// From the sampling of the position until the outputs change, ns.
        sample_to_output_ns: u32,
    },
    /// Carried out.
    Done,
    /// Not carried out.
    Refused(Refusal),
    /// A parameter.
    Parameter {
        /// Value in the parameter's unit.
        value: f32,
    },
    /// How the drive is.
    Status(Status),
    /// A fault of the event log; none where there are fewer.
    Event(Option<Event>),
}

/// An answer, and to what.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Sequence number of the packet it answers.
    pub sequence: u32,
    /// The answer.
    pub answer: Answer,
}
