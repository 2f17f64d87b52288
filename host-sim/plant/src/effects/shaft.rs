//! A load on a flexible shaft (`compliance`), or behind a gap as well (`backlash`).
//!
//! The nominal inertia J is shared: motor J / (1 + r), load J r / (1 + r), so that slow motion feels J whatever the
//! ratio r. The resonance is that of the free motor and load against each other, sqrt(k (1/Jm + 1/Jl)) / 2 pi, the peak
//! of the response of motor speed to torque; the antiresonance (motor locked) lies a factor sqrt(1 + r) below. The damping
//! ratio is that of the same mode. Drag, drive and sensor sit on the motor.

use std::f64::consts::TAU;

use super::friction::FASTEST_S;
use crate::Error;
use crate::model::{not_negative, positive};

/// Parameters of the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaft {
    /// Free-free resonance with the gap closed, Hz, above 0.
    pub resonance_hz: f64,
    /// Damping of that mode over critical, 1, not negative. Across the gap there is none.
    pub damping_ratio: f64,
    /// Load over motor inertia, 1, not negative; 0 is the rigid machine.
    pub inertia_ratio: f64,
    /// Free play from contact to contact, rad (m), not negative; 0 for a compliance without backlash.
    pub gap: f64,
}

impl Shaft {
    pub(crate) fn validate(&self) -> Result<(), Error> {
        positive("compliance.resonance_hz", self.resonance_hz)?;
        not_negative("compliance.damping_ratio", self.damping_ratio)?;
        not_negative("compliance.inertia_ratio", self.inertia_ratio)?;
        not_negative("backlash.gap", self.gap)
    }
}

/// Where the load is in its gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Contact {
    /// Coupled at zero play.
    Always,
    /// Load ahead of the motor, pulling it along.
    Ahead,
    /// In the gap.
    Free,
    /// Load behind the motor.
    Behind,
}

/// The shaft as a spring and a damper, SI. Behind a gap, teeth push and do not pull: a contact ends where its damper has taken all of the
/// spring's push, before the spring is straight (Nordin, Galic and Gutman, Int. J. Adapt. Control Signal Process. 11 (1997) 49).
#[derive(Debug, Clone, Copy)]
pub struct ShaftLaw {
    /// Inertia on the side of the motor, kg m2 (kg).
    pub motor_inertia: f64,
    /// One over the inertia of the load, 1/(kg m2).
    pub per_load_inertia: f64,
    /// Of the shaft, N m/rad (N/m).
    pub stiffness: f64,
    /// Of the shaft, N m s/rad (N s/m).
    pub damping: f64,
    /// Free play to either side, rad (m).
    pub half_gap: f64,
    resonance_rad_s: f64,
    /// At which the damper alone would stop the twist, 1/s.
    damping_rate: f64,
}

impl ShaftLaw {
    /// From validated parameters and the total inertia; none for a load without inertia.
    pub fn new(shaft: &Shaft, inertia: f64) -> Option<Self> {
        let ratio = shaft.inertia_ratio;
        if ratio == 0.0 {
            return None;
        }
        let (motor_inertia, load_inertia) = (inertia / (1.0 + ratio), inertia * ratio / (1.0 + ratio));
        let reduced = motor_inertia * load_inertia / inertia;
        // A faster shaft is as good as a rigid one, and one more damped creeps as slowly.
        let resonance_rad_s = (TAU * shaft.resonance_hz).min(FASTEST_S.recip());
        let damping_rate = (2.0 * shaft.damping_ratio * resonance_rad_s).min(FASTEST_S.recip());
        Some(Self {
            motor_inertia,
            per_load_inertia: load_inertia.recip(),
            stiffness: reduced * resonance_rad_s * resonance_rad_s,
            damping: reduced * damping_rate,
            half_gap: 0.5 * shaft.gap,
            resonance_rad_s,
            damping_rate,
        })
    }

    /// Torque of the shaft on the motor, N m, for the twist load minus motor, rad (m), and its rate, wherever the load is in its gap.
    #[inline]
    pub fn torque_at(&self, twist: f64, twist_rate: f64) -> f64 {
        self.torque(self.contact(twist, twist_rate), twist, twist_rate)
    }

    /// The same in a contact.
    #[inline]
    pub(crate) fn torque(&self, contact: Contact, twist: f64, twist_rate: f64) -> f64 {
        let bent = match contact {
            Contact::Free => return 0.0,
            Contact::Always => twist,
            Contact::Ahead => twist - self.half_gap,
            Contact::Behind => twist + self.half_gap,
        };
        self.stiffness * bent + self.damping * twist_rate
    }

    /// Rate of that torque, N m/s, for the first and the second rate of the twist.
    #[inline]
    pub(crate) fn torque_rate(&self, contact: Contact, twist_rate: f64, twist_acceleration: f64) -> f64 {
        if contact == Contact::Free { 0.0 } else { self.stiffness * twist_rate + self.damping * twist_acceleration }
    }

    /// The contact a twist and its rate lead to; on the edge of the gap the rate decides.
    pub(crate) fn contact(&self, twist: f64, twist_rate: f64) -> Contact {
        let edge = self.half_gap * 1e-12;
        let meets = |side: f64| {
            let beyond = side * twist - self.half_gap;
            if beyond > edge {
                self.push(side, twist, twist_rate) > 0.0
            } else {
                beyond >= -edge && side * twist_rate > 0.0
            }
        };
        if self.half_gap == 0.0 {
            Contact::Always
        } else if meets(1.0) {
            Contact::Ahead
        } else if meets(-1.0) {
            Contact::Behind
        } else {
            Contact::Free
        }
    }

    /// Positive while the contact holds.
    #[inline]
    pub(crate) fn guard(&self, contact: Contact, twist: f64, twist_rate: f64) -> f64 {
        let push = |side: f64| self.push(side, twist, twist_rate);
        match contact {
            Contact::Always => f64::INFINITY,
            Contact::Ahead => push(1.0),
            Contact::Behind => push(-1.0),
            Contact::Free => -push(1.0).max(push(-1.0)),
        }
    }

    /// How far the teeth on a side push, as a bend of the spring, rad (m): positive where they touch and spring and damper together
    /// push.
    #[inline]
    fn push(&self, side: f64, twist: f64, twist_rate: f64) -> f64 {
        let bent = side * twist - self.half_gap;
        bent.min(bent + side * twist_rate * self.damping / self.stiffness)
    }

    /// Longest step over which the law is smooth and its damping still lets the iteration converge fast, s.
    pub(crate) fn longest_step(&self) -> f64 {
        (0.5 / self.resonance_rad_s).min(1.0 / self.damping_rate)
    }
}
