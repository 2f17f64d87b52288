//! The board as the emulator sees it: the MCU, its crystal and rail, and what hangs on its buses.

use std::num::{NonZeroU32, NonZeroU64};

use plant::chips::dac::Part;
use plant::chips::{Ad2s1210, Dac};
use rigless::device::{Device, Level};
use rigless::machine::{Board, Crystal, Supply, Target, armv7m};
use rigless::mcu::{Mcu, Operate};
use rigless::snapshot::{Error as SnapshotError, Reader, Store, Writer};
use rigless::soc::Error;
use rigless::soc::stm32f427::Stm32f427;
use rigless::soc::stm32f427::generated::tim2::Register::{
    Arr, Ccer, Ccmr1Output, Ccmr2Output, Ccr1, Ccr3, Cnt, Cr1, Dier, Psc,
};
use rigless::soc::stm32f427::peripherals::adc::Channel;
use rigless::soc::stm32f427::peripherals::gpio::{Gpio, Pin};
use rigless::soc::stm32f427::peripherals::spi::Select;
use rigless::soc::stm32f427::peripherals::tim::Channel as TimerChannel;
use rigless::time::VirtualNanos;

use crate::chip::OnBus;
use crate::core::{Hand, with_flash};
use crate::flash::Shared;
use crate::terminal::Terminal;

/// The core's clock, Hz. One instruction a cycle: an optimist's core, but the ratio of instructions to bus time is right.
const CORE_HZ: u64 = 168_000_000;
/// SPI1, SPI2, USART2 by the order of the part's tables.
const SPI1: usize = 0;
const SPI2: usize = 1;
const USART2: usize = 1;
/// TIM3 by the order of the part's table of timers.
const TIM3: usize = 1;
/// Alternate function with which a pin is an output of TIM3.
const TIM3_FUNCTION: u8 = 2;
/// Channels of TIM3 and the pins that they are wired to inside the part: the emulator leaves that to the board.
const TIMED: [(u8, Port, u8); 2] = [(3, Port::B, 0), (1, Port::C, 6)];
/// ADC1 channel 10 is PC0.
const MONITOR_CHANNEL: u8 = 10;
const RAIL_MILLIVOLTS: u32 = 3300;
/// Full scale of the monitor, kV/mm.
const MONITOR_FULL_SCALE_KV_MM: f64 = 4.0;

/// A port of the MCU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Port {
    /// GPIOA.
    A = 0,
    /// GPIOB.
    B = 1,
    /// GPIOC.
    C = 2,
}

/// The board.
#[derive(Debug)]
pub struct ServoBoard {
    /// The MCU.
    pub mcu: Stm32f427,
    flash: Shared,
    hand: Hand,
}

impl ServoBoard {
    /// Everything soldered in and powered, with what `flash` holds in the sectors of the parameters, and within reach of
    /// `hand`.
    ///
    /// # Errors
    ///
    /// None that the code below can cause; whatever the emulator finds wrong with the part.
    pub fn new(flash: Shared, hand: Hand) -> Result<Self, Error> {
        let mut mcu = Stm32f427::new()?;
        mcu.rcc.attach_crystals(Crystal(8_000_000).0, Crystal::NONE.0);
        mcu.set_supply(Supply(RAIL_MILLIVOLTS).0);
        for converter in &mut mcu.adc {
            converter.set_reference(RAIL_MILLIVOLTS);
        }
        if let (Some(on_pa4), Some(on_pb12)) = (Pin::new(4), Pin::new(12)) {
            let select = |port, pin| Select { port, pin, active: Level::Low };
            mcu.spi[SPI1].attach_selected(OnBus::new(Ad2s1210::new()), select("GPIOA", on_pa4));
            mcu.spi[SPI2].attach_selected(OnBus::new(Dac::new(Part::Quad)), select("GPIOB", on_pb12));
        }
        mcu.usart[USART2].attach(Terminal::default());
        Ok(Self { mcu, flash, hand })
    }

    /// The resolver converter; `None` only if the board was not built by [`Self::new`].
    pub fn resolver(&mut self) -> Option<&mut OnBus<Ad2s1210>> {
        self.mcu.spi[SPI1].chip_mut(0)
    }

    /// The command DAC.
    pub fn dac(&mut self) -> Option<&mut OnBus<Dac>> {
        self.mcu.spi[SPI2].chip_mut(0)
    }

    /// The far end of the command link.
    pub fn terminal(&mut self) -> Option<&mut Terminal> {
        self.mcu.usart[USART2].chip_mut()
    }

    /// Level on a pin, as a wire soldered to it sees it.
    pub fn level(&mut self, port: Port, pin: u8) -> bool {
        let (gpio, registers) = self.mcu.port(port as usize);
        Pin::new(pin).is_some_and(|pin| gpio.level(pin, registers) == Level::High)
    }

    /// Puts the outputs of the timer's channels on the pins that carry them.
    pub fn carry_timer(&mut self, at: VirtualNanos) {
        for (channel, port, pin) in TIMED {
            let (Some(channel), Some(pin)) = (TimerChannel::new(channel), Pin::new(pin)) else { continue };
            let (_, registers) = self.mcu.port(port as usize);
            if Gpio::function(pin, registers) != Some(TIM3_FUNCTION) {
                continue;
            }
            let (timer, registers) = self.mcu.timer(TIM3);
            let level = timer.output(channel, registers);
            self.mcu.drive_port(at, port as usize, |gpio, registers, context| {
                gpio.drive_function(pin, level, registers, context);
            });
        }
    }

    /// Flips a bit of a register of the tick's timer; the seed says which.
    pub fn upset_timer(&mut self, at: VirtualNanos, seed: u64) {
        let registers = [Cr1, Dier, Ccmr1Output, Ccmr2Output, Ccer, Cnt, Psc, Arr, Ccr1, Ccr3];
        let register = registers[(seed % registers.len() as u64) as usize];
        let bit = 1 << (seed / registers.len() as u64 % 16);
        self.mcu.drive_timer(at, TIM3, |timer, file, context| {
            // The count is the model's own; every other register is in the file.
            let before = timer.peek(register, file, at).unwrap_or_else(|| file.get(register));
            file.set(register, before ^ bit);
            timer.write(register, before ^ bit, file, context);
        });
    }

    /// Drives a pin from outside.
    pub fn drive(&mut self, at: VirtualNanos, port: Port, pin: u8, high: bool) {
        let level = if high { Level::High } else { Level::Low };
        if let Some(pin) = Pin::new(pin) {
            self.mcu.drive_port(at, port as usize, |gpio, registers, context| {
                gpio.drive(pin, Some(level), registers, context);
            });
        }
    }

    /// Puts a field on the monitor's pin, kV/mm.
    pub fn set_monitor(&mut self, field_kv_mm: f64) {
        let millivolts = field_kv_mm / MONITOR_FULL_SCALE_KV_MM * f64::from(RAIL_MILLIVOLTS);
        if let Some(channel) = Channel::new(MONITOR_CHANNEL) {
            self.mcu.adc[0].set_input(channel, millivolts.round().max(0.0) as u32);
        }
    }
}

impl Store for ServoBoard {
    fn store(&self, to: &mut Writer) -> Result<(), SnapshotError> {
        self.mcu.store(to)
    }

    fn load(&mut self, from: &mut Reader) -> Result<(), SnapshotError> {
        self.mcu.load(from)
    }
}

impl Board for ServoBoard {
    fn name(&self) -> &'static str {
        "er-servo"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f427"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.mcu).interrupt_lines);
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CORE_HZ).unwrap_or(NonZeroU64::MIN),
            interrupt_lines: NonZeroU32::new(lines).unwrap_or(NonZeroU32::MIN),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).unwrap_or(NonZeroU32::MIN),
            instructions_per_second: NonZeroU64::new(CORE_HZ).unwrap_or(NonZeroU64::MIN),
            boot: "flash",
        };
        let windows = rigless::cpu::armv7m::windows(self.mcu.bus());
        let spec = core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight);
        let spec = with_flash(spec, self.flash.clone(), self.hand.clone());
        vec![Target::new("stm32f427", &mut self.mcu, spec)]
    }
}
