//! The machine in closed loop.

use crate::actuation::Actuation;
use crate::er_fluid::FlowCurve;
use crate::mechanics::room;
use crate::{Command, Er, Error, FluidResponse, Mechanics, Model, Segment, State};

/// Actuation and mechanics together, one command at a time.
///
/// ```
/// use plant::{Command, Model, Plant, State};
///
/// let mut plant = Plant::new(&Model::paper(), State::default(), 0.0)?;
/// for tick in 1..=200 {
///     // 2 N m and 1 kV/mm, held for 0.5 ms; the drive answers after 5 ms.
///     plant.advance(&Command::new(2.0, 1.0), f64::from(tick) * 0.0005)?;
/// }
/// assert!(plant.state().position > 0.0);
/// # Ok::<(), plant::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Plant {
    actuation: Actuation,
    mechanics: Mechanics,
    state: State,
    last: Option<Segment>,
    er: Option<Er>,
}

impl Plant {
    /// At `start_s` in `state`, with zero commands held since ever.
    ///
    /// # Errors
    /// [`Error::Parameter`] where the model does not hold water, [`Error::Time`] for a start that is no number.
    pub fn new(model: &Model, state: State, start_s: f64) -> Result<Self, Error> {
        let mechanics = Mechanics::new(model)?;
        if !start_s.is_finite() {
            return Err(Error::Time { previous_s: 0.0, t_s: start_s });
        }
        let actuation = Actuation::new(model, &Command::default(), start_s);
        Ok(Self { actuation, mechanics, state: state.with_motion(), last: None, er: model.er.clone() })
    }

    /// Holds `command` from now until `until_s` and moves there.
    ///
    /// # Errors
    /// [`Error::Command`] for a command that is no number, [`Error::Time`] where time runs back; nothing has moved then.
    #[inline]
    pub fn advance(&mut self, command: &Command, until_s: f64) -> Result<(), Error> {
        let previous_s = self.actuation.now_s();
        if !(until_s >= previous_s && until_s.is_finite()) {
            return Err(Error::Time { previous_s, t_s: until_s });
        }
        command.check(previous_s)?;
        self.actuation.command(command);
        while self.actuation.now_s() < until_s {
            let segment = self.actuation.next_segment(until_s);
            let _ = self.mechanics.run(&segment, segment.start_s, segment.end_s, &mut self.state);
            self.last = Some(segment);
        }
        Ok(())
    }

    /// True state of the mechanics now.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The position with the eccentricity of the sensor, rad (m): what a [`crate::sensor::Sampler`] measures. Latency is
    /// added by a [`crate::sensor::LatencyLine`].
    pub fn position_at_sensor(&self) -> f64 {
        self.mechanics.sensor().distorted(self.state.position)
    }

    /// Puts the mechanics elsewhere; commands under way stay under way.
    pub fn set_state(&mut self, state: State) {
        self.state = state.with_motion();
    }

    /// Now, s.
    pub fn now_s(&self) -> f64 {
        self.actuation.now_s()
    }

    /// Drag of the fluid now, N m (N), not negative; at rest the most it holds against. The torque of a fluid's spring
    /// below yield is not in it, nor is its drift.
    pub fn er_torque(&self) -> f64 {
        let (Some(er), Some(segment)) = (&self.er, &self.last) else { return 0.0 };
        let (a, b) = er.acting();
        let dt_s = segment.end_s - segment.start_s;
        let fluid = segment.fluid.at(dt_s);
        match er.response {
            FluidResponse::Field(field) => {
                let flow = |curve: FlowCurve| curve.torque(curve.at(er.field_gain * fluid), self.state.velocity.abs());
                (a * fluid + b) * fluid + field.flow.map_or(0.0, flow)
            }
            FluidResponse::ViscosityDeadTime { torque_limit, .. }
            | FluidResponse::ViscosityLag { torque_limit, .. } => {
                let brake = segment.brake_torque.at(dt_s);
                brake + (fluid * self.state.velocity.abs()).min(room(torque_limit, brake))
            }
        }
    }

    /// What acted on the rotor just before now; none before the first advance.
    pub fn last_segment(&self) -> Option<&Segment> {
        self.last.as_ref()
    }
}
