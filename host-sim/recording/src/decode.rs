//! The image's log as recordings: the frames of one run, as the drive wrote them.

use er_servo::parameters::{Parameter, TABLE};
use er_servo::{Config, Frame, Supervisor};
use wire::log::{Begin, Entry, Image, Recording as Run, recordings};

use crate::{AxisKind, Mode, Recording};

/// Bit of the column `fault` for a tick in which the drive did not follow its reference (boot, ready or stopping); the other
/// bits are the latched faults, [`er_servo::Faults`].
pub const NOT_RUNNING: u32 = 1 << 16;

/// The runs of a log.
///
/// # Errors
///
/// A file that is no image, a log of another image, a log without a recording; the message says what to do.
pub fn runs(elf: &[u8], log: &[u8]) -> Result<Vec<Run>, String> {
    let image = Image::parse(elf).map_err(|error| error.to_string())?;
    let entries = image.decode(log).map_err(|error| error.to_string())?;
    let runs = recordings(&entries);
    if runs.is_empty() {
        let damaged = entries.iter().filter(|entry| **entry == Entry::Damaged).count();
        let messages = entries.len();
        return Err(format!("no start of a recording among its {messages} messages, {damaged} of them damaged"));
    }
    Ok(runs)
}

/// What a replay must be told: the parameters of a run that are not the defaults, one line each, as `[controller]` of a machine
/// file has them; empty where there are none.
pub fn other_parameters(config: &Config) -> String {
    let defaults = Config::default();
    let others = TABLE.iter().filter(|parameter| (parameter.get)(config) != (parameter.get)(&defaults));
    others.map(|parameter| format!("{}\n", parameter_line(parameter, config))).collect()
}

/// A parameter as `[controller]` of a machine file has it.
pub fn parameter_line(parameter: &Parameter, config: &Config) -> String {
    match (parameter.get)(config) {
        value if parameter.unit == "flag" => format!("{} = {}", parameter.name, value != 0.0),
        value => format!("{} = {value} # {}, {} to {}", parameter.name, parameter.unit, parameter.min, parameter.max),
    }
}

/// Frames of a run as a recording. Ticks that were lost are missing rows, with a gap in `seq`, which goes on past the end of
/// the drive's 32-bit count.
pub fn recording(name: &str, begin: &Begin, frames: &[Frame]) -> Recording {
    let period_s = f64::from(begin.config.period_s);
    let since_begin = |frame: &Frame| frame.seq.wrapping_sub(begin.tick);
    let column = |value: &dyn Fn(&Frame) -> f64| frames.iter().map(value).collect::<Vec<f64>>();
    let gaps = frames.windows(2).enumerate().filter(|(_, pair)| pair[1].seq.wrapping_sub(pair[0].seq) != 1);
    Recording {
        name: name.to_owned(),
        axis: AxisKind::Rotary,
        t_s: column(&|frame| f64::from(since_begin(frame)) * period_s),
        position: column(&|frame| frame.outputs.position.to_rad()),
        effort_cmd: column(&|frame| f64::from(frame.outputs.torque_nm)),
        reference: Some(column(&|frame| frame.inputs.reference.to_rad())),
        field_cmd_kv_mm: Some(column(&|frame| f64::from(frame.outputs.field_kv_mm))),
        mode: Some(frames.iter().map(|frame| Mode::from(frame.outputs.mode)).collect()),
        velocity: Some(column(&|frame| f64::from(frame.outputs.speed_rad_s))),
        effort_meas: None,
        field_meas_kv_mm: Some(column(&|frame| f64::from(frame.inputs.field_monitor.to_kv_mm()))),
        temperature_c: None,
        seq: Some(frames.iter().map(|frame| u64::from(begin.tick) + u64::from(since_begin(frame))).collect()),
        fault: Some(frames.iter().map(fault).collect()),
        counts: Some(frames.iter().map(|frame| frame.outputs.position.0.into()).collect()),
        gaps: gaps.map(|(row, _)| row).collect(),
        extra: Vec::new(),
        mended: Vec::new(),
    }
}

fn fault(frame: &Frame) -> u32 {
    let latched = frame.outputs.supervisor.faults().bits();
    match frame.outputs.supervisor {
        Supervisor::Running => latched,
        _ => latched | NOT_RUNNING,
    }
}
