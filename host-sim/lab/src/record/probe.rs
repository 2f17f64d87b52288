//! A debug probe on the running drive: reads the ring of the recordings through the memory access port alone.
//!
//! Not through a session of probe-rs: opening one halts every core to clear its breakpoints, and closing one halts it
//! again; a drive that runs then trips (tick overrun, or the monostable behind its heartbeat). The access port reads and
//! writes memory beside the core, which does not notice. While the core sleeps the image keeps the bus awake for it (`DBGMCU`).

use std::error::Error;
use std::thread;
use std::time::Duration;

use probe_rs::architecture::arm::dp::DpAddress;
use probe_rs::architecture::arm::sequences::DefaultArmSequence;
use probe_rs::architecture::arm::{ArmDebugInterface, ArmError, FullyQualifiedApAddress};
use probe_rs::probe::list::Lister;

use super::ring::{self, Memory};
use super::source::Got;

/// The image's ring holds 80 ms of frames.
const PAUSE: Duration = Duration::from_millis(2);
/// The access port of the core's bus on every STM32F4 (RM0090 section 38.9).
const MEMORY_PORT: FullyQualifiedApAddress = FullyQualifiedApAddress::v1_with_default_dp(0);

/// What goes wrong with a probe, in its words.
pub type ProbeError = Box<dyn Error + Send + Sync>;

/// A probe that is attached to the recordings.
pub struct Probe {
    port: Port,
    block: u64,
}

struct Port(Box<dyn ArmDebugInterface>);

impl Memory for Port {
    type Error = ArmError;

    fn words<const N: usize>(&mut self, address: u64) -> Result<[u32; N], ArmError> {
        let mut words = [0; N];
        self.0.memory_interface(&MEMORY_PORT)?.read_32(address, &mut words)?;
        Ok(words)
    }

    fn bytes(&mut self, address: u64, place: &mut [u8]) -> Result<(), ArmError> {
        self.0.memory_interface(&MEMORY_PORT)?.read_8(address, place)
    }

    fn put_word(&mut self, address: u64, word: u32) -> Result<(), ArmError> {
        self.0.memory_interface(&MEMORY_PORT)?.write_word_32(address, word)
    }
}

impl Probe {
    /// Attaches through the first probe that is connected.
    ///
    /// # Errors
    ///
    /// No probe, no chip, or no recordings at that address: the ELF file is not that of the flashed image.
    pub fn attach(address: u64) -> Result<Self, ProbeError> {
        let found = Lister::new().list_all();
        let mut probe = found.first().ok_or("no debug probe is connected")?.open()?;
        probe.attach_to_unspecified()?;
        let interface = probe.try_into_arm_debug_interface(DefaultArmSequence::create());
        let mut interface = interface.map_err(|(_, error)| error)?;
        interface.select_debug_port(DpAddress::Default)?;
        let mut port = Port(interface);
        if !ring::is_there(&mut port, address)? {
            return Err("no recordings at the address of the ELF file: it is not that of the flashed image".into());
        }
        Ok(Self { port, block: address })
    }

    /// What the image has recorded since the last time.
    ///
    /// # Errors
    ///
    /// The probe was unplugged, or the drive lost power.
    pub fn read(&mut self, buffer: &mut [u8]) -> Result<Got, ProbeError> {
        match ring::take(&mut self.port, self.block, buffer)? {
            0 => {
                thread::sleep(PAUSE);
                Ok(Got::Nothing)
            }
            count => Ok(Got::Bytes(count)),
        }
    }
}
