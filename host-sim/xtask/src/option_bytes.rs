//! The option bytes of the part: what the image relies on and cannot set itself.

use std::process::Command;

use crate::run::output;

/// Option control register (RM0090 section 3.9.10).
const OPTCR: &str = "0x40023C14";
/// Chip as probe-rs names it.
pub const CHIP: &str = "STM32F427VITx";

/// Reads the register through `probe-rs` and judges it.
///
/// # Errors
///
/// No probe, or what does not fit, with what to set.
pub fn check() -> Result<(), String> {
    let read = output(Command::new("probe-rs").args(["read", "--chip", CHIP, "b32", OPTCR, "1"]));
    let read = read.ok_or("`probe-rs read` failed: is probe-rs installed, a probe connected, the board powered?")?;
    let word = read.split_whitespace().last().unwrap_or_default().trim_start_matches("0x");
    let register = u32::from_str_radix(word, 16).map_err(|_| format!("`probe-rs read` printed `{read}`"))?;
    let faults = faults(register);
    if faults.is_empty() {
        println!(
            "option bytes {register:#010x}: brown-out reset at 2.7 V, watchdog by software, no reset in stop or standby"
        );
        return Ok(());
    }
    Err(format!("option bytes {register:#010x}: {}", faults.join("; ")))
}

/// What does not fit.
fn faults(register: u32) -> Vec<&'static str> {
    let mut faults = Vec::new();
    // BOR_LEV: 0 is level 3. Below 2.7 V the converter's monitor and flash programming are out of their ranges.
    if register >> 2 & 0b11 != 0 {
        faults.push("brown-out reset is not at level 3 (2.7 V): set BOR_LEV to 0");
    }
    // The image starts the watchdog itself, with a patience that covers its start.
    if register & 1 << 5 == 0 {
        faults.push("the watchdog is started by hardware, with 512 ms, before the image can: set WDG_SW to 1");
    }
    if register >> 6 & 0b11 != 0b11 {
        faults.push("stop or standby mode resets the part: set nRST_STOP and nRST_STDBY to 1");
    }
    // nWRP of sectors 1 to 3, which hold parameters and events; SPRMOD clear.
    if register >> 31 == 1 || register >> 17 & 0b111 != 0b111 {
        faults.push(
            "sectors 1 to 3 are protected, so that neither parameters nor events can be stored: set nWRP1 to 3 to 1",
        );
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factory_setting_lacks_the_brown_out_reset_and_nothing_else() {
        // RM0090 section 3.9.10, reset value: BOR off, everything else as the image wants it.
        assert_eq!(faults(0x0FFF_AAED), ["brown-out reset is not at level 3 (2.7 V): set BOR_LEV to 0"]);
        assert!(faults(0x0FFF_AAE1).is_empty());
        assert_eq!(faults(0x0FF0_AA01).len(), 3);
    }
}
