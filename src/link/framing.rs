//! Messages to bytes and back: postcard, a CRC-32 behind it, stuffed by COBS, ended by a zero. A packet of telemetry is told from
//! a message by its check, whose bits are inverted.

use serde::{Deserialize, Serialize};

use super::{PACKET_BYTES, TELEMETRY_BYTES, TELEMETRY_PLAIN_BYTES};

const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);
const CRC_BYTES: usize = 4;

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

/// A packet of telemetry as it is sent; what is longer than [`TELEMETRY_PLAIN_BYTES`] is none.
pub fn encode_telemetry<'a>(plain: &[u8], packet: &'a mut [u8; TELEMETRY_BYTES]) -> &'a [u8] {
    let mut checked = [0; TELEMETRY_PLAIN_BYTES + CRC_BYTES];
    let end = plain.len() + CRC_BYTES;
    let Some(whole) = checked.get_mut(..end) else { return &[] };
    let (place, check) = whole.split_at_mut(plain.len());
    place.copy_from_slice(plain);
    check.copy_from_slice(&(!CRC.checksum(plain)).to_le_bytes());
    let Ok(stuffed) = cobs::try_encode(whole, packet) else { return &[] };
    if let Some(last) = packet.get_mut(stuffed) {
        *last = 0;
    }
    packet.get(..=stuffed).unwrap_or_default()
}

/// What a packet is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Received<'a, T> {
    /// A message.
    Message(T),
    /// Telemetry, for [`crate::telemetry::decode`].
    Telemetry(&'a [u8]),
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
    bytes: [u8; TELEMETRY_BYTES],
    length: usize,
}

impl Default for Receiver {
    fn default() -> Self {
        Self { bytes: [0; TELEMETRY_BYTES], length: 0 }
    }
}

impl Receiver {
    /// Takes a byte; gives the message that ended with it, if anything did. Two zeros in a row are nothing.
    pub fn push<T: for<'de> Deserialize<'de>>(&mut self, byte: u8) -> Option<Result<T, Malformed>> {
        Some(self.push_any(byte)?.and_then(|received| match received {
            Received::Message(message) => Ok(message),
            Received::Telemetry(_) => Err(Malformed::Damaged),
        }))
    }

    /// Takes a byte; gives what ended with it, message or telemetry.
    pub fn push_any<T: for<'de> Deserialize<'de>>(&mut self, byte: u8) -> Option<Result<Received<'_, T>, Malformed>> {
        if byte != 0 {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = byte;
            }
            // One beyond the end says that there was too much.
            self.length = (self.length + 1).min(TELEMETRY_BYTES + 1);
            return None;
        }
        match core::mem::take(&mut self.length) {
            0 => None,
            length => Some(self.bytes.get_mut(..length).ok_or(Malformed::Overlong).and_then(decode)),
        }
    }
}

fn decode<T: for<'de> Deserialize<'de>>(stuffed: &mut [u8]) -> Result<Received<'_, T>, Malformed> {
    let length = cobs::decode_in_place(stuffed).map_err(|_| Malformed::Damaged)?;
    let plain = stuffed.get(..length).ok_or(Malformed::Damaged)?;
    let (message, check) = plain.split_last_chunk::<CRC_BYTES>().ok_or(Malformed::Damaged)?;
    let (found, check) = (CRC.checksum(message), u32::from_le_bytes(*check));
    if found == !check {
        return Ok(Received::Telemetry(message));
    }
    if found != check {
        return Err(Malformed::Damaged);
    }
    match postcard::take_from_bytes(message) {
        Ok((message, [])) => Ok(Received::Message(message)),
        _ => Err(Malformed::Damaged),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::link::{Command, Packet, Reply};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn sent(message: &impl Serialize) -> Vec<u8> {
        encode(message, &mut [0; PACKET_BYTES]).unwrap().to_vec()
    }

    fn received<T: for<'de> Deserialize<'de>>(bytes: &[u8]) -> Vec<Result<T, Malformed>> {
        let mut receiver = Receiver::default();
        bytes.iter().filter_map(|byte| receiver.push(*byte)).collect()
    }

    #[test]
    fn a_single_flipped_bit_is_always_seen() {
        let packet = Packet { session: 7, sequence: 8, command: Command::SetPosition { counts: 40_960 } };
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
        let packet = Packet { session: 1, sequence: 2, command: Command::Disable };
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
