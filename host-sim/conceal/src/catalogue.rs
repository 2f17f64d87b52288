//! What can be concealed: every effect of the vocabulary, and effects outside it, each with a size that is clear.

use std::f64::consts::{PI, TAU};

use rand::Rng;
use rand::rngs::StdRng;

use crate::physics::{FluidDelay, Physics, Pulse, Shaft, Wave};
use crate::seal::Concealed;

/// An effect that can be concealed.
#[derive(Debug)]
pub struct Entry {
    /// Identifier.
    pub id: &'static str,
    /// Whether the vocabulary of the diagnosis knows it.
    pub in_vocabulary: bool,
    /// Parameter identifiers.
    parameters: &'static [&'static str],
    /// Draws values at a fraction of the clear size.
    draw: fn(f64, &mut StdRng) -> Vec<f64>,
    put: fn(&mut Physics, &[f64]),
    leading: usize,
    /// Value of the leading parameter without the effect; none where the effect goes with one over it.
    origin: Option<f64>,
    /// Whether the fixed plan has it; what the vocabulary has learnt since would give its seeds other cases.
    pub(crate) in_fixed_plan: bool,
}

impl Entry {
    /// The parameter that says how strong the effect is, and its value without the effect; none where the effect grows
    /// as that parameter falls.
    pub fn leading(&self) -> (&'static str, Option<f64>) {
        (self.parameters[self.leading], self.origin)
    }

    const fn led_by(mut self, leading: usize) -> Self {
        self.leading = leading;
        self
    }

    const fn from(mut self, origin: f64) -> Self {
        self.origin = Some(origin);
        self
    }

    const fn learnt(mut self) -> Self {
        self.in_fixed_plan = false;
        self
    }

    const fn falling(mut self) -> Self {
        self.origin = None;
        self
    }

    /// Parameter identifiers on a rotary axis.
    pub(crate) fn parameters(&self) -> &'static [&'static str] {
        self.parameters
    }

    /// Puts the effect with these values, in the order of its parameters, into a machine.
    pub(crate) fn put(&self, physics: &mut Physics, values: &[f64]) {
        (self.put)(physics, values);
    }

    /// Puts the effect at `size` times its clear size into a machine.
    pub fn conceal(&self, size: f64, physics: &mut Physics, random: &mut StdRng) -> Concealed {
        let values = (self.draw)(size, random);
        (self.put)(physics, &values);
        let leading = values[self.leading];
        let strength = self.origin.map_or(1.0 / leading, |origin| (leading - origin).abs());
        let parameters = self.parameters.iter().map(|id| (*id).to_owned()).zip(values).collect();
        Concealed { id: self.id.to_owned(), in_vocabulary: self.in_vocabulary, size, strength, parameters }
    }
}

/// The entry called `id`.
pub fn find(id: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.id == id)
}

/// A change by `clear` times the size, a little more or less.
fn by(clear: f64, size: f64, random: &mut StdRng) -> f64 {
    clear * size * random.random_range(0.85..1.15)
}

/// As [`by`], either way.
fn either(clear: f64, size: f64, random: &mut StdRng) -> f64 {
    if random.random_bool(0.5) { by(clear, size, random) } else { -by(clear, size, random) }
}

fn angle(random: &mut StdRng) -> f64 {
    random.random_range(-PI..PI)
}

fn one_of(values: &[f64], random: &mut StdRng) -> f64 {
    values[random.random_range(0..values.len())]
}

fn wave(v: &[f64]) -> Wave {
    Wave { amplitude: v[0], order_per_rev: v[1], phase_rad: v[2] }
}

const fn inside(
    id: &'static str,
    parameters: &'static [&'static str],
    draw: fn(f64, &mut StdRng) -> Vec<f64>,
    put: fn(&mut Physics, &[f64]),
) -> Entry {
    Entry { id, in_vocabulary: true, parameters, draw, put, leading: 0, origin: Some(0.0), in_fixed_plan: true }
}

const fn outside(
    id: &'static str,
    parameters: &'static [&'static str],
    draw: fn(f64, &mut StdRng) -> Vec<f64>,
    put: fn(&mut Physics, &[f64]),
) -> Entry {
    Entry { id, in_vocabulary: false, parameters, draw, put, leading: 0, origin: Some(0.0), in_fixed_plan: true }
}

/// Every effect: those of the vocabulary in the order of its table, then those outside it.
pub static ENTRIES: &[Entry] = &[
    inside(
        "field_dead_time",
        &["dead_time_s"],
        |s, r| vec![0.002 + by(0.004, s, r)],
        |p, v| p.fluid.dead_time_s = v[0],
    )
    .from(0.002),
    inside(
        "field_lag",
        &["lag_s"],
        |s, r| vec![0.003 + by(0.006, s, r)],
        |p, v| {
            (p.fluid.rise_s, p.fluid.fall_s) = (v[0], v[0]);
        },
    )
    .from(0.003),
    inside(
        "field_lag_asymmetry",
        &["rise_s", "fall_s"],
        |s, r| vec![0.003, 0.003 + by(0.012, s, r)],
        |p, v| {
            (p.fluid.rise_s, p.fluid.fall_s) = (v[0], v[1]);
        },
    )
    .led_by(1)
    .from(0.003),
    inside(
        "field_slew_limit",
        &["slew_kv_mm_s"],
        |s, r| vec![150.0 / by(1.0, s, r)],
        |p, v| p.fluid.slew_kv_mm_s = Some(v[0]),
    )
    .falling(),
    inside("field_gain", &["gain"], |s, r| vec![1.0 + either(0.2, s, r)], |p, v| p.fluid.field_gain = v[0]).from(1.0),
    inside("er_strength", &["scale"], |s, r| vec![1.0 + either(0.25, s, r)], |p, v| p.fluid.scale = v[0]).from(1.0),
    inside("er_drift", &["rate_per_s"], |s, r| vec![either(0.04, s, r)], |p, v| p.fluid.drift_per_s = v[0]),
    inside(
        "er_preyield",
        &["stiffness_nm_rad"],
        |s, r| vec![250.0 / by(1.0, s, r)],
        |p, v| p.fluid.preyield_nm_rad = Some(v[0]),
    )
    .falling(),
    inside(
        "viscosity_dead_time",
        &["dead_time_s"],
        |s, r| vec![by(0.005, s, r)],
        |p, v| {
            p.fluid.delay = FluidDelay::ViscosityDeadTime(v[0]);
        },
    ),
    inside(
        "viscosity_lag",
        &["lag_s"],
        |s, r| vec![by(0.005, s, r)],
        |p, v| {
            p.fluid.delay = FluidDelay::ViscosityLag(v[0]);
        },
    ),
    inside(
        "coulomb_friction",
        &["coulomb_nm"],
        |s, r| vec![0.763 + either(0.3, s, r)],
        |p, v| p.friction.coulomb_nm = v[0],
    )
    .from(0.763),
    inside(
        "viscous_friction",
        &["viscous_nm_s_rad"],
        |s, r| vec![by(0.2, s, r)],
        |p, v| p.friction.viscous_nm_s_rad = v[0],
    ),
    inside(
        "stribeck_friction",
        &["excess_nm", "velocity_rad_s"],
        |s, r| vec![by(0.5, s, r), 0.1],
        |p, v| {
            p.friction.stribeck = Some((v[0], v[1]));
        },
    ),
    inside(
        "friction_asymmetry",
        &["difference_nm", "viscous_difference_nm_s_rad"],
        |s, r| vec![either(0.4, s, r), 0.0],
        |p, v| (p.friction.difference_nm, p.friction.viscous_difference_nm_s_rad) = (v[0], v[1]),
    ),
    inside(
        "presliding",
        &["stiffness_nm_rad"],
        |s, r| vec![200.0 / by(1.0, s, r)],
        |p, v| p.friction.presliding_nm_rad = Some(v[0]),
    )
    .falling(),
    inside("torque_gain", &["gain"], |s, r| vec![1.0 + either(0.1, s, r)], |p, v| p.drive.gain = v[0]).from(1.0),
    inside("torque_offset", &["offset_nm"], |s, r| vec![either(0.3, s, r)], |p, v| p.drive.offset_nm = v[0]),
    inside("torque_saturation", &["limit_nm"], |s, r| vec![30.0 - by(18.0, s, r)], |p, v| p.drive.limit_nm = v[0])
        .from(30.0),
    inside("torque_deadband", &["deadband_nm"], |s, r| vec![by(0.4, s, r)], |p, v| p.drive.deadband_nm = v[0]),
    inside("torque_delay", &["delay_s"], |s, r| vec![0.005 + by(0.0015, s, r)], |p, v| p.drive.delay_s = v[0])
        .from(0.005),
    inside("torque_lag", &["lag_s"], |s, r| vec![by(0.0015, s, r)], |p, v| p.drive.lag_s = v[0]),
    inside(
        "cogging",
        &["amplitude_nm", "order_per_rev", "phase_rad"],
        |s, r| vec![by(0.3, s, r), one_of(&[6.0, 12.0, 14.0, 24.0, 36.0], r), angle(r)],
        |p, v| p.cogging.push(wave(v)),
    ),
    inside(
        "inertia",
        &["inertia_kg_m2"],
        |s, r| vec![0.075 * (1.0 + either(0.12, s, r))],
        |p, v| p.inertia_kg_m2 = v[0],
    )
    .from(0.075),
    inside(
        "gravity_load",
        &["amplitude_nm", "phase_rad"],
        |s, r| vec![by(0.6, s, r), angle(r)],
        |p, v| {
            p.gravity = Some((v[0], v[1]));
        },
    ),
    inside("spring_load", &["stiffness_nm_rad"], |s, r| vec![by(0.7, s, r)], |p, v| p.spring_nm_rad = v[0]),
    inside(
        "compliance",
        &["resonance_hz", "damping_ratio", "inertia_ratio"],
        |s, r| vec![40.0 / s.sqrt() * r.random_range(0.9..1.1), 0.04, 0.4],
        |p, v| {
            p.shaft = Some(Shaft { resonance_hz: v[0], damping_ratio: v[1], inertia_ratio: v[2], gap_rad: 0.0 });
        },
    )
    .falling(),
    inside(
        "backlash",
        &["gap_rad", "resonance_hz", "damping_ratio", "inertia_ratio"],
        |s, r| vec![by(0.006, s, r), 60.0, 0.05, 0.4],
        |p, v| {
            p.shaft = Some(Shaft { gap_rad: v[0], resonance_hz: v[1], damping_ratio: v[2], inertia_ratio: v[3] });
        },
    ),
    inside(
        "disturbance_pulse",
        &["start_s", "duration_s", "amplitude_nm"],
        |s, r| vec![r.random_range(1.0..7.0), r.random_range(0.05..0.2), either(2.0, s, r)],
        |p, v| p.pulse = Some(Pulse { start_s: v[0], duration_s: v[1], amplitude_nm: v[2] }),
    )
    .led_by(2),
    inside(
        "vibration",
        &["frequency_hz", "amplitude_nm"],
        |s, r| vec![r.random_range(8.0..40.0), by(0.3, s, r)],
        |p, v| p.vibration = Some((v[0], v[1], 0.0)),
    )
    .led_by(1),
    inside(
        "quadratic_drag",
        &["coefficient_nm_s2_rad2"],
        |s, r| vec![by(0.12, s, r)],
        |p, v| {
            p.friction.quadratic_nm_s2_rad2 = v[0];
        },
    ),
    inside(
        "resolver_eccentricity",
        &["amplitude_rad", "order_per_rev", "phase_rad"],
        |s, r| vec![by(0.002, s, r), one_of(&[1.0, 2.0, 4.0, 8.0], r), angle(r)],
        |p, v| p.sensor.eccentricity = Some(wave(v)),
    ),
    inside("sensor_latency", &["delay_s"], |s, r| vec![by(0.001, s, r)], |p, v| p.sensor.latency_s = v[0]),
    inside(
        "sensor_glitch",
        &["fraction", "size_rad"],
        |s, r| vec![0.003, by(0.0006, s, r)],
        |p, v| {
            p.sensor.glitch = Some((v[0], v[1]));
        },
    )
    .led_by(1),
    inside("load_dependent_friction", &["coefficient"], |s, r| vec![by(0.08, s, r)], |p, v| p.friction.per_load = v[0])
        .learnt(),
    // Only where there is a viscous friction to be warmed.
    inside(
        "temperature_viscosity",
        &["viscosity_per_j", "cooling_per_s"],
        |s, r| vec![by(1.0, s, r), 0.5],
        |p, v| p.friction.warming = Some((v[0], v[1])),
    )
    .learnt(),
    inside(
        "torque_ripple",
        &["gain_amplitude", "order_per_rev", "phase_rad"],
        |s, r| vec![by(0.3, s, r), one_of(&[6.0, 12.0, 14.0, 24.0, 36.0], r), angle(r)],
        |p, v| p.drive.ripple.push(wave(v)),
    )
    .learnt(),
    outside(
        "friction_over_position",
        &["share", "order_per_rev", "phase_rad"],
        |s, r| vec![by(0.4, s, r), one_of(&[3.0, 5.0, 7.0], r), angle(r)],
        |p, v| p.friction.over_position = Some(wave(v)),
    ),
    outside(
        "stiction_by_rest",
        &["excess_nm", "time_s"],
        |s, r| vec![by(1.0, s, r), 0.05],
        |p, v| {
            p.friction.ageing = Some((v[0], v[1]));
        },
    ),
    outside(
        "torque_memory",
        &["share", "half_width_nm"],
        |s, r| vec![by(0.5, s, r), 1.0],
        |p, v| {
            p.drive.memory = Some((v[0], v[1]));
        },
    ),
    outside(
        "warmth_with_hysteresis",
        &["share", "energy_j", "cooling_s", "half_width"],
        |s, r| vec![by(0.6, s, r), 0.1, 2.0, 0.1],
        |p, v| p.fluid.warmth = Some([v[0], v[1], v[2], v[3]]),
    ),
    outside(
        "nonlinear_spring",
        &["stiffness_nm_rad3"],
        |s, r| vec![by(4.0, s, r)],
        |p, v| {
            p.cubic_spring_nm_rad3 = v[0];
        },
    ),
    outside(
        "load_change",
        &["from_s", "inertia_kg_m2"],
        |s, r| vec![r.random_range(2.5..5.5), 0.075 * (1.0 + by(0.4, s, r))],
        |p, v| p.load_change = Some((v[0], v[1])),
    )
    .led_by(1)
    .from(0.075),
    outside(
        "magnetic_saturation",
        &["level_nm"],
        |s, r| vec![15.0 / by(1.0, s, r)],
        |p, v| {
            p.drive.saturation_nm = Some(v[0]);
        },
    )
    .falling(),
    outside(
        "field_leakage",
        &["share", "time_s"],
        |s, r| vec![by(0.5, s, r), 0.1],
        |p, v| {
            p.fluid.leakage = Some((v[0], v[1]));
        },
    ),
    outside("friction_by_load", &["share"], |s, r| vec![by(0.08, s, r)], |p, v| p.friction.per_load = v[0]),
];

/// What differs from one recording of a machine to the next: the phase of what keeps a time of its own; a push is in the first only.
pub fn for_recording(physics: &Physics, index: usize, random: &mut StdRng) -> Physics {
    let mut physics = physics.clone();
    if let Some((_, _, phase)) = &mut physics.vibration {
        *phase = random.random_range(0.0..TAU);
    }
    if let Some(hiding) = &mut physics.hidden {
        hiding.for_recording(random);
    }
    if index > 0 {
        physics.pulse = None;
    }
    physics
}
