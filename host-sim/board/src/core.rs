//! The emulator's core with the parameter sectors of flash put between it and its bus.
//!
//! The emulator maps flash read-only into its core and drops stores to it. This wrapper leaves the two sectors out of the
//! map, so that the core asks its bus for them, and answers there from [`crate::flash`]; everything else goes through
//! unchanged. Neither the emulator nor the image is changed. A test can upset the core itself here ([`Upset`]).

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rigless::emulator::{
    Access, AccessKind, BitAlias, Checked, CoreBus, CoreSpec, DataModel, Error, Exit, HaltReason, HostCall,
    InterruptLine, Processor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;

use crate::flash::{ADDRESSES, Shared};

/// Control and status register of the flash interface.
const FLASH_CR: u64 = 0x4002_3C10;
const FLASH_SR: u64 = 0x4002_3C0C;
const CR_START: u64 = 1 << 16;
const SR_BUSY: u64 = 1 << 16;
/// Control register of the clocks, with the bit that says that the crystal oscillates.
const RCC_CR: u64 = 0x4002_3800;
const CR_CRYSTAL_READY: u64 = 1 << 17;

/// Something that upsets the core before its next instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Upset {
    /// It goes on at an address, with something in its first register.
    Jump {
        /// Address of the instruction.
        to: u32,
        /// What the first register holds.
        r0: u32,
    },
    /// The stack pointer of thread mode is bent, once it is thread mode's turn.
    Stack {
        /// To here.
        to: u32,
    },
    /// The non-maskable interrupt, which the emulator's clock security system does not raise.
    NonMaskable,
    /// An interrupt that the image neither enables nor has a handler for comes, by its number.
    Interrupt(u8),
}

/// Upsets the core, from outside.
#[derive(Debug, Clone, Default)]
pub struct Hand {
    next: Arc<Mutex<Option<Upset>>>,
    crystal_is_dead: Arc<AtomicBool>,
}

impl Hand {
    /// Upsets it before its next instruction.
    pub fn upset(&self, upset: Upset) {
        *self.next.lock().unwrap_or_else(PoisonError::into_inner) = Some(upset);
    }

    /// The crystal does not start, or is whole again. To the emulator a pin without a crystal is ready all the same; the core
    /// is told otherwise here.
    pub fn kill_crystal(&self, dead: bool) {
        self.crystal_is_dead.store(dead, Ordering::Relaxed);
    }

    fn take(&self) -> Option<Upset> {
        self.next.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// The machine's core, with `flash` in it and within reach of `hand`.
pub fn with_flash(mut spec: CoreSpec, flash: Shared, hand: Hand) -> CoreSpec {
    let plain = spec.processor.clone();
    spec.processor = Arc::new(move |endian| {
        Ok(Box::new(WithFlash { core: plain(endian)?, flash: flash.clone(), hand: hand.clone() }))
    });
    spec
}

/// Numbers of the registers as a debugger counts them, and the interrupt control and state register with its bit that
/// pends the non-maskable interrupt.
const R0: usize = 0;
const SP: usize = 13;
const PC: usize = 15;
const ICSR: u64 = 0xE000_ED04;
const NMI_PENDING: u64 = 1 << 31;
/// First of the registers that enable and pend interrupts, one bit each.
const NVIC_ISER: u64 = 0xE000_E100;
const NVIC_ISPR: u64 = 0xE000_E200;
/// Number of the exception that is being handled.
const ACTIVE: u64 = 0x1FF;

#[derive(Debug)]
struct WithFlash {
    core: Box<dyn Processor>,
    flash: Shared,
    hand: Hand,
}

impl WithFlash {
    fn upset(&mut self, upset: Upset, now: VirtualNanos) {
        match upset {
            Upset::Jump { to, r0 } => {
                self.core.set_gdb_register(R0, &r0.to_le_bytes());
                self.core.set_gdb_register(PC, &to.to_le_bytes());
            }
            Upset::Stack { to } => {
                let active = self.core.debugger_access(None, ICSR, Width::W32, now).unwrap_or_default() & ACTIVE;
                if active == 0 {
                    self.core.set_gdb_register(SP, &to.to_le_bytes());
                } else {
                    self.hand.upset(upset);
                }
            }
            Upset::NonMaskable => {
                self.core.debugger_access(Some(NMI_PENDING), ICSR, Width::W32, now);
            }
            Upset::Interrupt(number) => {
                for first in [NVIC_ISER, NVIC_ISPR] {
                    let (register, bit) = (first + 4 * u64::from(number / 32), 1 << (number % 32));
                    self.core.debugger_access(Some(bit), register, Width::W32, now);
                }
            }
        }
    }
}

/// The bus as the core sees it.
struct FlashBus<'a> {
    bus: &'a mut dyn CoreBus,
    flash: &'a Shared,
    crystal_is_dead: bool,
}

impl FlashBus<'_> {
    /// A register of the flash interface, at the instant of an access of the core.
    fn register(&mut self, address: u64, at: Access) -> u64 {
        let mut read = Access::new(AccessKind::Read, address, Width::W32, 0);
        read.instruction_count = at.instruction_count;
        read.virtual_time = at.virtual_time;
        self.bus.access(read, false).unwrap_or_default()
    }
}

impl CoreBus for FlashBus<'_> {
    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        let writes = access.kind == AccessKind::Write;
        if !ADDRESSES.contains(&access.address) {
            let answer = self.bus.access(access, from_code);
            // The interface says whether it took the erase.
            let starts = writes && access.address == FLASH_CR && access.value & CR_START != 0;
            if starts && self.register(FLASH_SR, access) & SR_BUSY != 0 {
                self.flash.lock().erase(access.value);
            }
            if self.crystal_is_dead && !writes && access.address == RCC_CR {
                return answer.map(|value| value & !CR_CRYSTAL_READY);
            }
            return answer;
        }
        if !writes {
            return Some(self.flash.lock().read(access.address, access.width));
        }
        let (control, status) = (self.register(FLASH_CR, access), self.register(FLASH_SR, access));
        self.flash.lock().store(access.address, access.width, access.value, control, status);
        Some(0)
    }

    fn time(&self, instructions: u64) -> VirtualNanos {
        self.bus.time(instructions)
    }

    fn queued(&mut self) -> Vec<Queued> {
        self.bus.queued()
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        self.bus.carry_on(instructions, event)
    }

    fn acknowledge(&mut self, line: InterruptLine, instructions: u64) -> Option<u64> {
        self.bus.acknowledge(line, instructions)
    }

    fn read_checked(&mut self, access: Access, report: bool) -> Option<Checked> {
        self.bus.read_checked(access, report)
    }

    fn write_checked(&mut self, access: Access) -> Option<bool> {
        self.bus.write_checked(access)
    }

    fn stops_before(&mut self, access: &Access) -> bool {
        self.bus.stops_before(access)
    }

    fn send_trace(&mut self, bytes: &[u8]) {
        self.bus.send_trace(bytes);
    }
}

impl Processor for WithFlash {
    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        if let Some(upset) = self.hand.take() {
            let now = bus.time(self.core.retired());
            self.upset(upset, now);
        }
        let crystal_is_dead = self.hand.crystal_is_dead.load(Ordering::Relaxed);
        self.core.run(budget, &mut FlashBus { bus, flash: &self.flash, crystal_is_dead })
    }

    #[allow(unsafe_code)]
    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        let end = start + length;
        let cut = if start <= ADDRESSES.start && ADDRESSES.end <= end { ADDRESSES } else { end..end };
        for part in [start..cut.start, cut.end..end] {
            if !part.is_empty() {
                let at = host.wrapping_add((part.start - start) as usize);
                // SAFETY: a part, in whole pages, of what the caller promises for all of it.
                unsafe { self.core.map(part.start, part.end - part.start, at, writable) };
            }
        }
    }

    fn retired(&self) -> u64 {
        self.core.retired()
    }

    fn ask(&mut self, queued: Queued) {
        self.core.ask(queued);
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.core.maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.core.page_size()
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.core.boot(table, read);
    }

    fn reset(&mut self) {
        self.core.reset();
    }

    fn take_reset_request(&mut self) -> bool {
        self.core.take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        self.core.next_event()
    }

    fn on_event(&mut self, now: VirtualNanos) {
        self.core.on_event(now);
    }

    fn waiting(&self) -> bool {
        self.core.waiting()
    }

    fn pc(&self) -> u64 {
        self.core.pc()
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        self.core.add_breakpoint(address)
    }

    fn remove_breakpoint(&mut self, address: u64) {
        self.core.remove_breakpoint(address);
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.core.pass_breakpoint(address);
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.core.attach_debugger(attached);
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.core.hold_interrupts(held);
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.core.gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.core.set_gdb_register(number, bytes)
    }

    fn debugger_access(&mut self, write: Option<u64>, address: u64, width: Width, now: VirtualNanos) -> Option<u64> {
        self.core.debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.core.take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.core.target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.core.data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.core.byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.core.save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.core.load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.core.monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.core.debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.core.bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<std::ops::Range<u64>> {
        self.core.own_ranges()
    }

    fn check_reads(&mut self, every: bool) {
        self.core.check_reads(every);
    }

    fn check_words(&mut self, words: &[u64]) {
        self.core.check_words(words);
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.core.host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.core.answer_host_call(answer);
    }
}
