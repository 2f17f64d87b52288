//! The telemetry frame: everything one tick read and decided, 48 bytes, little-endian.
//!
//! | bytes | content |
//! |---|---|
//! | 0 | schema, [`FRAME_SCHEMA`] |
//! | 1 | CRC-8 (polynomial 0x07) of all other bytes |
//! | 2..4 | frames lost so far, saturating |
//! | 4..8 | sequence number of the tick |
//! | 8..10 | resolver code |
//! | 10 | resolver fault byte |
//! | 11 | input flags |
//! | 12..16 | reference, counts |
//! | 16..20 | position, counts |
//! | 20..24 | speed the law used, rad/s, f32 |
//! | 24..28 | torque command, N m, f32 |
//! | 28..32 | field command, kV/mm, f32 |
//! | 32..34 | field monitor code |
//! | 34 | low nibble mode, high nibble state of the drive |
//! | 35 | low 3 bits request, high 5 bits torque bound of the command, N m |
//! | 36..39 | faults reported to the law, 24 bit |
//! | 39 | limits |
//! | 40..43 | latched faults, 24 bit |
//! | 43..46 | cycles of this tick, 24 bit, saturating |
//! | 46..48 | most cycles of any tick so far, in units of 4, saturating |

use crate::law::mode::Mode;
use crate::law::supervisor::{Request, Supervisor};
use crate::step::{InputFlags, Inputs, Outputs, ResolverSample};
use crate::units::{Counts, MonitorCode, ResolverCode};
use crate::{Faults, Limits};

/// Length of an encoded [`Frame`].
pub const FRAME_BYTES: usize = 48;
/// Layout of the bytes; a decoder refuses any other.
pub const FRAME_SCHEMA: u8 = 2;

const CRC: crc::Crc<u8> = crc::Crc::<u8>::new(&crc::CRC_8_SMBUS);

/// Cycle counts of the tick's interrupt, from the cycle counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timing {
    /// This tick, CPU cycles.
    pub cycles: u32,
    /// The most so far; a frame that was encoded has lost the lowest two bits.
    pub worst_cycles: u32,
}

/// One tick: what was read, what was decided. Of the state it leaves out the tick counts of boot and stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Number of the tick since reset.
    pub seq: u32,
    /// Frames the log lost before this one.
    pub lost: u16,
    /// What the law read. The converter's speed is the speed in `outputs` where the law used it, and 0 where not.
    pub inputs: Inputs,
    /// What the law decided.
    pub outputs: Outputs,
    /// How long it took.
    pub timing: Timing,
}

/// Why bytes are no [`Frame`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Not [`FRAME_BYTES`] bytes.
    Length(usize),
    /// Another layout, older or newer.
    Schema(u8),
    /// Damaged on the way.
    Check,
    /// A value at this byte that no tick can have written.
    Value(usize),
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length(length) => write!(f, "a frame has {FRAME_BYTES} bytes, not {length}"),
            Self::Schema(schema) => write!(f, "frame schema {schema}, this decoder reads {FRAME_SCHEMA}"),
            Self::Check => write!(f, "frame damaged: its check does not match"),
            Self::Value(at) => write!(f, "impossible value at byte {at} of the frame"),
        }
    }
}

impl core::error::Error for FrameError {}

impl Frame {
    /// The frame as bytes.
    pub fn encode(&self) -> [u8; FRAME_BYTES] {
        let (inputs, outputs) = (&self.inputs, &self.outputs);
        let (drive, request) = (drive_code(outputs.supervisor), request_code(inputs.request));
        let mut bytes = [0; FRAME_BYTES];
        bytes[0] = FRAME_SCHEMA;
        bytes[2..4].copy_from_slice(&self.lost.to_le_bytes());
        bytes[4..8].copy_from_slice(&self.seq.to_le_bytes());
        bytes[8..10].copy_from_slice(&inputs.resolver.code.0.to_le_bytes());
        bytes[10] = inputs.resolver.fault_byte;
        bytes[11] = inputs.flags.bits();
        bytes[12..16].copy_from_slice(&inputs.reference.0.to_le_bytes());
        bytes[16..20].copy_from_slice(&outputs.position.0.to_le_bytes());
        bytes[20..24].copy_from_slice(&outputs.speed_rad_s.to_le_bytes());
        bytes[24..28].copy_from_slice(&outputs.torque_nm.to_le_bytes());
        bytes[28..32].copy_from_slice(&outputs.field_kv_mm.to_le_bytes());
        bytes[32..34].copy_from_slice(&inputs.field_monitor.0.to_le_bytes());
        bytes[34] = mode_code(outputs.mode) | drive << 4;
        bytes[35] = request | (inputs.torque_bound_nm & 0x1f) << 3;
        bytes[36..39].copy_from_slice(&low24(inputs.reported.bits()));
        bytes[39] = outputs.limits.bits();
        bytes[40..43].copy_from_slice(&low24(outputs.supervisor.faults().bits()));
        bytes[43..46].copy_from_slice(&low24(self.timing.cycles));
        bytes[46..48].copy_from_slice(&((self.timing.worst_cycles / 4).min(0xffff) as u16).to_le_bytes());
        bytes[1] = check(&bytes);
        bytes
    }

    /// The frame those bytes stand for.
    ///
    /// # Errors
    /// See [`FrameError`]; any byte sequence whatever is a frame or an error.
    pub fn decode(bytes: &[u8]) -> Result<Self, FrameError> {
        let bytes: &[u8; FRAME_BYTES] = bytes.try_into().map_err(|_| FrameError::Length(bytes.len()))?;
        if bytes[0] != FRAME_SCHEMA {
            return Err(FrameError::Schema(bytes[0]));
        }
        if bytes[1] != check(bytes) {
            return Err(FrameError::Check);
        }
        let outputs = decode_outputs(bytes)?;
        Ok(Self {
            seq: word(bytes, 4),
            lost: half(bytes, 2),
            inputs: decode_inputs(bytes, &outputs)?,
            outputs,
            timing: Timing { cycles: word24(bytes, 43), worst_cycles: 4 * u32::from(half(bytes, 46)) },
        })
    }
}

fn decode_inputs(bytes: &[u8; FRAME_BYTES], outputs: &Outputs) -> Result<Inputs, FrameError> {
    Ok(Inputs {
        resolver: ResolverSample {
            code: ResolverCode(half(bytes, 8)),
            fault_byte: bytes[10],
            speed_rad_s: outputs.speed_rad_s,
        },
        flags: InputFlags::from_bits(bytes[11]).ok_or(FrameError::Value(11))?,
        reference: Counts(word(bytes, 12) as i32),
        request: match bytes[35] & 0b111 {
            0 => Request::None,
            1 => Request::Enable,
            2 => Request::Disable,
            3 => Request::ClearFault,
            4 => Request::SetPosition,
            _ => return Err(FrameError::Value(35)),
        },
        torque_bound_nm: bytes[35] >> 3,
        field_monitor: MonitorCode(half(bytes, 32)),
        reported: Faults::from_bits(word24(bytes, 36)).ok_or(FrameError::Value(36))?,
    })
}

fn decode_outputs(bytes: &[u8; FRAME_BYTES]) -> Result<Outputs, FrameError> {
    let finite = |at: usize| {
        let value = f32::from_bits(word(bytes, at));
        if value.is_finite() { Ok(value) } else { Err(FrameError::Value(at)) }
    };
    let faults = Faults::from_bits(word24(bytes, 40)).ok_or(FrameError::Value(40))?;
    let supervisor = match bytes[34] >> 4 {
        0 => Supervisor::Boot { ticks: 0 },
        1 => Supervisor::Ready,
        2 => Supervisor::Running,
        3 => Supervisor::Fault { faults },
        4 => Supervisor::Stopping { faults },
        _ => return Err(FrameError::Value(34)),
    };
    Ok(Outputs {
        torque_nm: finite(24)?,
        field_kv_mm: finite(28)?,
        mode: match bytes[34] & 0x0f {
            0 => Mode::Off,
            1 => Mode::Damper,
            2 => Mode::Brake,
            _ => return Err(FrameError::Value(34)),
        },
        hv_enable: matches!(supervisor, Supervisor::Running | Supervisor::Stopping { .. }),
        position: Counts(word(bytes, 16) as i32),
        speed_rad_s: finite(20)?,
        supervisor,
        limits: Limits::from_bits(bytes[39]).ok_or(FrameError::Value(39))?,
    })
}

fn mode_code(mode: Mode) -> u8 {
    match mode {
        Mode::Off => 0,
        Mode::Damper => 1,
        Mode::Brake => 2,
    }
}

fn drive_code(supervisor: Supervisor) -> u8 {
    match supervisor {
        Supervisor::Boot { .. } => 0,
        Supervisor::Ready => 1,
        Supervisor::Running => 2,
        Supervisor::Fault { .. } => 3,
        Supervisor::Stopping { .. } => 4,
    }
}

fn request_code(request: Request) -> u8 {
    match request {
        Request::None => 0,
        Request::Enable => 1,
        Request::Disable => 2,
        Request::ClearFault => 3,
        Request::SetPosition => 4,
    }
}

fn check(bytes: &[u8; FRAME_BYTES]) -> u8 {
    let mut digest = CRC.digest();
    digest.update(&bytes[..1]);
    digest.update(&bytes[2..]);
    digest.finalize()
}

fn low24(value: u32) -> [u8; 3] {
    let [low, middle, high, _] = value.min(0x00ff_ffff).to_le_bytes();
    [low, middle, high]
}

fn word(bytes: &[u8; FRAME_BYTES], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn word24(bytes: &[u8; FRAME_BYTES], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], 0])
}

fn half(bytes: &[u8; FRAME_BYTES], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}
