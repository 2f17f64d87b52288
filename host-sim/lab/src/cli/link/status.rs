//! The status of a drive, for a person and for a program.

use er_servo::drivers::ad2s1210;
use er_servo::events::Event;
use er_servo::link::Status;
use er_servo::{Counts, Faults, InputFlags, MonitorCode};
use serde_json::json;
use wire::log::Build;

use crate::output::Provenance;

/// Name of the state; in the fault state each cause on a line of its own.
pub fn state(status: &Status) -> String {
    let name = ["boot", "ready", "running", "fault", "stopping"].get(usize::from(status.state)).unwrap_or(&"unknown");
    let chip = ad2s1210::Faults::from_bits_retain(status.resolver_faults).sentences();
    let causes = Faults::from_bits_truncate(status.faults).explain().chain(chip);
    causes.fold((*name).to_owned(), |text, cause| text + "\n" + cause)
}

/// A fault of the event log, for a person.
pub fn event(event: &Event) -> String {
    let Event { number, at_ms, speed_rad_s, worst_cycles, resolver_faults, .. } = event;
    let position_rad = Counts(event.position).to_rad();
    let chip = ad2s1210::Faults::from_bits_retain(*resolver_faults).sentences();
    let head = format!(
        "{number:<4} {:.3} s after the reset, at {position_rad:.4} rad, {speed_rad_s:.2} rad/s, worst tick {worst_cycles} cycles\n",
        f64::from(*at_ms) * 1e-3
    );
    let causes = event.faults().explain().chain(chip).map(str::to_owned);
    let causes = causes.chain(event.restart.map(|restart| restart.to_string()));
    causes.fold(head, |text, cause| text + "     " + &cause + "\n")
}

/// What the drive says of its image.
pub struct Image {
    /// As `readelf -n` begins the build id of its ELF file.
    pub build: Build,
    /// From the sampling of the position until the outputs change, s.
    pub to_output_s: f64,
}

impl Image {
    fn name(&self) -> String {
        self.build.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

/// For a person.
pub fn text(status: &Status, image: &Image) -> String {
    let flags = InputFlags::from_bits_truncate(status.flags);
    let either = |flag, yes, no| if flags.contains(flag) { yes } else { no };
    let counters = &status.counters;
    let rows = [
        ("state", state(status).replace('\n', "\n             ")),
        ("interlock", either(InputFlags::INTERLOCK_CLOSED, "closed", "open").to_owned()),
        ("stop", either(InputFlags::STOP_PRESSED, "pressed", "released").to_owned()),
        ("amplifier", either(InputFlags::AMPLIFIER_READY, "ready", "not ready").to_owned()),
        ("parameters", status.parameters.to_string()),
        ("homed", if status.homed { "yes" } else { "no" }.to_owned()),
        ("reference", format!("{:.6} rad", Counts(status.reference).to_rad())),
        ("position", format!("{:.6} rad", Counts(status.position).to_rad())),
        ("torque", format!("{:.3} N m", status.torque_nm)),
        ("field", {
            let measured = MonitorCode(status.monitor).to_kv_mm();
            format!("{:.3} kV/mm commanded, {measured:.3} measured", status.field_kv_mm)
        }),
        ("image", image.name()),
        ("tick", format!("{}, worst {} cycles", status.tick, status.worst_cycles)),
        ("outputs", format!("{:.2} us after the sample", image.to_output_s * 1e6)),
        ("recording", format!("{}, {} frames lost", if status.recording { "runs" } else { "none" }, status.lost)),
        (
            "link",
            format!(
                "{} packets, {} refused, {} damaged, {} overlong, {} replayed",
                counters.packets, counters.refused, counters.damaged, counters.overlong, counters.replayed
            ),
        ),
    ];
    rows.iter().map(|(name, value)| format!("{name:<12} {value}\n")).collect()
}

/// For a program.
pub fn json(status: &Status, image: &Image) -> String {
    let flags = InputFlags::from_bits_truncate(status.flags);
    let state = state(status);
    let mut lines = state.lines();
    let value = json!({
        "state": lines.next(),
        "causes": lines.collect::<Vec<_>>(),
        "interlock_closed": flags.contains(InputFlags::INTERLOCK_CLOSED),
        "stop_pressed": flags.contains(InputFlags::STOP_PRESSED),
        "amplifier_ready": flags.contains(InputFlags::AMPLIFIER_READY),
        "parameters": status.parameters.to_string(),
        "homed": status.homed,
        "reference_rad": Counts(status.reference).to_rad(),
        "position_rad": Counts(status.position).to_rad(),
        "torque_cmd_nm": status.torque_nm,
        "field_cmd_kv_mm": status.field_kv_mm,
        "field_meas_kv_mm": MonitorCode(status.monitor).to_kv_mm(),
        "image": image.name(),
        "sample_to_output_s": image.to_output_s,
        "tick": status.tick,
        "worst_cycles": status.worst_cycles,
        "recording": status.recording,
        "frames_lost": status.lost,
        "counters": status.counters,
        "provenance": Provenance::without_inputs(None),
    });
    format!("{value:#}\n")
}
