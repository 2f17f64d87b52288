//! What goes to the host over RTT: events a person reads, and while recording, in a ring of their own, one frame a tick.

use er_servo::app::InitError;
use er_servo::drivers::{ad2s1210, dac};
use er_servo::{Config, FRAME_SCHEMA, Faults, Frame, Limits, Mode, State, Supervisor, parameters};

use super::clock;
use super::rtt::to_recording;
use super::safe::Why;
use super::tick::HardwareError;

// Of every message, since the start.
defmt::timestamp!("{=u32:us}", clock::microseconds());

/// Changes of mode and limits are told at most once in so many ticks, 50 ms: around a reversal they come in every tick.
const SPOKEN_TICKS: u32 = 100;

/// Watches the frames for events, and records them.
pub struct Log {
    supervisor: Supervisor,
    resolver_faults: u8,
    lost: u16,
    /// Mode and limits as they were told last, and in which tick.
    told: (Mode, Limits, u32),
    /// First tick of the recording that runs.
    recording: Option<u32>,
}

/// Which image this is: the linker's hash over it.
pub fn build() -> [u8; 8] {
    #[allow(unsafe_code)]
    unsafe extern "C" {
        #[link_name = "__build_id"]
        static BUILD_ID: [u8; 8];
    }
    // SAFETY: memory.x puts the symbol on the 20 bytes of the hash, in flash.
    #[allow(unsafe_code)]
    unsafe {
        BUILD_ID
    }
}

impl Log {
    /// Before the first frame.
    pub fn new() -> Self {
        let told = (Mode::Off, Limits::empty(), 0);
        Self { supervisor: Supervisor::default(), resolver_faults: 0, lost: 0, told, recording: None }
    }

    /// The drive has come up.
    pub fn booted(&mut self, reset_faults: Faults, before: Option<(u32, Why)>) {
        let name = || defmt::info!("er-servo {=str}, build {=[u8; 8]:02x}", env!("CARGO_PKG_VERSION"), build());
        name();
        // A reset ends a recording.
        to_recording(name);
        if let Some((ran_ms, why)) = before {
            reset_note(ran_ms, why);
        }
        for sentence in reset_faults.explain() {
            defmt::warn!("{=str}", sentence);
        }
    }

    /// Whether a recording runs.
    pub fn recording(&self) -> bool {
        self.recording.is_some()
    }

    /// Starts a recording with the tick `seq`, which the law begins in `state` with the parameters `config`.
    pub fn start_recording(&mut self, run: u32, seq: u32, state: &State, config: &Config) {
        let mut values = [0; 4 * parameters::TABLE.len()];
        for (parameter, place) in parameters::TABLE.iter().zip(values.as_chunks_mut::<4>().0) {
            *place = (parameter.get)(config).to_le_bytes();
        }
        to_recording(|| {
            defmt::println!(
                "recording run {=u32} schema {=u8} build {=[u8; 8]} tick {=u32} state {=[u8]} parameters {=[u8]}",
                run,
                FRAME_SCHEMA,
                build(),
                seq,
                state.encode(),
                values
            );
        });
        self.recording = Some(seq);
    }

    /// Ends the recording.
    pub fn stop_recording(&mut self) {
        if self.recording.take().is_some() {
            to_recording(|| defmt::println!("recording ended"));
        }
    }

    /// Records the frame, and logs what changed with it.
    pub fn frame(&mut self, frame: &Frame) {
        // Frames that were queued before the snapshot was taken are not part of the recording.
        if self.recording.is_some_and(|first| frame.seq.wrapping_sub(first) < u32::MAX / 2) {
            to_recording(|| defmt::println!("frame {=[u8; 48]}", frame.encode()));
        }
        self.events(frame);
    }

    fn events(&mut self, frame: &Frame) {
        let (now, seq) = (frame.outputs.supervisor, frame.seq);
        if now.name() != self.supervisor.name() {
            defmt::info!("tick {=u32}: {=str}", seq, now.name());
        }
        for sentence in now.faults().difference(self.supervisor.faults()).explain() {
            defmt::error!("tick {=u32}: {=str}", seq, sentence);
        }
        let resolver_faults = frame.inputs.resolver.fault_byte;
        let chip = ad2s1210::Faults::from_bits_retain(resolver_faults & !self.resolver_faults);
        for sentence in chip.sentences() {
            defmt::warn!("tick {=u32}: {=str}", seq, sentence);
        }
        if frame.lost != self.lost {
            defmt::warn!("tick {=u32}: {=u16} frames lost so far", seq, frame.lost);
        }
        (self.supervisor, self.resolver_faults, self.lost) = (now, resolver_faults, frame.lost);
        self.bounds(frame);
    }

    /// Mode and limits, as they are when they may be told.
    fn bounds(&mut self, frame: &Frame) {
        let (mode, limits, at) = self.told;
        let (now, bounds, seq) = (frame.outputs.mode, frame.outputs.limits, frame.seq);
        if (now, bounds) == (mode, limits) || seq.wrapping_sub(at) < SPOKEN_TICKS {
            return;
        }
        if now != mode {
            defmt::info!("tick {=u32}: {=str}, {=f32} kV/mm", seq, now.name(), frame.outputs.field_kv_mm);
        }
        for sentence in bounds.difference(limits).explain() {
            defmt::info!("tick {=u32}: {=str}", seq, sentence);
        }
        self.told = (now, bounds, seq);
    }
}

/// What happened before the reset.
fn reset_note(ran_ms: u32, why: Why) {
    defmt::info!("before this reset the drive ran for {=u32} ms", ran_ms);
    match why {
        Why::Unknown => {}
        Why::Panic(file, line) => defmt::error!("it panicked at {=str}:{=u32}", file, line),
        Why::HardFault(at, from) => defmt::error!("hard fault, pc {=u32:#010x}, lr {=u32:#010x}", at, from),
        Why::ClockFailed => defmt::error!("the crystal failed: check it and its capacitors"),
        Why::Interrupt(number) => defmt::error!("interrupt {=u32} has no handler", number),
    }
}

/// Parameters act against the advice of the stability margins.
pub fn forced() {
    defmt::warn!("parameters forced: the loop may be unstable");
}

/// A chip did not come up; the drive ticks on and reports it. The strings stay on the host: formatting them here would
/// take a tenth of the image.
pub fn init_failed(error: &HardwareError) {
    match error {
        InitError::Resolver(error) => resolver_failed(error),
        InitError::Dac(error) => dac_failed(error),
    }
}

fn resolver_failed<E>(error: &ad2s1210::Error<E>) {
    use ad2s1210::Error;
    match error {
        Error::Bus(_) => defmt::error!("resolver converter: SPI1 failed"),
        Error::Pin => defmt::error!("resolver converter: a control pin could not be driven"),
        Error::ReadBack { register, wrote, read } => defmt::error!(
            "resolver converter: register {=u8:#04x} holds {=u8:#04x} after {=u8:#04x} was written; check wiring, supply",
            *register as u8,
            read,
            wrote
        ),
        Error::Parity { register } => {
            defmt::error!("resolver converter: parity error in register {=u8:#04x}", *register as u8);
        }
        Error::Setting { register, value } => {
            defmt::error!("resolver converter: {=u8} does not fit register {=u8:#04x}", value, *register as u8);
        }
        Error::Faulty(faults) => faults.sentences().for_each(|sentence| defmt::error!("{=str}", sentence)),
    }
}

fn dac_failed<E>(error: &dac::Error<E>) {
    use dac::Error;
    match error {
        Error::Bus(_) => defmt::error!("command DAC: SPI2 failed"),
        Error::Pin => defmt::error!("command DAC: LDAC or CLR could not be driven"),
        Error::ReadBack { register, wrote, read } => defmt::error!(
            "command DAC: register {=u8:#04x} holds {=u16:#06x} after {=u16:#06x} was written; check wiring, supply",
            register,
            read,
            wrote
        ),
        Error::Output(status) => defmt::error!(
            "command DAC: over-current A {=bool}, over-current B {=bool}, thermal shutdown {=bool}",
            status.over_current_a,
            status.over_current_b,
            status.thermal_shutdown
        ),
        Error::NotLoaded => defmt::error!("command DAC: LDAC did not fall"),
    }
}
