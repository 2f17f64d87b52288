//! The linear loop of section V with a dead time and a lag in series, the model the paper ends on.
//!
//! [`crate::stability`] has either, not both in series; where one of the two is zero, both agree (a test). Here thousands
//! of loops are judged a second, so everything is read off one pass over frequency.

use std::f64::consts::PI;

use nalgebra::Complex;

use crate::stability::Gains;

/// Plant, fluid and gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesLoop {
    /// J, kg m2.
    pub inertia_kg_m2: f64,
    /// L, s.
    pub torque_delay_s: f64,
    /// Q0, the viscosity without delay, N m s/rad.
    pub q0_nm_s_rad: f64,
    /// Q1, the viscosity behind the fluid, N m s/rad.
    pub q1_nm_s_rad: f64,
    /// L_Q, s.
    pub dead_time_s: f64,
    /// T_Q, s.
    pub lag_s: f64,
    /// Gains of the law.
    pub gains: Gains,
}

/// Margins of the loop opened at the control torque; infinite where nothing of the kind loses the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeriesMargins {
    /// Smallest extra lag that loses the loop, degrees.
    pub phase_deg: f64,
    /// Smallest factor above 1 on the control torque that loses it, up to 10.
    pub gain: f64,
    /// One over the largest factor below 1 that loses it.
    pub gain_down: f64,
    /// Smallest extra delay that loses it, s.
    pub delay_s: f64,
}

/// Lowest frequency of the pass, rad/s: far below K_P / Q(0) of any servo.
const LOWEST_RAD_S: f64 = 0.02;
/// Growth of the frequency from point to point, and largest phase of the delays between two.
const RATIO: f64 = 1.04;
const PHASE_STEP_RAD: f64 = 0.08;
/// Gain margins are looked for up to this factor; beyond it they count as infinite.
pub(super) const LARGEST_GAIN: f64 = 10.0;
/// Largest phase that the delays may turn up to the highest frequency that is looked at, rad, which is what a pass costs: a servo
/// is at sixty, and a hundred thousand passes at this take a minute.
const LARGEST_PHASE_RAD: f64 = 2000.0;
/// A larger turn between two points passes so near to zero that the loop counts as lost.
const LARGEST_TURN_RAD: f64 = 1.5;

impl SeriesLoop {
    /// J s^2 + Q(s) s at s = jw, N m/rad.
    fn without_control(&self, w: f64) -> Complex<f64> {
        let s = Complex::new(0.0, w);
        let fluid = Complex::from_polar(1.0, -w * self.dead_time_s) / (s * self.lag_s + 1.0);
        (s * self.inertia_kg_m2 + self.q0_nm_s_rad + fluid * self.q1_nm_s_rad) * s
    }

    /// (K_P + K_D s) e^(-Ls) at s = jw, N m/rad.
    fn control(&self, w: f64) -> Complex<f64> {
        Complex::new(self.gains.k_p_nm_rad, w * self.gains.k_d_nm_s_rad)
            * Complex::from_polar(1.0, -w * self.torque_delay_s)
    }

    /// With the gains times a factor, no root right of the axis has a modulus above this, rad/s: |e^(-Ls)| and |fluid| are
    /// at most 1 there.
    fn bound_rad_s(&self, factor: f64) -> f64 {
        let viscosity = self.q0_nm_s_rad + self.q1_nm_s_rad + factor * self.gains.k_d_nm_s_rad;
        let inertia = self.inertia_kg_m2;
        let stiffness = factor * self.gains.k_p_nm_rad;
        (viscosity + (viscosity * viscosity + 4.0 * inertia * stiffness).sqrt()) / (2.0 * inertia)
    }

    /// Phase that the delays turn up to the highest frequency that is looked at, rad, where that is too much for a pass, or no
    /// number.
    #[must_use]
    pub fn too_stiff_rad(&self) -> Option<f64> {
        let phase_rad = self.bound_rad_s(LARGEST_GAIN) * (self.torque_delay_s + self.dead_time_s);
        (phase_rad.is_nan() || phase_rad > LARGEST_PHASE_RAD).then_some(phase_rad)
    }

    /// Margins; none for an unstable loop, one too near to the edge to tell, or one that is too stiff.
    ///
    /// Stable is a characteristic function that turns by +180 degrees from w = 0 up (Mikhailov). The margins are where
    /// L(jw) crosses the unit circle and the negative real axis.
    #[must_use]
    pub fn margins(&self) -> Option<SeriesMargins> {
        if self.too_stiff_rad().is_some() {
            return None;
        }
        let top = 1.1 * self.bound_rad_s(LARGEST_GAIN);
        let step = PHASE_STEP_RAD / (self.torque_delay_s + self.dead_time_s).max(1e-6);
        let mut found = SeriesMargins {
            phase_deg: f64::INFINITY,
            gain: f64::INFINITY,
            gain_down: f64::INFINITY,
            delay_s: f64::INFINITY,
        };
        let mut w = LOWEST_RAD_S;
        let (mut plain, mut control) = (self.without_control(w), self.control(w));
        let mut turned = (plain + control).arg();
        let mut open = control / plain;
        while w < top {
            let next_w = (w * RATIO).min(w + step).min(top);
            let (next_plain, next_control) = (self.without_control(next_w), self.control(next_w));
            let next_open = next_control / next_plain;
            let turn = ((next_plain + next_control) / (plain + control)).arg();
            if turn.abs() > LARGEST_TURN_RAD {
                return None;
            }
            turned += turn;
            found.cross(w, open, next_w, next_open);
            (w, plain, control, open) = (next_w, next_plain, next_control, next_open);
        }
        // What is left of the way to -J w^2, whose phase is 180 degrees.
        turned += (Complex::from(-1.0) / (plain + control)).arg();
        ((turned - PI).abs() < 0.5).then_some(found)
    }

    /// Roots right of the imaginary axis by the argument principle, stepping down the axis so finely that none is passed
    /// unseen; none with a root on the axis, or for a loop that is too stiff. See [`crate::stability::argument`], which this follows.
    #[must_use]
    pub fn unstable_roots(&self) -> Option<u32> {
        if self.too_stiff_rad().is_some() {
            return None;
        }
        let radius = 1.1 * self.bound_rad_s(1.0);
        let at = |w: f64| self.without_control(w) + self.control(w);
        let mut here = at(radius);
        let mut turned = PI + (here / (-self.inertia_kg_m2 * radius * radius)).arg();
        let mut w = radius;
        while w > 0.0 {
            // |(s F)'| of F = e^(-ds) / (Ts + 1) is at most 1 + wd on the axis.
            let slope = 2.0 * self.inertia_kg_m2 * w
                + self.q0_nm_s_rad
                + self.q1_nm_s_rad * (1.0 + w * self.dead_time_s)
                + self.gains.k_d_nm_s_rad * (1.0 + w * self.torque_delay_s)
                + self.gains.k_p_nm_rad * self.torque_delay_s;
            let step = 0.5 * here.norm() / slope;
            if step < 1e-15 * radius {
                return None;
            }
            w = (w - step).max(0.0);
            let next = at(w);
            turned += (next / here).arg();
            here = next;
        }
        // Two at most for each turn of a phase that is bounded; never negative.
        Some((turned / PI).round().max(0.0) as u32)
    }
}

impl SeriesMargins {
    /// Takes what lies between two neighbouring points of L(jw), interpolated.
    fn cross(&mut self, w: f64, open: Complex<f64>, next_w: f64, next: Complex<f64>) {
        let (size, next_size) = (open.norm().ln(), next.norm().ln());
        if (size < 0.0) != (next_size < 0.0) {
            let share = size / (size - next_size);
            let phase = open.arg() + share * (next / open).arg();
            let lag = (phase + PI).rem_euclid(2.0 * PI);
            self.phase_deg = self.phase_deg.min(lag.to_degrees());
            self.delay_s = self.delay_s.min(lag / (w + share * (next_w - w)));
        }
        if (open.im < 0.0) != (next.im < 0.0) {
            let share = open.im / (open.im - next.im);
            let real = open.re + share * (next.re - open.re);
            if real < -1.0 {
                self.gain_down = self.gain_down.min(-real);
            } else if real < 0.0 {
                self.gain = self.gain.min(-1.0 / real);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::limits::margins;
    use crate::stability::{Fluid, Loop, NormalisedGains, Plant, argument};
    use rand::{Rng, SeedableRng, rngs::StdRng};

    /// The same loop for the stability module, where it has the fluid.
    fn known(series: &SeriesLoop) -> Loop {
        let fluid = match (series.dead_time_s, series.lag_s) {
            (0.0, 0.0) => Fluid::None,
            (l_q_s, 0.0) => Fluid::DeadTime { l_q_s },
            (_, t_q_s) => Fluid::Lag { t_q_s },
        };
        let SeriesLoop { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, .. } = *series;
        let plant = Plant { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid };
        Loop::new(plant, series.gains).unwrap()
    }

    /// A rotor a billion times lighter than its drag asks for: the steps of a pass would be a ten-billionth of its way.
    #[test]
    fn a_loop_that_is_too_stiff_is_told_and_costs_nothing() {
        let gains = NormalisedGains { kp: 0.1, kd: 0.5 }.physical(0.075, 0.005);
        let servo = SeriesLoop {
            inertia_kg_m2: 0.075,
            torque_delay_s: 0.005,
            q0_nm_s_rad: 0.01,
            q1_nm_s_rad: 30.0,
            dead_time_s: 0.002,
            lag_s: 0.003,
            gains,
        };
        assert_eq!(servo.too_stiff_rad(), None);
        for inertia_kg_m2 in [1e-9, 1e-300, 5e-324] {
            let light = SeriesLoop { inertia_kg_m2, ..servo };
            assert!(light.too_stiff_rad().is_some());
            assert_eq!((light.margins(), light.unstable_roots()), (None, None));
        }
    }

    #[test]
    fn a_dead_time_or_a_lag_alone_has_the_margins_of_the_stability_module() {
        let mut random = StdRng::seed_from_u64(7);
        let (mut stable, mut told) = (0, 0);
        for case in 0..300 {
            let torque_delay_s = random.random_range(0.001..0.012);
            let delay_s = random.random_range(0.001..0.01);
            let gains = NormalisedGains { kp: random.random_range(0.01..0.2), kd: random.random_range(0.1..0.9) };
            let series = SeriesLoop {
                inertia_kg_m2: 0.075,
                torque_delay_s,
                q0_nm_s_rad: random.random_range(0.0..0.5),
                q1_nm_s_rad: random.random_range(0.1..30.0),
                dead_time_s: if case % 3 == 0 { delay_s } else { 0.0 },
                lag_s: if case % 3 == 1 { delay_s } else { 0.0 },
                gains: gains.physical(0.075, torque_delay_s),
            };
            let closed = known(&series);
            let count = argument::unstable_roots(&closed).unwrap();
            assert_eq!(series.unstable_roots(), Some(count as u32), "{series:?}");
            let Some(found) = series.margins() else {
                stable += usize::from(count == 0);
                continue;
            };
            assert_eq!(count, 0, "{series:?}");
            told += 1;
            let known = margins(&closed).unwrap();
            let near = |found: f64, known: Option<f64>| match known {
                Some(known) => (found / known - 1.0).abs() < 0.02,
                None => found == f64::INFINITY,
            };
            // The module looks further, for a loop that is lost at more than ten times its gain.
            let gain = known.gain.filter(|gain| found.gain.is_finite() || *gain < 0.95 * LARGEST_GAIN);
            assert!(near(found.gain, gain), "{series:?}: {found:?} {known:?}");
            assert!(near(found.phase_deg, known.phase_deg), "{series:?}: {found:?} {known:?}");
            assert!(near(found.delay_s, known.delay_s), "{series:?}: {found:?} {known:?}");
        }
        // Only at the very edge it may not tell.
        assert!(told > 100 && stable <= 3, "{told} with margins, {stable} stable ones without");
    }
}
