//! The one way into the control law.

use bitflags::bitflags;

use crate::law::mode::{self, Mode};
use crate::law::pd;
use crate::law::resolver::Tracking;
use crate::law::speed;
use crate::law::supervisor::{self, Request, Supervisor};
use crate::units::{Counts, MonitorCode, ResolverCode};
use crate::{Faults, Limits, Params};

bitflags! {
    /// What the pins and the link say in this tick.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
    pub struct InputFlags: u8 {
        /// The high-voltage interlock is closed; an open one forbids any field.
        const INTERLOCK_CLOSED = 1 << 0;
        /// The emergency stop is pressed.
        const STOP_PRESSED = 1 << 1;
        /// The command link has been heard of recently.
        const LINK_ALIVE = 1 << 2;
        /// The reference comes from the link, so that its silence is a fault.
        const REFERENCE_FROM_LINK = 1 << 3;
        /// The resolver could not be read in this tick; its code means nothing.
        const RESOLVER_UNREAD = 1 << 4;
        /// No tick was made for a while before this one: where the axis went meanwhile is not known.
        const PAUSED = 1 << 5;
        /// The motor's amplifier is ready, its temperature contact closed.
        const AMPLIFIER_READY = 1 << 6;
        /// The reference is held at a soft limit.
        const REFERENCE_LIMITED = 1 << 7;
    }
}

/// What the resolver converter delivered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResolverSample {
    /// Position within a pole pair.
    pub code: ResolverCode,
    /// The converter's fault byte (AD2S1210, register 0xFF); 0 for none.
    pub fault_byte: u8,
    /// The converter's own speed, rad/s; used only with `speed_from_converter`.
    pub speed_rad_s: f32,
}

/// Everything the law may know in one tick; what is not in here cannot influence it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Position and faults of the resolver.
    pub resolver: ResolverSample,
    /// Pins and link.
    pub flags: InputFlags,
    /// Reference position; with [`Request::SetPosition`] what the position is to be called.
    pub reference: Counts,
    /// What the user asks for.
    pub request: Request,
    /// Greatest torque of this command, whole N m, 1 to 30; 0 for no bound but the parameter's.
    pub torque_bound_nm: u8,
    /// The field that really acts.
    pub field_monitor: MonitorCode,
    /// Faults the application found outside the law: overrun, damaged parameters, DAC not written, abnormal reset.
    pub reported: Faults,
}

/// What the law remembers from tick to tick. `State::default()` is the state at reset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    pub(crate) tracking: Tracking,
    pub(crate) speed_rad_s: f32,
    pub(crate) torque_nm: f32,
    pub(crate) still_ticks: u32,
    pub(crate) supervisor: Supervisor,
    pub(crate) stop_ticks: u32,
    pub(crate) homed: bool,
}

impl State {
    /// Running and at rest at a position, as it is in the tick after an enable: where simulations and replays of
    /// recordings without a snapshot begin.
    pub fn running_at(position: Counts) -> Self {
        let code = ResolverCode((position.0 & 0x0fff) as u16);
        Self { tracking: Tracking::Located { code, position }, supervisor: Supervisor::Running, ..Self::default() }
    }

    /// Running in mid-motion, where a recording begins or goes on after a gap: position and speed estimate of the last
    /// tick before. The way of that tick is not known, so the next change of speed is not checked.
    pub fn resumed_at(position: Counts, speed_rad_s: f32) -> Self {
        Self { speed_rad_s, ..Self::running_at(position) }
    }

    /// State of the drive.
    pub fn supervisor(&self) -> Supervisor {
        self.supervisor
    }

    /// Whether the position was set since it was last lost, so that it counts from the user's zero.
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// Position, counts; 0 before the first reading.
    pub fn position(&self) -> Counts {
        self.tracking.position()
    }
}

/// What the law commands and everything it decided, for the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Torque command, N m, within plus and minus 30.
    pub torque_nm: f32,
    /// Field command, kV/mm, within 0 and 3.5.
    pub field_kv_mm: f32,
    /// What the damper is used as.
    pub mode: Mode,
    /// Whether the high-voltage supply may be on.
    pub hv_enable: bool,
    /// Position.
    pub position: Counts,
    /// The speed the law used, rad/s.
    pub speed_rad_s: f32,
    /// State of the drive.
    pub supervisor: Supervisor,
    /// What bounded or refused a command in this tick.
    pub limits: Limits,
}

/// One tick of the control law.
///
/// For any inputs, state and parameters whatever: returns, all values finite, torque within 30 N m, field within 0 to
/// 3.5 kV/mm, and both 0 unless running or stopping. A fault acts in the tick it is seen.
#[inline]
pub fn step(params: &Params, state: &mut State, inputs: &Inputs) -> Outputs {
    let position_faults = track(params, state, inputs);
    let (speed_rad_s, speed_faults) = speed::select(params, state.speed_rad_s, inputs.resolver.speed_rad_s);
    let position = state.tracking.position();
    let wanted = want(params, inputs, position, speed_rad_s);

    let faults = external_faults(params, state, inputs) | position_faults | speed_faults | wanted.faults;
    let at_rest = supervisor::is_rest(params, speed_rad_s) || state.stop_ticks >= params.stop.ticks;
    let (supervisor, refused) = state.supervisor.next(params, faults, inputs.flags, inputs.request, at_rest);
    if matches!(supervisor, Supervisor::Fault { .. }) && faults.intersects(Faults::LOSES_POSITION) {
        lose_position(state);
    }
    state.supervisor = supervisor;
    let decided = match supervisor {
        Supervisor::Running => Some(wanted),
        Supervisor::Stopping { .. } => Some(want_rest(params, speed_rad_s)),
        _ => None,
    };
    let stopping = matches!(supervisor, Supervisor::Stopping { .. });
    state.stop_ticks = if stopping { state.stop_ticks.saturating_add(1) } else { 0 };
    let hv_enable = decided.is_some();
    let decided = decided.unwrap_or_default();
    state.torque_nm = decided.torque_nm;
    Outputs {
        torque_nm: decided.torque_nm,
        field_kv_mm: decided.field_kv_mm,
        mode: decided.mode,
        hv_enable,
        position,
        speed_rad_s,
        supervisor,
        limits: refused | decided.limits,
    }
}

/// What is commanded if the supervisor lets it.
#[derive(Debug, Clone, Copy, Default)]
struct Wanted {
    torque_nm: f32,
    field_kv_mm: f32,
    mode: Mode,
    limits: Limits,
    faults: Faults,
}

/// The law itself: follows the reference.
fn want(params: &Params, inputs: &Inputs, position: Counts, speed_rad_s: f32) -> Wanted {
    let bound_nm = if inputs.torque_bound_nm == 0 { f32::MAX } else { f32::from(inputs.torque_bound_nm) };
    let (error, error_limits) = pd::error_counts(inputs.reference, position);
    let (torque_nm, torque_limits, torque_faults) = pd::torque_nm(params, error, speed_rad_s, bound_nm);
    let mode = mode::choose(params, error, speed_rad_s);
    let (field_kv_mm, field_limits, field_faults) = mode::field(params, mode, speed_rad_s);
    let over_speed = if mode == Mode::Off && params.er_enabled { Limits::OVER_OFF_SPEED } else { Limits::empty() };
    let limits = error_limits | torque_limits | field_limits | over_speed;
    Wanted { torque_nm, field_kv_mm, mode, limits, faults: torque_faults | field_faults }
}

/// A controlled stop: the damping of the law against the motion, bounded, and the field of the brake. A value that is no
/// number is 0 here, and a fault of the law in the same tick.
fn want_rest(params: &Params, speed_rad_s: f32) -> Wanted {
    let (torque_nm, torque_limits, _) = pd::torque_nm(params, 0, speed_rad_s, params.stop.torque_nm);
    let mode = if params.er_enabled { Mode::Brake } else { Mode::Off };
    let (field_kv_mm, field_limits, _) = mode::field(params, mode, speed_rad_s);
    Wanted { torque_nm, field_kv_mm, mode, limits: torque_limits | field_limits, faults: Faults::empty() }
}

fn lose_position(state: &mut State) {
    state.tracking = Tracking::Lost;
    state.homed = false;
}

/// Gives the position a new name where nothing moves on its own.
fn set_position(state: &mut State, inputs: &Inputs) {
    let may = matches!(state.supervisor, Supervisor::Ready);
    if may && inputs.request == Request::SetPosition {
        state.homed = state.tracking.rename(inputs.reference);
    }
}

/// Takes the resolver's reading into the state, and says what is wrong with it.
fn track(params: &Params, state: &mut State, inputs: &Inputs) -> Faults {
    if inputs.flags.contains(InputFlags::PAUSED) {
        lose_position(state);
        state.speed_rad_s = 0.0;
    }
    if inputs.flags.contains(InputFlags::RESOLVER_UNREAD) {
        return Faults::RESOLVER_BUS;
    }
    if inputs.resolver.fault_byte != 0 {
        return Faults::RESOLVER_CHIP;
    }
    let (tracking, mut faults) = state.tracking.read(params, inputs.resolver.code);
    state.tracking = tracking;
    let moved_counts = tracking.moved_counts();
    set_position(state, inputs);
    state.speed_rad_s = speed::estimate_rad_s(params, state.speed_rad_s, moved_counts);
    if !state.speed_rad_s.is_finite() {
        state.speed_rad_s = 0.0;
        faults |= Faults::NOT_FINITE;
    }
    // A rotor at rest is no fault, a rotor at rest under a torque that nothing can hold is one.
    let pushed = state.torque_nm.abs() >= params.stale_torque_nm;
    state.still_ticks = if pushed && moved_counts == 0 { state.still_ticks.saturating_add(1) } else { 0 };
    if state.still_ticks > params.stale_ticks {
        state.still_ticks = 0;
        faults |= Faults::RESOLVER_STALE;
    }
    faults
}

/// What is wrong outside the resolver.
fn external_faults(params: &Params, state: &State, inputs: &Inputs) -> Faults {
    let mut faults = inputs.reported;
    let running = matches!(state.supervisor, Supervisor::Running | Supervisor::Stopping { .. });
    let flags = inputs.flags;
    if running && !flags.contains(InputFlags::INTERLOCK_CLOSED) {
        faults |= Faults::INTERLOCK_OPEN;
    }
    if running && flags.contains(InputFlags::STOP_PRESSED) {
        faults |= Faults::STOP_PRESSED;
    }
    if running && flags.contains(InputFlags::REFERENCE_FROM_LINK) && !flags.contains(InputFlags::LINK_ALIVE) {
        faults |= Faults::LINK_LOST;
    }
    // A damaged trip level trips.
    if inputs.field_monitor.to_kv_mm() > params.field_trip_kv_mm || params.field_trip_kv_mm.is_nan() {
        faults |= Faults::FIELD_OVER;
    }
    if !params.intact() {
        faults |= Faults::PARAMETERS;
    }
    faults
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    #[test]
    fn damaged_parameters_are_a_fault_in_the_same_tick_and_move_nothing() {
        let sound = Params::new(&Config::default()).unwrap();
        let damages: [fn(&mut Params); 5] = [
            |p| p.kp_nm_count = f32::NAN,
            |p| p.torque_limit_nm = f32::INFINITY,
            |p| p.field_limit_kv_mm = 9.0,
            |p| p.near_counts = i32::MIN,
            |p| p.field_trip_kv_mm = f32::NAN,
        ];
        for damage in damages {
            let mut params = sound;
            damage(&mut params);
            let mut state = State::running_at(Counts(0));
            let flags = InputFlags::INTERLOCK_CLOSED;
            let outputs = step(&params, &mut state, &Inputs { flags, reference: Counts(9000), ..Inputs::default() });
            assert!(outputs.supervisor.faults().contains(Faults::PARAMETERS));
            assert_eq!((outputs.torque_nm, outputs.field_kv_mm, outputs.hv_enable), (0.0, 0.0, false));
        }
    }
}
