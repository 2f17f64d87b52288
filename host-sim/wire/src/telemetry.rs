//! Recordings over the link, as entries like those of the log.

use er_servo::telemetry::{Part, PartError, decode};

use crate::log::{Begin, Entry, Error};

/// What a packet of telemetry holds; what no drive sends is an entry that was damaged.
///
/// # Errors
///
/// A recording of another release.
pub fn entries(packet: &[u8]) -> Result<Vec<Entry>, Error> {
    match decode(packet) {
        Ok(Part::Begin(begin)) => {
            let er_servo::telemetry::Begin { run, build, tick, state, config } = begin;
            Ok(vec![Entry::Begin(Box::new(Begin { run, build, tick, state, config }))])
        }
        Ok(Part::Frames(frames)) => {
            Ok(frames.map(|frame| frame.map_or(Entry::Damaged, |frame| Entry::Frame(Box::new(frame)))).collect())
        }
        Ok(Part::End) => Ok(vec![Entry::End]),
        Err(PartError::Schema(schema)) => Err(Error::Schema(schema.into())),
        Err(PartError::Parameters(count)) => Err(Error::Parameters { count }),
        Err(PartError::Malformed) => Ok(vec![Entry::Damaged]),
    }
}
