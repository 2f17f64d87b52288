//! Recordings over the command link, without a probe: every tick, packed so that 2 kHz fit beside the answers.
//!
//! | first byte of a packet | what follows |
//! |---|---|
//! | 0, a recording begins | run, 4 bytes; frame schema; build, 8; first tick, 4; state of the law before it, 37; every parameter, 4 each |
//! | 1, frames | the first as it is, 48 bytes; of each later one a mask of 6 bytes and those of its bytes that the mask says differ from the frame before |
//! | 2, the recording has ended | nothing |
//!
//! A frame differs from the one before in 20 to 25 bytes, so that 2,000 a second take two thirds of 921,600 baud. A packet can be
//! read without those before it: one that is lost is a gap of some ticks and nothing more.

use crate::link::{TELEMETRY_BYTES, TELEMETRY_PLAIN_BYTES, encode_telemetry};
use crate::parameters::TABLE;
use crate::{Config, FRAME_BYTES, FRAME_SCHEMA, Frame, Params, STATE_BYTES, State};

const BEGIN: u8 = 0;
const FRAMES: u8 = 1;
const END: u8 = 2;

const MASK_BYTES: usize = FRAME_BYTES / 8;
/// Before the parameters of a begin: kind, run, schema, build, tick, state.
const BEGIN_HEAD_BYTES: usize = 1 + 4 + 1 + 8 + 4 + STATE_BYTES;

const _: () = assert!(BEGIN_HEAD_BYTES + 4 * TABLE.len() <= TELEMETRY_PLAIN_BYTES);

/// What a recording begins with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Begin {
    /// Number the user gave it.
    pub run: u32,
    /// Image that wrote it.
    pub build: [u8; 8],
    /// Its first tick.
    pub tick: u32,
    /// State of the law before that tick.
    pub state: State,
    /// Every parameter.
    pub config: Config,
}

/// A packet, read.
#[derive(Debug, Clone)]
pub enum Part<'a> {
    /// A recording begins.
    Begin(Begin),
    /// Some ticks of it, in order.
    Frames(Frames<'a>),
    /// It has ended.
    End,
}

/// Why a packet whose check is right cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PartError {
    /// Frames of another layout.
    Schema(u8),
    /// So many parameters, which are not those of this release.
    Parameters(usize),
    /// A kind, a length or a value that no drive of this release sends.
    Malformed,
}

impl Begin {
    /// As it is sent.
    pub fn encode<'a>(&self, packet: &'a mut [u8; TELEMETRY_BYTES]) -> &'a [u8] {
        let mut plain = [0; TELEMETRY_PLAIN_BYTES];
        plain[0] = BEGIN;
        plain[1..5].copy_from_slice(&self.run.to_le_bytes());
        plain[5] = FRAME_SCHEMA;
        plain[6..14].copy_from_slice(&self.build);
        plain[14..18].copy_from_slice(&self.tick.to_le_bytes());
        plain[18..BEGIN_HEAD_BYTES].copy_from_slice(&self.state.encode());
        for (parameter, place) in TABLE.iter().zip(plain[BEGIN_HEAD_BYTES..].as_chunks_mut::<4>().0) {
            *place = (parameter.get)(&self.config).to_le_bytes();
        }
        encode_telemetry(&plain[..BEGIN_HEAD_BYTES + 4 * TABLE.len()], packet)
    }

    fn decode(plain: &[u8]) -> Result<Self, PartError> {
        let (head, values) = plain.split_at_checked(BEGIN_HEAD_BYTES).ok_or(PartError::Malformed)?;
        if head[5] != FRAME_SCHEMA {
            return Err(PartError::Schema(head[5]));
        }
        if values.len() != 4 * TABLE.len() {
            return Err(PartError::Parameters(values.len() / 4));
        }
        let mut config = Config::default();
        for (parameter, value) in TABLE.iter().zip(values.as_chunks::<4>().0) {
            (parameter.set)(&mut config, f32::from_le_bytes(*value));
        }
        // No drive runs with others.
        Params::new(&config).map_err(|_| PartError::Malformed)?;
        let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let mut build = [0; 8];
        build.copy_from_slice(&head[6..14]);
        let state = State::decode(&head[18..]).map_err(|_| PartError::Malformed)?;
        Ok(Self { run: word(1), build, tick: word(14), state, config })
    }
}

/// The end of a recording as it is sent.
pub fn end(packet: &mut [u8; TELEMETRY_BYTES]) -> &[u8] {
    encode_telemetry(&[END], packet)
}

/// A packet of frames that fills.
#[derive(Debug)]
pub struct Packer {
    plain: [u8; TELEMETRY_PLAIN_BYTES],
    length: usize,
    last: [u8; FRAME_BYTES],
}

impl Default for Packer {
    fn default() -> Self {
        Self { plain: [0; TELEMETRY_PLAIN_BYTES], length: 0, last: [0; FRAME_BYTES] }
    }
}

impl Packer {
    /// Takes a frame; false where it does not fit any more, before [`Self::finish`].
    pub fn push(&mut self, frame: &Frame) -> bool {
        let bytes = frame.encode();
        if self.length == 0 {
            self.plain[0] = FRAMES;
            self.plain[1..=FRAME_BYTES].copy_from_slice(&bytes);
            (self.length, self.last) = (1 + FRAME_BYTES, bytes);
            return true;
        }
        let (mut mask, mut changed, mut count) = ([0_u8; MASK_BYTES], [0_u8; FRAME_BYTES], 0);
        for (at, (byte, before)) in bytes.iter().zip(&self.last).enumerate() {
            if byte != before {
                mask[at / 8] |= 1 << (at % 8);
                changed[count] = *byte;
                count += 1;
            }
        }
        let Some(place) = self.plain.get_mut(self.length..self.length + MASK_BYTES + count) else { return false };
        let (masked, rest) = place.split_at_mut(MASK_BYTES);
        masked.copy_from_slice(&mask);
        rest.copy_from_slice(&changed[..count]);
        self.length += MASK_BYTES + count;
        self.last = bytes;
        true
    }

    /// The packet as it is sent, and the next one begins; none without a frame.
    pub fn finish<'a>(&mut self, packet: &'a mut [u8; TELEMETRY_BYTES]) -> Option<&'a [u8]> {
        let length = core::mem::take(&mut self.length);
        let plain = self.plain.get(..length).filter(|plain| !plain.is_empty())?;
        Some(encode_telemetry(plain, packet))
    }
}

/// Reads what a telemetry packet holds.
///
/// # Errors
/// See [`PartError`]; any bytes whatever are a part or an error.
pub fn decode(plain: &[u8]) -> Result<Part<'_>, PartError> {
    match plain {
        [BEGIN, ..] => Begin::decode(plain).map(Part::Begin),
        [FRAMES, rest @ ..] => Ok(Part::Frames(Frames { rest, last: None })),
        [END] => Ok(Part::End),
        _ => Err(PartError::Malformed),
    }
}

/// The frames of a packet; one that is impossible ends them.
#[derive(Debug, Clone)]
pub struct Frames<'a> {
    rest: &'a [u8],
    last: Option<[u8; FRAME_BYTES]>,
}

impl Frames<'_> {
    fn frame(&mut self) -> Option<Frame> {
        let bytes = match self.last {
            None => *self.rest.split_off(..FRAME_BYTES)?.as_array()?,
            Some(mut bytes) => {
                let mask = self.rest.split_off(..MASK_BYTES)?;
                for (at, byte) in bytes.iter_mut().enumerate() {
                    if mask.get(at / 8)? >> (at % 8) & 1 == 1 {
                        *byte = *self.rest.split_off_first()?;
                    }
                }
                bytes
            }
        };
        self.last = Some(bytes);
        Frame::decode(&bytes).ok()
    }
}

impl Iterator for Frames<'_> {
    type Item = Result<Frame, PartError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        let frame = self.frame();
        if frame.is_none() {
            self.rest = &[];
        }
        Some(frame.ok_or(PartError::Malformed))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::{Received, Receiver, Reply};
    use crate::{Counts, Inputs, Timing, step};
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The parts that a stream of bytes holds, one after another.
    fn received(bytes: &[u8], mut take: impl FnMut(Part<'_>)) {
        let mut receiver = Receiver::default();
        for byte in bytes {
            if let Some(Ok(Received::Telemetry(plain))) = receiver.push_any::<Reply>(*byte) {
                take(decode(plain).unwrap());
            }
        }
    }

    /// Ticks of a law that follows a chirp.
    fn frames(count: u32) -> Vec<Frame> {
        let params = Params::new(&Config::default()).unwrap();
        let mut state = State::running_at(Counts(0));
        let tick = |seq: u32| {
            let reference = Counts((3000.0 * libm::sinf(1e-6 * (seq * seq) as f32)) as i32);
            let inputs = Inputs { reference, ..Inputs::default() };
            let timing = Timing { cycles: 2000 + seq % 7, worst_cycles: 2400 };
            Frame { seq, lost: 0, inputs, outputs: step(&params, &mut state, &inputs), timing }
        };
        (0..count).map(tick).collect()
    }

    fn packed(frames: &[Frame]) -> Vec<u8> {
        let (mut packer, mut packet, mut sent) = (Packer::default(), [0; TELEMETRY_BYTES], Vec::new());
        for frame in frames {
            if !packer.push(frame) {
                sent.extend_from_slice(packer.finish(&mut packet).unwrap());
                assert!(packer.push(frame));
            }
        }
        sent.extend_from_slice(packer.finish(&mut packet).unwrap());
        assert!(packer.finish(&mut packet).is_none());
        sent
    }

    #[test]
    fn frames_come_back_to_the_bit_and_two_thousand_a_second_fit_the_line() {
        let frames = frames(4000);
        let sent = packed(&frames);
        let mut back = Vec::new();
        received(&sent, |part| {
            if let Part::Frames(frames) = part {
                back.extend(frames.map(|frame| frame.unwrap().encode()));
            }
        });
        assert_eq!(back, frames.iter().map(Frame::encode).collect::<Vec<_>>());
        let a_tick = sent.len() as f32 / frames.len() as f32;
        assert!(a_tick < 35.0, "{a_tick} bytes of the 46 that the line carries in a tick");
    }

    #[test]
    fn a_lost_packet_is_a_gap_and_no_more() {
        let frames = frames(100);
        let sent = packed(&frames);
        let first = sent.iter().position(|byte| *byte == 0).unwrap() + 1;
        let second = first + sent[first..].iter().position(|byte| *byte == 0).unwrap() + 1;
        let cut = [&sent[..first], &sent[second..]].concat();
        let mut back = Vec::new();
        received(&cut, |part| {
            if let Part::Frames(frames) = part {
                back.extend(frames.map(|frame| frame.unwrap().seq));
            }
        });
        let gaps: Vec<u32> = back.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step != 1).collect();
        assert!(gaps.len() == 1 && back.last() == Some(&99), "{gaps:?}");
    }

    #[test]
    fn a_begin_comes_back_with_every_parameter_and_an_end_is_one() {
        let config = Config { kp_nm_rad: 300.0, er_enabled: false, ..Config::default() };
        let begin = Begin { run: 7, build: *b"er-servo", tick: 99, state: State::running_at(Counts(5000)), config };
        let mut packet = [0; TELEMETRY_BYTES];
        let mut parts = 0;
        received(begin.encode(&mut packet), |part| {
            assert!(matches!(part, Part::Begin(back) if back == begin));
            parts += 1;
        });
        received(end(&mut packet), |part| {
            assert!(matches!(part, Part::End));
            parts += 1;
        });
        assert_eq!(parts, 2);
        assert_eq!(decode(&[]).unwrap_err(), PartError::Malformed);
        assert_eq!(decode(&[9, 1]).unwrap_err(), PartError::Malformed);
    }

    proptest! {
        #[test]
        fn any_bytes_are_parts_or_errors(bytes: Vec<u8>) {
            if let Ok(Part::Frames(frames)) = decode(&bytes) {
                prop_assert!(frames.count() <= bytes.len());
            }
        }
    }
}
