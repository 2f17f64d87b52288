//! The machine as numbers, with everything that may be concealed in it. SI units, kV/mm for the field; on a linear axis the
//! same numbers are m, N and kg.

use crate::outside::Hiding;

/// amplitude sin(order position + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// N m, rad or a share, by use.
    pub amplitude: f64,
    /// Periods in one revolution.
    pub order_per_rev: f64,
    /// At position zero, rad.
    pub phase_rad: f64,
}

impl Wave {
    /// Value at an angle, rad.
    pub fn at(&self, position_rad: f64) -> f64 {
        self.amplitude * (self.order_per_rev * position_rad + self.phase_rad).sin()
    }
}

/// Drive: deadband, gain, bias, memory, soft and hard limit, dead time, lag, in this order.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// 1.
    pub gain: f64,
    /// N m.
    pub offset_nm: f64,
    /// Either way, N m.
    pub limit_nm: f64,
    /// Taken off every command, N m.
    pub deadband_nm: f64,
    /// s.
    pub delay_s: f64,
    /// s.
    pub lag_s: f64,
    /// Share of the torque that passes through a play, and its half-width, N m.
    pub memory: Option<(f64, f64)>,
    /// Torque t becomes s tanh(t/s) with this s, N m.
    pub saturation_nm: Option<f64>,
    /// Over the angle, as shares of the torque: it acts times 1 + these.
    pub ripple: Vec<Wave>,
}

/// What of the fluid is delayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FluidDelay {
    /// The field.
    Field,
    /// The coefficient of viscosity, by a dead time, s.
    ViscosityDeadTime(f64),
    /// The coefficient of viscosity, by a lag, s.
    ViscosityLag(f64),
}

/// The electrorheological damper.
#[derive(Debug, Clone, PartialEq)]
pub struct Fluid {
    /// N m per (kV/mm)^2.
    pub a: f64,
    /// N m per kV/mm.
    pub b: f64,
    /// s.
    pub dead_time_s: f64,
    /// Lag of a rising field, s.
    pub rise_s: f64,
    /// Lag of a falling field, s.
    pub fall_s: f64,
    /// kV/mm per s.
    pub slew_kv_mm_s: Option<f64>,
    /// Acting over commanded field, 1.
    pub field_gain: f64,
    /// Torque over the law, 1.
    pub scale: f64,
    /// 1/s.
    pub drift_per_s: f64,
    /// Stiffness below yield, N m/rad.
    pub preyield_nm_rad: Option<f64>,
    /// Which signal the delay acts on.
    pub delay: FluidDelay,
    /// Field whose torque a delayed viscosity does not exceed, kV/mm.
    pub viscous_limit_kv_mm: f64,
    /// Field that leaks away under load: share lost in the long run, and time constant, s.
    pub leakage: Option<(f64, f64)>,
    /// Torque lost with warmth: share lost when hot, energy that heats by one unit, J, cooling time, s, half-width of the
    /// hysteresis in the same unit.
    pub warmth: Option<[f64; 4]>,
}

/// Dry and viscous friction.
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// N m.
    pub coulomb_nm: f64,
    /// N m s/rad.
    pub viscous_nm_s_rad: f64,
    /// N m s2/rad2.
    pub quadratic_nm_s2_rad2: f64,
    /// Excess near rest, N m, and the speed it decays over, rad/s.
    pub stribeck: Option<(f64, f64)>,
    /// Coulomb level forward minus backward, N m.
    pub difference_nm: f64,
    /// Viscous coefficient forward minus backward, N m s/rad.
    pub viscous_difference_nm_s_rad: f64,
    /// Bristle stiffness, N m/rad; none for true stiction.
    pub presliding_nm_rad: Option<f64>,
    /// Share of the Coulomb level that varies with the angle.
    pub over_position: Option<Wave>,
    /// Excess that rest builds up, N m, and its time constant, s.
    pub ageing: Option<(f64, f64)>,
    /// Coulomb friction that grows with the magnitude of the drive's torque, 1.
    pub per_load: f64,
    /// Viscous friction that falls with the heat of all drag as exp(-k H): k, 1/J, and the share of the heat that goes each second, 1/s.
    pub warming: Option<(f64, f64)>,
}

/// Load on a flexible shaft; motor J/(1 + r), load J r/(1 + r).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// Of motor and load against each other, Hz.
    pub resonance_hz: f64,
    /// Of that mode, 1.
    pub damping_ratio: f64,
    /// Load over motor, 1.
    pub inertia_ratio: f64,
    /// From contact to contact, rad.
    pub gap_rad: f64,
}

/// A push from outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// s.
    pub start_s: f64,
    /// s.
    pub duration_s: f64,
    /// N m.
    pub amplitude_nm: f64,
}

/// The position sensor, before its counts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sensor {
    /// rad.
    pub eccentricity: Option<Wave>,
    /// s, not negative.
    pub latency_s: f64,
    /// Share of samples that are wrong, and by how much, rad.
    pub glitch: Option<(f64, f64)>,
    /// Standard deviation, rad.
    pub noise_rad: f64,
}

/// Everything about the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    /// Motor and load together, kg m2.
    pub inertia_kg_m2: f64,
    /// Drive.
    pub drive: Drive,
    /// Damper.
    pub fluid: Fluid,
    /// Bearings.
    pub friction: Friction,
    /// Torques over the angle, N m.
    pub cogging: Vec<Wave>,
    /// -amplitude sin(position + phase), N m and rad.
    pub gravity: Option<(f64, f64)>,
    /// -k position, N m/rad.
    pub spring_nm_rad: f64,
    /// -k position^3, N m/rad3.
    pub cubic_spring_nm_rad3: f64,
    /// Flexible shaft.
    pub shaft: Option<Shaft>,
    /// Push in this recording.
    pub pulse: Option<Pulse>,
    /// Hz, N m, and phase, rad, in this recording.
    pub vibration: Option<(f64, f64, f64)>,
    /// When the load changes, s, and the inertia from then on, kg m2.
    pub load_change: Option<(f64, f64)>,
    /// Sensor.
    pub sensor: Sensor,
    /// Standard deviation of a torque drawn anew each tick, N m.
    pub torque_noise_nm: f64,
    /// Torque over the angle that belongs to the noise, N m.
    pub ripple: Option<Wave>,
    /// An effect outside the vocabulary that is no number of the machine.
    pub hidden: Option<Hiding>,
}

impl Physics {
    /// The default machine of the recording format: nothing concealed, no noise.
    // Over 40 lines: one line for each field.
    pub fn nominal() -> Self {
        let drive = Drive {
            gain: 1.0,
            offset_nm: 0.0,
            limit_nm: 30.0,
            deadband_nm: 0.0,
            delay_s: 0.005,
            lag_s: 0.0,
            memory: None,
            saturation_nm: None,
            ripple: Vec::new(),
        };
        let fluid = Fluid {
            a: 0.0704,
            b: 0.470,
            dead_time_s: 0.002,
            rise_s: 0.003,
            fall_s: 0.003,
            slew_kv_mm_s: None,
            field_gain: 1.0,
            scale: 1.0,
            drift_per_s: 0.0,
            preyield_nm_rad: None,
            delay: FluidDelay::Field,
            viscous_limit_kv_mm: 3.5,
            leakage: None,
            warmth: None,
        };
        let friction = Friction {
            coulomb_nm: 0.763,
            viscous_nm_s_rad: 0.0,
            quadratic_nm_s2_rad2: 0.0,
            stribeck: None,
            difference_nm: 0.0,
            viscous_difference_nm_s_rad: 0.0,
            presliding_nm_rad: None,
            over_position: None,
            ageing: None,
            per_load: 0.0,
            warming: None,
        };
        Self {
            inertia_kg_m2: 0.075,
            drive,
            fluid,
            friction,
            cogging: Vec::new(),
            gravity: None,
            spring_nm_rad: 0.0,
            cubic_spring_nm_rad3: 0.0,
            shaft: None,
            pulse: None,
            vibration: None,
            load_change: None,
            sensor: Sensor::default(),
            torque_noise_nm: 0.0,
            ripple: None,
            hidden: None,
        }
    }
}
