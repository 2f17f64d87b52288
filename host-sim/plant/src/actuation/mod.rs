//! From commands to what acts on the rotor: a sequence of segments, each a formula of time.
//!
//! The motion of the rotor has no part in this, so a recording's commands are turned into segments once and then serve
//! any number of simulations.

mod channel;
mod signal;

use crate::effects::Pulse;
use crate::{Command, FluidResponse, Model};
use channel::{Channel, coincidence_s};
pub use signal::Signal;

/// Speed below which a viscosity cannot be recovered from the field, rad/s: Q = (a E^2 + b E) / max(|w_est|, this).
const LEAST_SPEED_ESTIMATE: f64 = 0.002;

/// What acts on the rotor from `start_s` to `end_s`; every [`Signal`] counts time from `start_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Start, s.
    pub start_s: f64,
    /// End, s; infinite after the last change of a recording.
    pub end_s: f64,
    /// Motor torque, after gain, bias, limit, delay and lag, N m (N).
    pub torque: Signal,
    /// Torque from outside, N m (N).
    pub external_torque: f64,
    /// The field that acts, kV/mm; for the viscosity models the coefficient Q, N m s/rad (N s/m).
    pub fluid: Signal,
    /// Brake torque of the viscosity models, N m (N); zero for the others.
    pub brake_torque: Signal,
}

/// The state of everything between commands and rotor.
#[derive(Debug, Clone)]
pub(crate) struct Actuation {
    drive: Drive,
    fluid: Fluid,
    torque: Channel,
    field_or_q: Channel,
    brake: Channel,
    external_torque: f64,
    pulses: Vec<Pulse>,
    now_s: f64,
}

/// Static part of the drive.
#[derive(Debug, Clone, Copy)]
struct Drive {
    gain: f64,
    offset: f64,
    limit: f64,
    deadband: f64,
}

impl Drive {
    fn torque(&self, command: f64) -> f64 {
        let beyond = (command.abs() - self.deadband).max(0.0).copysign(command);
        (self.gain * beyond + self.offset).max(-self.limit).min(self.limit)
    }
}

/// What of the fluid the commands are translated into.
#[derive(Debug, Clone, Copy)]
enum Fluid {
    None,
    Field,
    Viscosity { a: f64, b: f64 },
}

impl Fluid {
    /// Inputs of the channels for field or Q, and for the brake torque.
    #[inline]
    fn inputs(&self, command: &Command) -> (f64, f64) {
        let field = command.field_kv_mm.max(0.0);
        match *self {
            Fluid::None => (0.0, 0.0),
            Fluid::Field => (field, 0.0),
            Fluid::Viscosity { a, b } => {
                let torque = (a * field + b) * field;
                if command.braking {
                    (0.0, torque)
                } else {
                    let recovered = torque / command.speed_estimate.abs().max(LEAST_SPEED_ESTIMATE);
                    (command.viscosity.map_or(recovered, |viscosity| viscosity.max(0.0)), 0.0)
                }
            }
        }
    }
}

impl Actuation {
    /// At `start_s`, with `before` held since ever. The model must have been validated.
    pub(crate) fn new(model: &Model, before: &Command, start_s: f64) -> Self {
        let drive = Drive {
            gain: model.torque_gain,
            offset: model.torque_offset,
            limit: model.torque_limit.unwrap_or(f64::INFINITY),
            deadband: model.torque_deadband,
        };
        let (fluid, response) = match &model.er {
            None => (Fluid::None, None),
            Some(er) => match er.response {
                FluidResponse::Field(_) => (Fluid::Field, Some(er.response)),
                _ => {
                    let (a, b) = er.acting();
                    (Fluid::Viscosity { a, b }, Some(er.response))
                }
            },
        };
        let (first, brake) = fluid.inputs(before);
        let channel = |value| match response {
            None => Channel::lagging(value, 0.0, 0.0),
            Some(FluidResponse::Field(field)) => {
                let slew = field.slew_kv_mm_s.unwrap_or(f64::INFINITY);
                Channel::new(value, field.dead_time_s, slew, field.rise_s, field.fall_s).over_the_field(field.kinetics)
            }
            Some(FluidResponse::ViscosityDeadTime { dead_time_s, .. }) => Channel::lagging(value, dead_time_s, 0.0),
            Some(FluidResponse::ViscosityLag { lag_s, .. }) => Channel::lagging(value, 0.0, lag_s),
        };
        Self {
            drive,
            fluid,
            torque: Channel::lagging(drive.torque(before.torque), model.torque_delay_s, model.torque_lag_s),
            field_or_q: channel(first),
            brake: channel(brake),
            external_torque: before.external_torque,
            pulses: model.pulses.clone(),
            now_s: start_s,
        }
    }

    /// Start of the next segment, s.
    pub(crate) fn now_s(&self) -> f64 {
        self.now_s
    }

    /// Takes a command given now.
    #[inline]
    pub(crate) fn command(&mut self, command: &Command) {
        let (fluid, brake) = self.fluid.inputs(command);
        self.torque.push(self.now_s, self.drive.torque(command.torque));
        self.field_or_q.push(self.now_s, fluid);
        self.brake.push(self.now_s, brake);
        self.external_torque = command.external_torque;
    }

    /// The segment from now to the next change, at the latest to `until_s`, which becomes the new now.
    #[inline]
    pub(crate) fn next_segment(&mut self, until_s: f64) -> Segment {
        let start_s = self.now_s;
        let same_s = coincidence_s(start_s);
        let mut end_s = until_s;
        for channel in [&mut self.torque, &mut self.field_or_q, &mut self.brake] {
            channel.update(start_s, same_s);
            end_s = end_s.min(channel.next_change_s(start_s));
        }
        let mut external_torque = self.external_torque;
        for pulse in &self.pulses {
            let (on_s, off_s) = (pulse.start_s, pulse.end_s());
            if on_s <= start_s + same_s && start_s + same_s < off_s {
                external_torque += pulse.amplitude;
            }
            for change_s in [on_s, off_s] {
                if change_s > start_s + same_s {
                    end_s = end_s.min(change_s);
                }
            }
        }
        end_s = if end_s >= until_s - same_s { until_s } else { end_s.max(start_s + same_s) };
        let segment = Segment {
            start_s,
            end_s,
            torque: self.torque.output(),
            external_torque,
            fluid: self.field_or_q.output(),
            brake_torque: self.brake.output(),
        };
        if end_s.is_finite() {
            for channel in [&mut self.torque, &mut self.field_or_q, &mut self.brake] {
                channel.rebase(end_s - start_s);
            }
        }
        self.now_s = end_s;
        segment
    }
}
