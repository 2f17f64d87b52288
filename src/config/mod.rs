//! Configuration in SI units, and the parameters precomputed from it.

mod error;
mod params;

pub use error::ConfigError;
pub use params::Params;

/// Widest soft limits of the position, rad: well within what the counter holds, 4,369 revolutions.
pub(crate) const POSITION_RANGE_RAD: f32 = 25_000.0;
/// Exponent of equation (5) as printed: constant, coefficients of the speed and of its square.
pub(crate) const EQUATION_5: [f32; 3] = [4.010, -9.277, 3.675];
/// Control period of the image, s: its timer is fixed (board.md).
pub const IMAGE_PERIOD_S: f32 = 0.0005;
/// From the falling edge of SAMPLE until torque and field change at the outputs, ns: the image's timer makes both edges, so that it
/// is the same in every tick. Twice what a tick takes to have the commands ready on the emulated board (`--test budget` in
/// `host-sim/board`), as a core takes more than the cycle that the emulator counts for an instruction.
pub const SAMPLE_TO_OUTPUT_NS: u32 = 30_000;

/// What the law is built from. Names end in the unit; ranges stand in [`crate::parameters::TABLE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Control period.
    pub period_s: f32,
    /// Proportional gain K_P.
    pub kp_nm_rad: f32,
    /// Velocity-feedback gain K_D.
    pub kd_nm_s_rad: f32,
    /// Torque command held within plus and minus this.
    pub torque_limit_nm: f32,
    /// False: the field stays at 0 whatever the motion.
    pub er_enabled: bool,
    /// a of equation (2), N m per (kV/mm)^2.
    pub er_a: f32,
    /// b of equation (2), N m per kV/mm.
    pub er_b: f32,
    /// c of equation (2): drag at zero field; the law needs it only to check `near_rad`.
    pub er_c_nm: f32,
    /// Constant of the exponent of equation (5), for a viscosity in N m s/rad.
    pub er_q0: f32,
    /// Coefficient of the speed in that exponent.
    pub er_q1_s_rad: f32,
    /// Coefficient of its square.
    pub er_q2_s2_rad2: f32,
    /// Field command held at or below this.
    pub field_limit_kv_mm: f32,
    /// Field of the brake.
    pub brake_field_kv_mm: f32,
    /// The brake acts only below this error; 0 turns it off.
    pub near_rad: f32,
    /// Measured speeds up to this count as rest for the brake; at least one count a sample, 0.0257, or it chatters.
    pub brake_deadband_rad_s: f32,
    /// The brake also holds at rest.
    pub hold: bool,
    /// Above this speed the field is off.
    pub off_speed_rad_s: f32,
    /// Time constant of the low-pass on the speed estimate; 0 for none.
    pub speed_filter_s: f32,
    /// Speed from the converter's own output in place of the difference of counts.
    pub speed_from_converter: bool,
    /// A faster reading is a jump.
    pub max_speed_rad_s: f32,
    /// A faster change of speed is a jump.
    pub max_acceleration_rad_s2: f32,
    /// Torque under which the rotor cannot stand still: over friction plus the highest ER torque.
    pub stale_torque_nm: f32,
    /// How long the counts may stand still under that torque; covers the delay of the motor system.
    pub stale_time_s: f32,
    /// Monitored field that trips the drive.
    pub field_trip_kv_mm: f32,
    /// From reset to ready: the converter settles in 20 ms.
    pub boot_time_s: f32,
    /// Inertia the stability margins are computed with.
    pub inertia_kg_m2: f32,
    /// Delay of the motor system the stability margins are computed with.
    pub motor_delay_s: f32,
    /// Error that trips the drive when it lasts for `following_time_s`.
    pub following_error_rad: f32,
    /// How long the axis may be further from its reference than `following_error_rad`; a step takes that long.
    pub following_time_s: f32,
    /// Speed that trips the drive.
    pub over_speed_rad_s: f32,
    /// Difference of monitored and commanded field that trips the drive when it lasts.
    pub field_apart_kv_mm: f32,
    /// Dead time and lag of the field up to the monitor, together.
    pub field_lag_s: f32,
    /// Lowest reference once the axis is homed.
    pub position_min_rad: f32,
    /// Highest reference once the axis is homed.
    pub position_max_rad: f32,
    /// Highest speed at which a reference from the link moves.
    pub speed_limit_rad_s: f32,
    /// Highest acceleration of a reference from the link.
    pub acceleration_limit_rad_s2: f32,
    /// A disable brakes the axis to rest before everything goes off.
    pub stop_on_disable: bool,
    /// A lost link brakes the axis to rest before everything goes off, in place of everything off at once.
    pub stop_on_link_loss: bool,
    /// Torque of such a stop, held within plus and minus this.
    pub stop_torque_nm: f32,
    /// Longest time of such a stop.
    pub stop_time_s: f32,
}

impl Default for Config {
    /// The machine of the paper at L = 5 ms (control.md sections 1 to 4).
    fn default() -> Self {
        Self {
            period_s: IMAGE_PERIOD_S,
            kp_nm_rad: 240.0,
            kd_nm_s_rad: 6.96,
            torque_limit_nm: 30.0,
            er_enabled: true,
            er_a: 0.0704,
            er_b: 0.470,
            er_c_nm: 0.763,
            er_q0: EQUATION_5[0],
            er_q1_s_rad: EQUATION_5[1],
            er_q2_s2_rad2: EQUATION_5[2],
            field_limit_kv_mm: 3.5,
            brake_field_kv_mm: 3.0,
            near_rad: 0.02,
            brake_deadband_rad_s: 0.0257,
            hold: false,
            off_speed_rad_s: 1.5,
            speed_filter_s: 0.001,
            speed_from_converter: false,
            max_speed_rad_s: 45.0,
            max_acceleration_rad_s2: 6500.0,
            stale_torque_nm: 4.0,
            stale_time_s: 0.02,
            field_trip_kv_mm: 3.8,
            boot_time_s: 0.02,
            inertia_kg_m2: 0.075,
            motor_delay_s: 0.005,
            following_error_rad: 0.5,
            // A step of 1.57 rad at 400 rad/s2 takes 0.15 s, and as long again to settle.
            following_time_s: 0.5,
            // A step of 1.57 rad reaches 31 rad/s.
            over_speed_rad_s: 40.0,
            field_apart_kv_mm: 0.8,
            // The paper's best: 2 ms dead time and 3 ms lag.
            field_lag_s: 0.005,
            position_min_rad: -POSITION_RANGE_RAD,
            position_max_rad: POSITION_RANGE_RAD,
            // Half of what the motor can do.
            speed_limit_rad_s: 15.0,
            acceleration_limit_rad_s2: 200.0,
            stop_on_disable: true,
            // board.md: torque 0 and field 0 within one tick of the loss.
            stop_on_link_loss: false,
            stop_torque_nm: 10.0,
            stop_time_s: 0.5,
        }
    }
}
