//! Every number of the machine that an effect can change, nominal or added.

use crate::read::Machine;

/// The damper's fluid when the delay acts on the coefficient of viscosity and not on the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viscosity {
    /// Dead time of Q, s.
    DeadTime(f64),
    /// First-order lag of Q, s.
    Lag(f64),
}

/// A sine over position: `sine` sin(order x) + `cosine` cos(order x); linear in both, unlike amplitude and phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Periods per revolution (rad per m of travel on a linear axis).
    pub order: f64,
    /// Amplitude of the sine, in the unit of what it adds to.
    pub sine: f64,
    /// Amplitude of the cosine.
    pub cosine: f64,
}

impl Harmonic {
    /// Value at a position, rad (m).
    pub fn at(&self, position: f64) -> f64 {
        let (sine, cosine) = (self.order * position).sin_cos();
        self.sine * sine + self.cosine * cosine
    }
}

/// A load on a flexible shaft, behind a gap where one is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Resonance of motor against load, Hz.
    pub resonance_hz: f64,
    /// Damping ratio of that resonance, 1.
    pub damping_ratio: f64,
    /// Inertia of the load over the motor's, 1; their sum is the inertia of the machine.
    pub inertia_ratio: f64,
    /// Total play between motor and load, rad (m); 0 for none.
    pub gap: f64,
}

/// One external push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulse {
    /// Index of the recording it happens in.
    pub recording: usize,
    /// s.
    pub start_s: f64,
    /// s.
    pub duration_s: f64,
    /// N m (N).
    pub amplitude: f64,
}

/// A steady external sine; phase free in each recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Vibration {
    /// Hz.
    pub frequency_hz: f64,
    /// Amplitudes of sine and cosine in each recording, N m (N).
    pub phasors: Vec<(f64, f64)>,
}

/// The damper.
#[derive(Debug, Clone, PartialEq)]
pub struct Damper {
    /// N m per (kV/mm)^2.
    pub a: f64,
    /// N m per kV/mm.
    pub b: f64,
    /// Acting over commanded field, 1.
    pub gain: f64,
    /// Scale of the ER torque, 1.
    pub scale: f64,
    /// Relative change of the ER torque per second, 1/s.
    pub drift_per_s: f64,
    /// Dead time of the field, s.
    pub dead_time_s: f64,
    /// Largest rate of change of the field, kV/mm/s; infinite for no limit.
    pub slew_kv_mm_s: f64,
    /// Lag while the field rises, s.
    pub rise_s: f64,
    /// Lag while the field falls, s.
    pub fall_s: f64,
    /// Bristle stiffness below yield, N m/rad; infinite for none.
    pub preyield: f64,
    /// Delay of the viscosity in place of the field's.
    pub viscosity: Option<Viscosity>,
}

/// The machine in numbers. SI units of the axis: N m, rad, kg m2 or N, m, kg.
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    /// kg m2 (kg).
    pub inertia: f64,
    /// Dry friction, N m (N).
    pub coulomb: f64,
    /// N m s/rad.
    pub viscous: f64,
    /// N m s2/rad2.
    pub quadratic: f64,
    /// Excess over Coulomb at standstill, N m.
    pub stribeck_excess: f64,
    /// Speed at which the excess has fallen to 1/e, rad/s.
    pub stribeck_velocity: f64,
    /// Coulomb level in plus minus in minus direction, N m.
    pub asymmetry: f64,
    /// Viscous slope in plus minus in minus direction, N m s/rad.
    pub asymmetry_viscous: f64,
    /// Stiffness of dry friction before it slides, N m/rad; infinite for none.
    pub presliding: f64,
    /// Acting over commanded torque, 1.
    pub torque_gain: f64,
    /// N m.
    pub torque_offset: f64,
    /// N m; infinite for no limit.
    pub torque_limit: f64,
    /// Commands smaller than this do nothing, larger ones lose it, N m.
    pub torque_deadband: f64,
    /// s.
    pub torque_delay_s: f64,
    /// s.
    pub torque_lag_s: f64,
    /// The damper; none for a machine without one.
    pub damper: Option<Damper>,
    /// Torque over position, N m.
    pub cogging: Vec<Harmonic>,
    /// Order 1: a weight on an arm, N m.
    pub gravity: Option<Harmonic>,
    /// N m/rad.
    pub spring: f64,
    /// Load behind a shaft or a gap.
    pub load: Option<Load>,
    /// External pushes.
    pub pulses: Vec<Pulse>,
    /// External sine.
    pub vibration: Option<Vibration>,
    /// Error of the position sensor over position, rad.
    pub eccentricity: Option<Harmonic>,
    /// The position is reported this late, s; negative where commands are stamped late.
    pub latency_s: f64,
}

impl Physics {
    /// Whether it has states other than position and speed: bristles, the fluid's spring, a load behind a shaft.
    pub fn remembers(&self) -> bool {
        self.presliding.is_finite()
            || self.load.is_some_and(|load| load.inertia_ratio > 0.0)
            || self.damper.as_ref().is_some_and(|damper| damper.preyield.is_finite())
    }

    /// The nominal machine of `[plant]`, without its `[[effects]]`.
    // Over 40 lines: one line for each field.
    pub fn nominal(machine: &Machine) -> Self {
        let plant = &machine.plant;
        Self {
            inertia: plant.inertia,
            coulomb: plant.coulomb,
            viscous: plant.viscous,
            quadratic: 0.0,
            stribeck_excess: 0.0,
            stribeck_velocity: 1.0,
            asymmetry: 0.0,
            asymmetry_viscous: 0.0,
            presliding: f64::INFINITY,
            torque_gain: plant.torque_gain,
            torque_offset: plant.torque_offset,
            torque_limit: plant.torque_limit.unwrap_or(f64::INFINITY),
            torque_deadband: 0.0,
            torque_delay_s: plant.torque_delay_s,
            torque_lag_s: 0.0,
            damper: plant.er.as_ref().map(|er| Damper {
                a: er.a,
                b: er.b,
                gain: 1.0,
                scale: 1.0,
                drift_per_s: 0.0,
                dead_time_s: er.dead_time_s,
                slew_kv_mm_s: f64::INFINITY,
                rise_s: er.lag_s,
                fall_s: er.lag_s,
                preyield: f64::INFINITY,
                viscosity: None,
            }),
            cogging: Vec::new(),
            gravity: None,
            spring: 0.0,
            load: None,
            pulses: Vec::new(),
            vibration: None,
            eccentricity: None,
            latency_s: 0.0,
        }
    }
}
