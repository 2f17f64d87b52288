//! Limit cycles of the nonlinear loop by harmonic balance.
//!
//! The loop at rest at the reference is taken to swing as A sin(wt). Each nonlinear torque is replaced by its first
//! harmonic over that swing: dry friction, the limit of the control torque, and the damper under its law and delay
//! ([`Damper`]). A limit cycle is an (A, w) at which what is left,
//!
//! (-J w^2 + N_u(A, w) (K_P + jw K_D) e^(-jwL)) A + j 4 c / pi + (b + j a) = 0,
//!
//! balances; a and b are the damper's torque in phase with speed and angle. It is one that lasts if a larger swing
//! decays (Loeb's criterion). The method is good where the rotor filters harmonics well, as 1/(J s^2) does, and says
//! nothing of friction holding the rotor still, which ends any swing whose torque stays under the drag.
//!
//! The damper opposes the motion whatever its delay, so a is never negative: only the control torque, late by L, can
//! feed a swing. That is where this loop differs from the linear one of section V, whose Q1 e^(-L_Q s) s delays the
//! product and can push. What a late field can do is act with the wrong part of the swing and leave less damping.

mod damper;
mod models;
mod simulated;

use nalgebra::Complex;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

pub use damper::{Damper, DamperDelay, Swing, TorqueHarmonic};
pub use models::{MODELS, ModelCycles, cycles_by_model};
pub use simulated::remaining_amplitude_rad;

use super::case::Gains;

/// The loop with its nonlinear torques.
#[derive(Debug, Clone, Copy)]
pub struct NonlinearLoop<'a> {
    /// J, kg m2.
    pub inertia_kg_m2: f64,
    /// L, s.
    pub torque_delay_s: f64,
    /// Dry friction, N m.
    pub coulomb_nm: f64,
    /// Gains of the PD law.
    pub gains: Gains,
    /// Largest control torque either way, N m.
    pub torque_limit_nm: f64,
    /// The damper; none for a loop with the field off.
    pub damper: Option<&'a Damper>,
}

/// Amplitudes and frequencies searched.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Search {
    /// Smallest and largest amplitude, rad.
    pub amplitude_rad: [f64; 2],
    /// Lowest and highest frequency, rad/s.
    pub frequency_rad_s: [f64; 2],
}

impl Search {
    /// From a hundredth of the error dry friction holds to a third of a turn, up to a third of the sampling frequency.
    pub const SERVO: Self = Self { amplitude_rad: [3e-5, 2.0], frequency_rad_s: [3.0, 4000.0] };
}

/// A solution of the harmonic balance.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct LimitCycle {
    /// A, rad.
    pub amplitude_rad: f64,
    /// w, rad/s.
    pub frequency_rad_s: f64,
    /// True: swings near it approach it. False: it parts the swings that decay from those that grow.
    pub stable: bool,
}

/// Share of the velocity amplitude's direction that dry friction takes: the first harmonic of a square wave.
///
/// Returns N m s/rad: 4 c / (pi A w), the describing function of a relay on the speed.
#[must_use]
pub fn coulomb_nm_s_rad(coulomb_nm: f64, swing: Swing) -> f64 {
    4.0 * coulomb_nm / (PI * swing.speed_rad_s())
}

/// Describing function of a limit: the output's first harmonic over an input of this amplitude, 0 to 1.
#[must_use]
pub fn saturation(amplitude: f64, limit: f64) -> f64 {
    let ratio = limit / amplitude;
    if ratio >= 1.0 { 1.0 } else { (ratio.asin() + ratio * (1.0 - ratio * ratio).sqrt()) / FRAC_PI_2 }
}

impl NonlinearLoop<'_> {
    /// What the harmonic balance leaves at a swing, over its amplitude, N m/rad; zero on a limit cycle.
    #[must_use]
    pub fn imbalance(&self, swing: Swing) -> Complex<f64> {
        let TorqueHarmonic { with_speed_nm, with_angle_nm } =
            self.damper.map_or(TorqueHarmonic::default(), |damper| damper.first_harmonic(swing));
        self.without_damper(swing) + Complex::new(with_angle_nm, with_speed_nm) / swing.amplitude_rad
    }

    /// [`Self::imbalance`] less the damper. Its imaginary part is a lower bound of the whole one's.
    fn without_damper(&self, swing: Swing) -> Complex<f64> {
        let w = swing.frequency_rad_s;
        let control = Complex::new(self.gains.k_p_nm_rad, w * self.gains.k_d_nm_s_rad)
            * Complex::new(0.0, -w * self.torque_delay_s).exp();
        let limited = saturation(swing.amplitude_rad * control.norm(), self.torque_limit_nm);
        let friction = w * coulomb_nm_s_rad(self.coulomb_nm, swing);
        control * limited + Complex::new(-self.inertia_kg_m2 * w * w, friction)
    }

    /// Limit cycles within `search`, by amplitude.
    ///
    /// A grid finds the cells around whose corners the imbalance turns once; those are halved until they are a point.
    #[must_use]
    pub fn limit_cycles(&self, search: Search) -> Vec<LimitCycle> {
        let amplitudes = geometric(search.amplitude_rad, AMPLITUDES);
        let frequencies = geometric(search.frequency_rad_s, FREQUENCIES);
        let at = |i: usize, k: usize| Swing { amplitude_rad: amplitudes[i], frequency_rad_s: frequencies[k] };
        // Where friction alone takes more than the control feeds, nothing balances, and the damper need not be asked.
        let feeds = |i: usize, k: usize| self.without_damper(at(i, k)).im <= 0.0;
        let mut known = vec![None; AMPLITUDES * FREQUENCIES];
        let mut imbalance =
            |i: usize, k: usize| *known[i * FREQUENCIES + k].get_or_insert_with(|| self.imbalance(at(i, k)));
        let mut cycles: Vec<LimitCycle> = Vec::new();
        for (i, k) in (1..AMPLITUDES).flat_map(|i| (1..FREQUENCIES).map(move |k| (i, k))) {
            let corners = [(i - 1, k - 1), (i, k - 1), (i, k), (i - 1, k)];
            if corners.iter().any(|&(i, k)| feeds(i, k)) && turns(corners.map(|(i, k)| imbalance(i, k))) != 0 {
                cycles.extend(self.refine(at(i - 1, k - 1), at(i, k)).map(|swing| self.judge(swing)));
            }
        }
        cycles.sort_by(|a, b| a.amplitude_rad.total_cmp(&b.amplitude_rad));
        cycles
    }

    /// The point within a cell at which the imbalance is zero; none if it only jumps there.
    fn refine(&self, mut low: Swing, mut high: Swing) -> Option<Swing> {
        for _ in 0..HALVINGS {
            let middle = between(low, high);
            let halves = |low: f64, middle: f64, high: f64| [(low, middle), (middle, high)];
            let quarters =
                halves(low.amplitude_rad, middle.amplitude_rad, high.amplitude_rad).into_iter().flat_map(|a| {
                    halves(low.frequency_rad_s, middle.frequency_rad_s, high.frequency_rad_s).map(|w| (a, w))
                });
            let swing = |amplitude_rad, frequency_rad_s| Swing { amplitude_rad, frequency_rad_s };
            let around = |(a, w): &((f64, f64), (f64, f64))| {
                let corners = [swing(a.0, w.0), swing(a.1, w.0), swing(a.1, w.1), swing(a.0, w.1)];
                turns(corners.map(|corner| self.imbalance(corner))) != 0
            };
            let Some((a, w)) = quarters.into_iter().find(around) else { break };
            (low, high) = (swing(a.0, w.0), swing(a.1, w.1));
        }
        let swing = between(low, high);
        let inertial = self.inertia_kg_m2 * swing.frequency_rad_s.powi(2);
        (self.imbalance(swing).norm() < 0.02 * inertial).then_some(swing)
    }

    /// Loeb's criterion: with F(A, w) = 0 a slightly larger swing decays at the rate Re(F_A / (j F_w)), if negative.
    fn judge(&self, swing: Swing) -> LimitCycle {
        const PART: f64 = 5e-3;
        let Swing { amplitude_rad, frequency_rad_s } = swing;
        let at = |a: f64, w: f64| {
            let swing = Swing { amplitude_rad: amplitude_rad * a, frequency_rad_s: frequency_rad_s * w };
            self.imbalance(swing)
        };
        let by_amplitude = at(1.0 + PART, 1.0) - at(1.0 - PART, 1.0);
        let by_frequency = at(1.0, 1.0 + PART) - at(1.0, 1.0 - PART);
        let growth = by_amplitude / (Complex::<f64>::i() * by_frequency);
        LimitCycle { amplitude_rad, frequency_rad_s, stable: growth.re < 0.0 }
    }
}

/// Grid of the search.
const AMPLITUDES: usize = 80;
const FREQUENCIES: usize = 140;
/// Times a cell is halved.
const HALVINGS: usize = 24;

fn between(low: Swing, high: Swing) -> Swing {
    Swing {
        amplitude_rad: (low.amplitude_rad * high.amplitude_rad).sqrt(),
        frequency_rad_s: (low.frequency_rad_s * high.frequency_rad_s).sqrt(),
    }
}

/// `count` numbers in constant ratio.
fn geometric([low, high]: [f64; 2], count: usize) -> Vec<f64> {
    let ratio = (high / low).ln();
    // Exact for the sizes of a grid.
    #[allow(clippy::cast_precision_loss)]
    (0..count).map(|k| low * (ratio * k as f64 / (count - 1) as f64).exp()).collect()
}

/// Turns around zero of a closed path through four points.
fn turns(corners: [Complex<f64>; 4]) -> i32 {
    let turned: f64 = (0..4).map(|k| (corners[(k + 1) % 4] / corners[k]).arg()).sum();
    // A path of four points turns once at most.
    #[allow(clippy::cast_possible_truncation)]
    let turns = (turned / TAU).round() as i32;
    turns
}

#[cfg(test)]
mod tests;
