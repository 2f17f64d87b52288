//! A debug probe on the running drive: reads RTT channel 0 through probe-rs, without stopping the core.

use std::thread;
use std::time::Duration;

use probe_rs::rtt::{Error, Rtt, ScanRegion};
use probe_rs::{Permissions, Session, SessionConfig};

use super::source::Got;

/// The image's ring holds 80 ms of frames.
const PAUSE: Duration = Duration::from_millis(2);

/// A probe that is attached to the log.
pub struct Probe {
    session: Session,
    rtt: Rtt,
}

impl Probe {
    /// Attaches through the first probe that is connected.
    ///
    /// # Errors
    ///
    /// No probe, another chip, or no log at that address: the ELF file is not that of the flashed image.
    pub fn attach(chip: &str, rtt_address: u64) -> Result<Self, Error> {
        let config = SessionConfig { permissions: Permissions::default(), ..SessionConfig::default() };
        let mut session = Session::auto_attach(chip, config)?;
        let rtt = Rtt::attach_region(&mut session.core(0)?, &ScanRegion::Exact(rtt_address))?;
        Ok(Self { session, rtt })
    }

    /// What the log has written since the last time.
    ///
    /// # Errors
    ///
    /// The probe was unplugged, or the drive lost power.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<Got, Error> {
        let channel = self.rtt.up_channel(0).ok_or(Error::MissingChannel(0))?;
        let count = channel.read(&mut self.session.core(0)?, buffer)?;
        if count > 0 {
            return Ok(Got::Bytes(count));
        }
        thread::sleep(PAUSE);
        Ok(Got::Nothing)
    }
}
