//! The recorded inputs through the very control law, compared with the recorded commands bit for bit.
//!
//! A difference means that another controller ran: another gain, another build, lost frames. No physics may be named then.
//!
//! What a recording lacks is said, not guessed: after its start and after each gap the speed estimate is unknown. Where the
//! column `velocity_rad_s` holds it, the law goes on from there and is compared as soon as it computes the recorded speed to
//! the bit; where not, it runs without comparison until its low-pass has forgotten the start (`settling`).

use er_servo::{
    Config, Counts, Faults, InputFlags, Inputs, Outputs, Params, ResolverCode, ResolverSample, State, Supervisor, step,
};

use crate::Error;
use crate::{AxisKind, Mode, Recording};

/// What a replay found.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// Rows of the recording.
    pub rows: usize,
    /// Rows whose commands were compared; the others follow a start in motion or a gap, or a drive that was not running.
    pub compared: usize,
    /// The first difference; none when identical.
    pub difference: Option<Difference>,
}

/// The first command that the law would not have given.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Row of the recording, from 0; its line in a CSV file is two more.
    pub row: usize,
    /// Time of the row, s.
    pub t_s: f64,
    /// Column that differs.
    pub column: &'static str,
    /// What the recording holds.
    pub recorded: String,
    /// What the law computes.
    pub computed: String,
}

impl std::fmt::Display for Replay {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.difference {
            None => write!(f, "identical, {} rows", self.rows)?,
            Some(d) => write!(
                f,
                "first difference in row {} (line {}), t = {} s: {} is {}, the law computes {}",
                d.row,
                d.row + 2,
                d.t_s,
                d.column,
                d.recorded,
                d.computed
            )?,
        }
        let unchecked = self.rows - self.compared;
        if unchecked > 0 && self.difference.is_none() {
            write!(f, " ({unchecked} not compared: not running, or the speed estimate not yet known)")?;
        }
        Ok(())
    }
}

/// Replays a recording through the law built from `config`.
///
/// # Errors
/// A configuration the law refuses, a linear axis, a recording without reference, or one that another than the law commanded.
pub fn replay(recording: &Recording, config: &Config) -> Result<Replay, Error> {
    let about = |message: String| Error::Usage(format!("{}: {message}", recording.name));
    let params = Params::new(config).map_err(|error| about(format!("[controller] {error}")))?;
    if recording.axis != AxisKind::Rotary {
        return Err(about("the control law is that of a rotary axis; leave [controller] out".to_owned()));
    }
    if let Some(mode) = recording.mode_beside_the_law() {
        return Err(about(format!(
            "the mode `{mode}` commanded, which the flashed law does not have: a replay to the bit does not apply"
        )));
    }
    let Some(reference) = &recording.reference else {
        return Err(about("replay needs the column reference_rad".to_owned()));
    };
    if config.speed_from_converter && recording.velocity.is_none() {
        return Err(about(
            "the law took its speed from the converter; replay needs the column velocity_rad_s".to_owned(),
        ));
    }
    let settling = settling_rows(config);
    let run = |starts_at_rest| Replayer::new(recording, reference, params, settling, starts_at_rest).run();
    let from_rest = run(true);
    // Only the estimate at the start may be to blame for a difference this early.
    if from_rest.difference.as_ref().is_none_or(|difference| difference.row >= settling) {
        return Ok(from_rest);
    }
    let in_motion = run(false);
    let blames_the_law = in_motion.difference.is_some() && shows_rest(recording);
    Ok(if blames_the_law { from_rest } else { in_motion })
}

/// Whether the recording begins at rest by its own account, so that its first rows can be judged.
fn shows_rest(recording: &Recording) -> bool {
    let still = recording.position.get(1).is_none_or(|next| *next == recording.position[0]);
    still && recording.velocity.as_ref().is_none_or(|velocity| velocity[0] == 0.0)
}

/// Rows after which an unknown start of the speed estimate no longer shows in the last bit of a command: 24 bits of the
/// significand and 12 more for a start that was far off, at exp(-period/filter) a row.
fn settling_rows(config: &Config) -> usize {
    let bits = 36.0 * std::f64::consts::LN_2;
    (bits * f64::from(config.speed_filter_s) / f64::from(config.period_s)).ceil() as usize + 1
}

struct Replayer<'a> {
    recording: &'a Recording,
    reference: &'a [f64],
    params: Params,
    settling: usize,
    /// Whether the first row is taken as the first after an enable at rest, so that nothing is unknown.
    starts_at_rest: bool,
    state: State,
    running: bool,
    /// Rows still to run without comparison.
    unsettled: usize,
    compared: usize,
}

impl<'a> Replayer<'a> {
    fn new(
        recording: &'a Recording,
        reference: &'a [f64],
        params: Params,
        settling: usize,
        starts_at_rest: bool,
    ) -> Self {
        let (state, running) = (State::default(), false);
        Self { recording, reference, params, settling, starts_at_rest, state, running, unsettled: 0, compared: 0 }
    }

    fn run(mut self) -> Replay {
        let rows = self.recording.t_s.len();
        let difference = (0..rows).find_map(|row| self.row(row));
        Replay { rows, compared: self.compared, difference }
    }

    fn row(&mut self, row: usize) -> Option<Difference> {
        if self.is_stopped(row) {
            self.running = false;
            return None;
        }
        let after_gap = row > 0 && self.recording.gaps.binary_search(&(row - 1)).is_ok();
        if after_gap || !self.running {
            self.running = true;
            if !(self.starts_at_rest && row == 0) {
                self.resume(row);
                return None;
            }
            self.state = State::running_at(self.counts(row));
        }
        let inputs = self.inputs(row);
        let outputs = step(&self.params, &mut self.state, &inputs);
        self.running = outputs.supervisor == Supervisor::Running;
        if self.is_recorded_speed(row, outputs.speed_rad_s) {
            self.unsettled = 0;
        }
        if self.unsettled > 0 {
            self.unsettled -= 1;
            return None;
        }
        self.compared += 1;
        self.difference(row, &outputs)
    }

    /// Whether the recording says that the drive was not running.
    fn is_stopped(&self, row: usize) -> bool {
        self.recording.fault.as_ref().is_some_and(|fault| fault[row] != 0)
    }

    /// Takes the row as the last tick before those that can be computed: its way from the tick before is not known.
    fn resume(&mut self, row: usize) {
        let speed_rad_s = self.recording.velocity.as_ref().map_or(0.0, |velocity| velocity[row] as f32);
        self.state = State::resumed_at(self.counts(row), speed_rad_s);
        self.unsettled = self.settling;
    }

    /// Whether the recording confirms the law's speed, and so its whole memory.
    fn is_recorded_speed(&self, row: usize, speed_rad_s: f32) -> bool {
        self.recording.velocity.as_ref().is_some_and(|velocity| same(velocity[row] as f32, speed_rad_s))
    }

    fn counts(&self, row: usize) -> Counts {
        match &self.recording.counts {
            // A count beyond 32 bits cannot come from this controller; its replay will differ, which is the answer.
            Some(counts) => Counts(counts[row].clamp(i32::MIN.into(), i32::MAX.into()) as i32),
            None => Counts::from_rad(self.recording.position[row]),
        }
    }

    fn inputs(&self, row: usize) -> Inputs {
        let velocity = self.recording.velocity.as_ref().map_or(0.0, |velocity| velocity[row] as f32);
        Inputs {
            resolver: ResolverSample {
                code: ResolverCode((self.counts(row).0 & 0x0fff) as u16),
                fault_byte: 0,
                speed_rad_s: velocity,
            },
            flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE,
            reference: Counts::from_rad(self.reference[row]),
            reported: Faults::empty(),
            ..Inputs::default()
        }
    }

    fn difference(&self, row: usize, outputs: &Outputs) -> Option<Difference> {
        let differs = |column, recorded, computed| {
            Some(Difference { row, t_s: self.recording.t_s[row], column, recorded, computed })
        };
        let torque = self.recording.effort_cmd[row] as f32;
        if !same(torque, outputs.torque_nm) {
            return differs("torque_cmd_nm", torque.to_string(), outputs.torque_nm.to_string());
        }
        if let Some(field) = self.recording.field_cmd_kv_mm.as_ref().map(|field| field[row] as f32)
            && !same(field, outputs.field_kv_mm)
        {
            return differs("field_cmd_kv_mm", field.to_string(), outputs.field_kv_mm.to_string());
        }
        let mode = self.recording.mode.as_ref().map(|mode| mode[row])?;
        let computed = Mode::from(outputs.mode);
        if mode == computed { None } else { differs("mode", mode.name().to_owned(), computed.name().to_owned()) }
    }
}

/// Equal bits; the two zeros are one, as a decimal file may drop the sign.
fn same(recorded: f32, computed: f32) -> bool {
    recorded.to_bits() == computed.to_bits() || (recorded == 0.0 && computed == 0.0)
}
