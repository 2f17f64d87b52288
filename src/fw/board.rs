//! The board: clocks, pins, buses. The only place that knows which pin is what.
//!
//! | pin | signal | scaling, level |
//! |---|---|---|
//! | PA5, PA6, PA7, PA4 | SPI1 SCK, MISO, MOSI, select of the AD2S1210 (WR/FSYNC) | mode 1, 21 MHz (25 at most) |
//! | PB0, PB1, PB2, PB10 | SAMPLE (TIM3 channel 3), A0, A1, RESET of the AD2S1210 | pull-down on RESET |
//! | PB13, PB14, PB15, PB12 | SPI2 SCK, MISO, MOSI, select of the AD5754R (SYNC) | mode 1, 21 MHz to write, 10.5 MHz to read |
//! | PC6, PC7 | LDAC (TIM3 channel 1), CLR of the AD5754R | pull-down on CLR: outputs 0 V until the image runs |
//! | PC0 | ADC1 channel 10, field monitor | 0..3.3 V is 0..4 kV/mm |
//! | PC1 | high-voltage interlock | high: closed; internal pull-down |
//! | PC2 | emergency stop | high: released; internal pull-down |
//! | PC4 | motor amplifier ready, temperature contact | high: ready; internal pull-down |
//! | PC5 | heartbeat | changes its level every tick; without an edge for 2 ms a monostable takes torque and high voltage off |
//! | PC3 | brake feedback | high: the damper brakes |
//! | PC8 | high-voltage enable | high: enabled; pull-down |
//! | PC9 | fault lamp | high: a fault is latched |
//! | PA2, PA3 | USART2 TX, RX, command link | 921600 baud, 8N1 |

use cortex_m::peripheral::DWT;
use cortex_m::singleton;
use embedded_hal::delay::DelayNs;
use embedded_hal::spi::MODE_1;
use er_servo::app::{FieldMonitor, SampleDelay, Servo, Wiring};
use er_servo::drivers::ad2s1210::{self, Ad2s1210};
use er_servo::drivers::dac::{self, Dac, Part};
use er_servo::link::{BAUD, Offset, ParameterSource};
use er_servo::storage::StorageError;
use er_servo::{Config, Faults, Frame, MonitorCode, Params};
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4xx_hal::adc::Adc;
use stm32f4xx_hal::adc::config::{AdcConfig, Clock, SampleTime, Sequence};
use stm32f4xx_hal::dma::traits::{PeriAddress, Stream};
use stm32f4xx_hal::dma::{DmaChannel, DmaDataSize, DmaDirection, Stream5, StreamsTuple};
use stm32f4xx_hal::flash::LockedFlash;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc;
use stm32f4xx_hal::serial::config::DmaConfig;
use stm32f4xx_hal::serial::{self, Rx, Serial, Tx};
use stm32f4xx_hal::spi::Spi;
use stm32f4xx_hal::watchdog::IndependentWatchdog;

use super::clock;
use super::edges::{self, Edges, Ldac, Sample};
use super::pin::{In, Out};
use super::spi::{Device, FastWrites};
use super::storage::Storage;

/// PC8.
pub const HV_ENABLE_PIN: u32 = 8;
/// PC7, CLR of the DAC.
pub const CLEAR_PIN: u32 = 7;
/// PC9.
pub const FAULT_LAMP_PIN: u32 = 9;

/// Frames between the interrupt and the log: 64 ms, power of two for a cheap queue.
pub const QUEUE_FRAMES: usize = 128;
/// Offsets of an experiment that are computed ahead: 32 ms.
pub const QUEUE_OFFSETS: usize = 64;
/// The drive restarts when thread mode or the tick stands still for this long.
pub const WATCHDOG_MS: u32 = 100;
/// Bytes of the link's ring.
const RING_BYTES: usize = 1024;
/// While clocks start and flash is searched; sectors full of something else than parameters take up to a second.
const START_WATCHDOG_MS: u32 = 2000;

/// What the application loop is wired to.
pub type Hardware = Wiring<
    Device<pac::SPI1, 'A'>,
    Sample,
    Out<'B'>,
    FastWrites<Device<pac::SPI2, 'B'>>,
    Ldac,
    Out<'C'>,
    In<'C'>,
    Out<'C'>,
    Monitor,
    CycleDelay,
>;

/// Everything of the board that the image uses.
pub struct Board {
    /// The application loop with its hardware; its chips are up, or their fault is reported at every tick.
    pub servo: Servo<Hardware>,
    /// 2 kHz, without ticks yet.
    pub edges: Edges,
    /// Running.
    pub watchdog: IndependentWatchdog,
    /// Where the interrupt puts frames.
    pub frames_in: Producer<'static, Frame, QUEUE_FRAMES>,
    /// Where the interrupt takes the offsets of an experiment.
    pub offsets: Consumer<'static, Offset, QUEUE_OFFSETS>,
    /// Where thread mode puts them.
    pub offsets_in: Producer<'static, Offset, QUEUE_OFFSETS>,
    /// Where thread mode takes frames.
    pub frames: Consumer<'static, Frame, QUEUE_FRAMES>,
    /// What the last reset says.
    pub reset_faults: Faults,
    /// Bytes of the link that came in.
    pub ring: Ring,
    /// Where answers go.
    pub tx: Tx<pac::USART2>,
    /// Parameters in flash.
    pub storage: Storage,
    /// Parameters of the law.
    pub config: Config,
    /// Where they came from.
    pub source: ParameterSource,
}

impl Board {
    /// Sets everything up, once; `None` the second time.
    // Over 40 lines: every pin and peripheral once, in the order in which the chip wants them.
    pub fn take() -> Option<Self> {
        let mut core = cortex_m::Peripherals::take()?;
        let device = pac::Peripherals::take()?;
        let queue = singleton!(: Queue<Frame, QUEUE_FRAMES> = Queue::new())?;
        let (frames_in, frames) = queue.split();
        let (offsets_in, offsets) = singleton!(: Queue<Offset, QUEUE_OFFSETS> = Queue::new())?.split();

        let reset_faults = reset_cause(&device.RCC);
        clock::go_on_when_halted(&device.DBGMCU);
        let mut watchdog = IndependentWatchdog::new(device.IWDG);
        // Before anything that could wait for ever: a crystal that does not start, for one.
        clock::set_watchdog(&mut watchdog, START_WATCHDOG_MS);
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
        let mut rcc = clock::start(device.RCC);
        clock::start_microseconds(&device.TIM5);
        let mut storage = Storage::new(LockedFlash::new(device.FLASH));
        let (config, source) = stored(&mut storage);
        watchdog.feed();
        watchdog.start(WATCHDOG_MS.millis());
        let unread = matches!(source, ParameterSource::Damaged | ParameterSource::RolledBack);
        let damaged = if unread { Faults::PARAMETERS } else { Faults::empty() };

        let (a, b, c) = (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
        // First of all the pins that keep the outputs safe.
        let hv_enable: Out<'C'> = c.pc8.into_push_pull_output().erase_number().into();
        let clear: Out<'C'> = c.pc7.into_push_pull_output().erase_number().into();
        let spi1_pins = (Some(a.pa5), Some(a.pa6), Some(a.pa7));
        let spi1 = Spi::new(device.SPI1, spi1_pins, MODE_1, 21.MHz(), &mut rcc);
        let spi2_pins = (Some(b.pb13), Some(b.pb14), Some(b.pb15));
        let spi2 = Spi::new(device.SPI2, spi2_pins, MODE_1, 10_500.kHz(), &mut rcc);
        let select_resolver: Out<'A'> = a.pa4.into_push_pull_output().erase_number().into();
        let select_dac: Out<'B'> = b.pb12.into_push_pull_output().erase_number().into();
        // Before its pins are outputs, so that they come up high.
        let edges = Edges::new(device.TIM3);
        let resolver_pins = ad2s1210::Pins {
            sample: Sample::new(b.pb0.into_alternate()),
            a0: b.pb1.into_push_pull_output().erase_number().into(),
            a1: b.pb2.into_push_pull_output().erase_number().into(),
            reset: b.pb10.into_push_pull_output().erase_number().into(),
        };
        let dac_pins = dac::Pins { ldac: Ldac::new(c.pc6.into_alternate()), clear };
        let wiring = Wiring {
            resolver: Ad2s1210::new(Device::new(spi1, select_resolver), resolver_pins),
            dac: Dac::new(FastWrites::new(Device::new(spi2, select_dac)), dac_pins, Part::Quad),
            interlock_closed: c.pc1.into_pull_down_input().erase_number().into(),
            stop_released: c.pc2.into_pull_down_input().erase_number().into(),
            amplifier_ready: c.pc4.into_pull_down_input().erase_number().into(),
            heartbeat: c.pc5.into_push_pull_output().erase_number().into(),
            hv_enable,
            fault_lamp: c.pc9.into_push_pull_output().erase_number().into(),
            brake_feedback: c.pc3.into_push_pull_output().erase_number().into(),
            monitor: Monitor::new(device.ADC1, c.pc0.into_analog(), &mut rcc),
            delay: CycleDelay,
        };
        let servo = Servo::new(wiring, Params::new(&config).ok()?);
        let serial_config = serial::Config::default().baudrate(BAUD.bps()).dma(DmaConfig::Rx);
        let (tx, rx) = Serial::new(device.USART2, (a.pa2, a.pa3), serial_config, &mut rcc).ok()?.split();
        let streams = StreamsTuple::new(device.DMA1, &mut rcc);
        let ring = Ring::start(streams.5, rx, singleton!(: [u8; RING_BYTES] = [0; RING_BYTES])?);
        Some(Self {
            servo,
            edges,
            watchdog,
            frames_in,
            frames,
            offsets,
            offsets_in,
            reset_faults: reset_faults | damaged,
            ring,
            tx,
            storage,
            config,
            source,
        })
    }
}

/// The stored parameters; where none were ever stored, those the image was built with. A newest set that cannot be used is a
/// fault: with the set before it, after a downgrade, the drive runs once that is cleared.
fn stored(storage: &mut Storage) -> (Config, ParameterSource) {
    match storage.load() {
        Ok(config) => (config, ParameterSource::stored(&config)),
        Err(StorageError::Empty) => (Config::default(), ParameterSource::BuiltIn),
        Err(StorageError::Flash | StorageError::Unusable) => match storage.load_older() {
            Ok(config) => (config, ParameterSource::RolledBack),
            Err(_) => (Config::default(), ParameterSource::Damaged),
        },
    }
}

/// Bytes of the link that the DMA has put into memory: 11 ms of them at full rate.
pub struct Ring {
    stream: Stream5<pac::DMA1>,
    bytes: &'static [u8; RING_BYTES],
    at: usize,
}

impl Ring {
    fn start(mut stream: Stream5<pac::DMA1>, rx: Rx<pac::USART2>, bytes: &'static mut [u8; RING_BYTES]) -> Self {
        stream.set_channel(DmaChannel::Channel4);
        stream.set_direction(DmaDirection::PeripheralToMemory);
        stream.set_peripheral_address(rx.address());
        stream.set_memory_address(bytes.as_ptr().addr() as u32);
        stream.set_number_of_transfers(RING_BYTES as u16);
        stream.set_memory_increment(true);
        stream.set_circular_mode(true);
        // SAFETY: both sides move bytes, the buffer lives for ever, and what the DMA writes to it is read as volatile.
        #[allow(unsafe_code)]
        unsafe {
            stream.set_memory_size(DmaDataSize::Byte);
            stream.set_peripheral_size(DmaDataSize::Byte);
            stream.enable();
        }
        Self { stream, bytes, at: 0 }
    }
}

impl Iterator for Ring {
    type Item = u8;

    /// The next byte, if one has come in. A reader that is a whole ring behind gets a mixture, which its check refuses.
    fn next(&mut self) -> Option<u8> {
        let written = RING_BYTES - usize::from(self.stream.number_of_transfers()).min(RING_BYTES);
        if self.at == written % RING_BYTES {
            return None;
        }
        let byte = self.bytes.get(self.at)?;
        self.at = (self.at + 1) % RING_BYTES;
        // SAFETY: a reference is a valid pointer; the DMA changes what is behind it.
        #[allow(unsafe_code)]
        Some(unsafe { core::ptr::read_volatile(byte) })
    }
}

/// Reads why the MCU was reset, and clears it for the next time. A reset by a debugger or by power is none of ours.
fn reset_cause(rcc: &pac::RCC) -> Faults {
    let cause = rcc.csr().read();
    rcc.csr().modify(|_, w| w.rmvf().set_bit());
    if cause.wdgrstf().bit_is_set() || cause.wwdgrstf().bit_is_set() { Faults::ABNORMAL_RESET } else { Faults::empty() }
}

/// The field monitor: each reading starts the next conversion, so a value is one tick old and none is waited for.
pub struct Monitor {
    adc: Adc<pac::ADC1>,
}

impl Monitor {
    fn new(adc: pac::ADC1, pin: stm32f4xx_hal::gpio::PC0<stm32f4xx_hal::gpio::Analog>, rcc: &mut rcc::Rcc) -> Self {
        // 21 MHz: the converter takes 36 at most (data sheet table 74), and half its bus is 42.
        let mut adc = Adc::new(adc, true, AdcConfig::default().clock(Clock::Pclk2_div_4), rcc);
        adc.configure_channel(&pin, Sequence::One, SampleTime::Cycles_84);
        adc.enable();
        adc.start_conversion();
        Self { adc }
    }
}

impl FieldMonitor for Monitor {
    fn read(&mut self) -> MonitorCode {
        let code = MonitorCode(self.adc.current_sample());
        // Not the HAL's start, which waits until the converter says that it has begun, if need be for ever.
        // SAFETY: the converter is this monitor's own.
        #[allow(unsafe_code)]
        let registers = unsafe { &*pac::ADC1::ptr() };
        registers.cr2().modify(|_, w| w.swstart().set_bit());
        code
    }
}

/// Waits by the core's cycle counter at start-up; in a tick by the timer that has made SAMPLE fall.
#[derive(Debug)]
pub struct CycleDelay;

fn cycles(wait_ns: u32) -> u32 {
    // 168 cycles a microsecond; the division by 1000 as a shift, rounded up: 0.168 * 2^20.
    ((u64::from(wait_ns) * 176_161) >> 20) as u32 + 1
}

impl DelayNs for CycleDelay {
    fn delay_ns(&mut self, wait_ns: u32) {
        let (from, cycles) = (DWT::cycle_count(), cycles(wait_ns));
        while DWT::cycle_count().wrapping_sub(from) < cycles {}
    }
}

impl SampleDelay for CycleDelay {
    // The timer knows.
    fn mark(&mut self) {}

    fn wait_since_mark(&mut self, wait_ns: u32) {
        edges::wait_since_sample(wait_ns);
    }
}
