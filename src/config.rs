//! Configuration in SI units.

/// What the law is built from; every value in SI units, checked when built into parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Proportional gain, N m/rad.
    pub kp_nm_rad: f32,
}
