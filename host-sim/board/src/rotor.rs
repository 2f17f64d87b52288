//! The machine on the shaft.

use plant::{Command, Er, Model, Plant, State};

/// The rotor, moved exactly from event to event.
#[derive(Debug)]
pub struct Rotor {
    plant: Plant,
    command: Command,
}

impl Rotor {
    /// The paper's machine with the field delayed by 2 ms and lagging by 3 ms, at rest at an angle.
    ///
    /// # Errors
    ///
    /// A model the plant refuses; not this one.
    pub fn paper(angle_rad: f64) -> Result<Self, plant::Error> {
        let model = Model { er: Some(Er::new(0.0704, 0.470, 0.002, 0.003)), ..Model::paper() };
        Ok(Self { plant: Plant::new(&model, State::new(angle_rad, 0.0), 0.0)?, command: Command::default() })
    }

    /// Moves to `now_s`. Going back, or a command that is no number, cannot come from the board and moves nothing.
    pub fn advance_to(&mut self, now_s: f64) {
        if now_s > self.plant.now_s() {
            let _ = self.plant.advance(&self.command, now_s);
        }
    }

    /// Holds torque and field from now on.
    pub fn command(&mut self, torque_nm: f64, field_kv_mm: f64) {
        self.command.torque = torque_nm;
        self.command.field_kv_mm = field_kv_mm;
    }

    /// A torque from outside, N m, from now on.
    pub fn disturb(&mut self, torque_nm: f64) {
        self.command.external_torque = torque_nm;
    }

    /// Angle, rad.
    pub fn angle_rad(&self) -> f64 {
        self.plant.state().position
    }

    /// Speed, rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.plant.state().velocity
    }

    /// The field that acts, kV/mm.
    pub fn field_kv_mm(&self) -> f64 {
        self.plant.last_segment().map_or(0.0, |segment| segment.fluid.at(segment.end_s - segment.start_s))
    }
}
