//! Mode of the damper.

/// What the controller commanded of the damper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// No field.
    Off,
    /// Field from equations (4) and (5).
    Damper,
    /// Constant braking field.
    Brake,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 3] = [Self::Off, Self::Damper, Self::Brake];

    /// The word in the column `mode`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Damper => "damper",
            Self::Brake => "brake",
        }
    }
}

/// The law's mode as recordings hold it.
impl From<er_servo::Mode> for Mode {
    fn from(mode: er_servo::Mode) -> Self {
        match mode {
            er_servo::Mode::Off => Self::Off,
            er_servo::Mode::Damper => Self::Damper,
            er_servo::Mode::Brake => Self::Brake,
        }
    }
}
