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
//! out. What cannot be understood is dropped and counted ([`Counters`]); it never reaches a tick.

use serde::{Deserialize, Serialize};

use crate::experiment::Experiment;

/// Baud rate, 8N1.
pub const BAUD: u32 = 921_600;
/// Version of the messages; another one is refused.
pub const PROTOCOL: u16 = 1;
/// Longest packet as it is sent, the zero included.
pub const PACKET_BYTES: usize = 128;
/// The drive trips when the reference comes from the link and nothing was heard for this long, s.
pub const SILENCE_S: f32 = 0.25;

const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);
const CRC_BYTES: usize = 4;

/// What the drive is asked to do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Opens a session; session and sequence of the packet are ignored.
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
    /// Packets of another session, or sent before.
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

/// A message that does not fit a packet; none of this module's does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooLong;

/// A message as it is sent.
///
/// # Errors
///
/// A message that is longer than a packet.
pub fn encode<'a>(message: &impl Serialize, packet: &'a mut [u8; PACKET_BYTES]) -> Result<&'a [u8], TooLong> {
    let mut plain = [0; PACKET_BYTES];
    let length = postcard::to_slice(message, &mut plain[..PACKET_BYTES - CRC_BYTES]).map_err(|_| TooLong)?.len();
    let check = CRC.checksum(plain.get(..length).ok_or(TooLong)?).to_le_bytes();
    let end = length + CRC_BYTES;
    plain.get_mut(length..end).ok_or(TooLong)?.copy_from_slice(&check);
    // Stuffing adds a byte here (a packet is shorter than 254), and the zero another.
    if end + 2 > PACKET_BYTES {
        return Err(TooLong);
    }
    let stuffed = cobs::try_encode(plain.get(..end).ok_or(TooLong)?, packet).map_err(|_| TooLong)?;
    *packet.get_mut(stuffed).ok_or(TooLong)? = 0;
    packet.get(..=stuffed).ok_or(TooLong)
}

/// Why bytes between two zeros are no message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Malformed {
    /// More bytes than a packet has.
    Overlong,
    /// Cut short, damaged, or no message.
    Damaged,
}

/// Finds packets in a stream of bytes.
#[derive(Debug)]
pub struct Receiver {
    bytes: [u8; PACKET_BYTES],
    length: usize,
}

impl Default for Receiver {
    fn default() -> Self {
        Self { bytes: [0; PACKET_BYTES], length: 0 }
    }
}

impl Receiver {
    /// Takes a byte; gives what ended with it, if anything did. Two zeros in a row are nothing.
    pub fn push<T: for<'de> Deserialize<'de>>(&mut self, byte: u8) -> Option<Result<T, Malformed>> {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            // One beyond the end says that there was too much.
            self.length = (self.length + 1).min(PACKET_BYTES + 1);
            return None;
        }
        match core::mem::take(&mut self.length) {
            0 => None,
            length => Some(self.bytes.get_mut(..length).ok_or(Malformed::Overlong).and_then(decode)),
        }
    }
}

fn decode<T: for<'de> Deserialize<'de>>(stuffed: &mut [u8]) -> Result<T, Malformed> {
    let length = cobs::decode_in_place(stuffed).map_err(|_| Malformed::Damaged)?;
    let plain = stuffed.get(..length).ok_or(Malformed::Damaged)?;
    let (message, check) = plain.split_last_chunk::<CRC_BYTES>().ok_or(Malformed::Damaged)?;
    if CRC.checksum(message) != u32::from_le_bytes(*check) {
        return Err(Malformed::Damaged);
    }
    match postcard::take_from_bytes(message) {
        Ok((message, [])) => Ok(message),
        _ => Err(Malformed::Damaged),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::experiment::Shape;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn sent(message: &impl Serialize) -> Vec<u8> {
        encode(message, &mut [0; PACKET_BYTES]).unwrap().to_vec()
    }

    fn received<T: for<'de> Deserialize<'de>>(bytes: &[u8]) -> Vec<Result<T, Malformed>> {
        let mut receiver = Receiver::default();
        bytes.iter().filter_map(|byte| receiver.push(*byte)).collect()
    }

    fn longest() -> Reply {
        let counters = Counters {
            packets: u32::MAX,
            damaged: u32::MAX,
            overlong: u32::MAX,
            replayed: u32::MAX,
            refused: u32::MAX,
        };
        let status = Status {
            tick: u32::MAX,
            state: 3,
            faults: u16::MAX,
            resolver_faults: 0xFF,
            flags: 0xFF,
            position: i32::MIN,
            reference: i32::MIN,
            torque_nm: -30.0,
            field_kv_mm: 3.5,
            monitor: 4095,
            worst_cycles: u32::MAX,
            lost: u16::MAX,
            recording: true,
            counters,
        };
        Reply { sequence: u32::MAX, answer: Answer::Status(status) }
    }

    #[test]
    fn every_kind_of_message_goes_through() {
        let shape = Shape::Multisine { amplitude_rad: 0.3, low_hz: 0.5, high_hz: 8.0, tones: 16 };
        let commands = [
            Command::Hello,
            Command::Reference { counts: i32::MIN },
            Command::WriteParameter { index: 255, value: f32::MAX },
            Command::Run(Experiment { shape, duration_s: 10.0 }),
            Command::StartRecording { run: u32::MAX },
        ];
        for command in commands {
            let packet = Packet { session: u32::MAX, sequence: u32::MAX, command };
            assert_eq!(received(&sent(&packet)), [Ok(packet)]);
        }
        assert_eq!(received(&sent(&longest())), [Ok(longest())]);
    }

    #[test]
    fn a_single_flipped_bit_is_always_seen() {
        let packet = Packet { session: 7, sequence: 8, command: Command::Reference { counts: 40_960 } };
        let good = sent(&packet);
        for bit in 0..good.len() * 8 {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes.push(0);
            assert!(!received::<Packet>(&bytes).contains(&Ok(packet)));
        }
    }

    #[test]
    fn what_follows_damage_is_received() {
        let packet = Packet { session: 1, sequence: 2, command: Command::Enable };
        let mut bytes = std::vec![0x55; 1000];
        bytes.push(0);
        bytes.extend_from_slice(&sent(&packet)[2..]);
        bytes.extend_from_slice(&sent(&packet));
        assert_eq!(received(&bytes), [Err(Malformed::Overlong), Err(Malformed::Damaged), Ok(packet)]);
    }

    proptest! {
        #[test]
        fn any_bytes_give_messages_or_counts(bytes: Vec<u8>) {
            let ends = bytes.iter().filter(|byte| **byte == 0).count();
            prop_assert!(received::<Packet>(&bytes).len() <= ends);
            prop_assert!(received::<Reply>(&bytes).len() <= ends);
        }
    }
}
