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
//! again. What cannot be understood is dropped and counted ([`Counters`]); it never reaches a tick.
//!
//! [`Server`] is the drive's side without its hardware, [`Commander`] what it leaves for the ticks.

mod commander;
mod framing;
mod server;

pub use commander::{Commander, Offset};
pub use framing::{Malformed, Receiver, TooLong, encode};
pub use server::{Drive, Server};

use serde::{Deserialize, Serialize};

use crate::experiment::Experiment;

/// Baud rate, 8N1.
pub const BAUD: u32 = 921_600;
/// Version of the messages; another one is refused.
pub const PROTOCOL: u16 = 2;
/// Longest packet as it is sent, the zero included.
pub const PACKET_BYTES: usize = 128;
/// The drive trips when the reference comes from the link and nothing was heard for this long, s.
pub const SILENCE_S: f32 = 0.25;

/// What the drive is asked to do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Opens a session; session and sequence of the packet are ignored. Forgets parameters that were staged and not
    /// applied.
    Hello,
    /// Ready to running.
    Enable,
    /// Running to ready.
    Disable,
    /// Brings chips that failed up again, and leaves the fault state once no cause is left.
    ClearFault,
    /// Reference position, counts; only while running. From then on silence of the link is a fault.
    Reference {
        /// Counts, unwrapped across pole pairs.
        counts: i32,
    },
    /// The reference stays where it is, and silence of the link is no fault; ends an experiment.
    Hold,
    /// Runs an experiment from where the axis stands; only while running.
    Run(Experiment),
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
    Apply,
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
    },
    /// Ends the recording.
    StopRecording,
    /// Asks for a [`Status`].
    Status,
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
            Self::NothingStored => "the flash holds no parameters of this version",
            Self::Storage => "the flash could not be written or read",
            Self::Hardware => "a chip did not come up: see the log, check its supply and wiring",
            Self::Booting => "the drive is booting: ask again in a moment",
            Self::Fault => "a fault is latched: read the status, remove its cause, clear it",
            Self::NoFault => "there is no fault to clear",
            Self::InterlockOpen => "the high-voltage interlock is open: close it",
            Self::StopPressed => "the emergency stop is pressed: release it",
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

/// How the drive is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// Tick.
    pub tick: u32,
    /// 0 boot, 1 ready, 2 running, 3 fault.
    pub state: u8,
    /// Latched faults, bits of [`crate::Faults`].
    pub faults: u16,
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
        /// [`PROTOCOL`].
        protocol: u16,
        /// Layout of the telemetry frame.
        frame_schema: u8,
        /// Number of parameters.
        parameters: u8,
        /// Which image it is.
        build: [u8; 8],
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
}

/// An answer, and to what.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// Sequence number of the packet it answers.
    pub sequence: u32,
    /// The answer.
    pub answer: Answer,
}
