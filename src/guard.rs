//! Supervision around the law: what must hold of the machine and is no part of the control.
//!
//! It sees what the law sees and what the law decided a tick before, and hands its faults to the law as reported ones: so
//! a recording that holds the inputs of [`crate::step()`] replays to the bit whatever was supervised.

use crate::{Faults, InputFlags, Inputs, Outputs, Params, Request, Supervisor};

/// Field that may be left when the high voltage is off, kV/mm: 60 V over the gap of 0.5 mm, the limit of safe extra-low
/// voltage (IEC 61140).
pub const SAFE_FIELD_KV_MM: f32 = 0.12;

/// What the guard remembers from tick to tick.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Guard {
    following_ticks: u32,
    apart_ticks: u32,
    off_ticks: u32,
    expected_kv_mm: f32,
}

impl Guard {
    /// What is wrong in this tick, from its inputs and what the law decided in the last one.
    pub fn check(&mut self, params: &Params, inputs: &Inputs, last: Option<&Outputs>) -> Faults {
        let Some(last) = last else { return Faults::empty() };
        let running = last.supervisor == Supervisor::Running;
        let mut faults = self.field(params, inputs, last);
        faults.set(Faults::FOLLOWING_ERROR, self.follows_badly(params, inputs, last, running));
        let too_fast = last.speed_rad_s.abs() > params.guard.over_speed_rad_s;
        faults.set(Faults::OVER_SPEED, last.hv_enable && too_fast);
        let ready = inputs.flags.contains(InputFlags::AMPLIFIER_READY);
        faults.set(Faults::AMPLIFIER, !ready && (last.hv_enable || inputs.request == Request::Enable));
        faults
    }

    fn follows_badly(&mut self, params: &Params, inputs: &Inputs, last: &Outputs, running: bool) -> bool {
        let error_counts = inputs.reference.0.abs_diff(last.position.0);
        let far = running && error_counts > params.guard.following_counts;
        self.following_ticks = if far { self.following_ticks.saturating_add(1) } else { 0 };
        self.following_ticks > params.guard.following_ticks
    }

    /// The monitor against the command through the field's lag, and against nothing once it is off.
    fn field(&mut self, params: &Params, inputs: &Inputs, last: &Outputs) -> Faults {
        let guard = &params.guard;
        let seen_kv_mm = inputs.field_monitor.to_kv_mm();
        self.expected_kv_mm += guard.field_lag_gain * (last.field_kv_mm - self.expected_kv_mm);
        let apart = last.hv_enable && (seen_kv_mm - self.expected_kv_mm).abs() > guard.field_apart_kv_mm;
        self.apart_ticks = if apart { self.apart_ticks.saturating_add(1) } else { 0 };
        self.off_ticks = if last.hv_enable { 0 } else { self.off_ticks.saturating_add(1) };
        let mut faults = Faults::empty();
        faults.set(Faults::FIELD_APART, self.apart_ticks > guard.field_apart_ticks);
        faults.set(Faults::HV_PRESENT, self.off_ticks > guard.hv_off_ticks && seen_kv_mm > SAFE_FIELD_KV_MM);
        faults
    }
}
