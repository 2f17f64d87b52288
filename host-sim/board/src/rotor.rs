//! The machine on the shaft: held still.

/// The rotor.
#[derive(Debug)]
pub struct Rotor {
    angle_rad: f64,
}

impl Rotor {
    /// Held at an angle.
    pub fn held(angle_rad: f64) -> Self {
        Self { angle_rad }
    }
    /// now
    pub fn advance_to(&mut self, _now_s: f64) {}
    /// cmd
    pub fn command(&mut self, _torque_nm: f64, _field_kv_mm: f64) {}
    /// a
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }
    /// s
    pub fn speed_rad_s(&self) -> f64 {
        0.0
    }
    /// f
    pub fn field_kv_mm(&self) -> f64 {
        0.0
    }
}
