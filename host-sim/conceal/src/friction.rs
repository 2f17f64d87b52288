//! Friction as the impulse of one step.

use crate::physics;

/// Slower than this between two steps counts as rest for the ageing contact, rad/s.
const REST_RAD_S: f64 = 1e-9;

#[derive(Debug, Clone)]
pub(crate) struct Friction {
    law: physics::Friction,
    step_s: f64,
    /// Torque of the bristle, N m, signed like the motion.
    bristle_nm: f64,
    rest_s: f64,
    /// In the store that all drag warms, J.
    heat_j: f64,
}

/// What friction can do in one step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    /// Largest torque against forward and against backward motion, N m.
    pub(crate) level_nm: [f64; 2],
    /// Torque per speed, N m s/rad.
    pub(crate) viscous_nm_s_rad: f64,
    /// Torque of bristles, already known at the start of the step, N m.
    pub(crate) known_nm: f64,
}

impl Friction {
    pub(crate) fn new(law: &physics::Friction, step_s: f64) -> Self {
        Self { law: law.clone(), step_s, bristle_nm: 0.0, rest_s: 0.0, heat_j: 0.0 }
    }

    /// Bounds of the step at an angle, rad, a speed, rad/s, under a drive torque, N m.
    pub(crate) fn bounds(&mut self, position_rad: f64, speed_rad_s: f64, drive_nm: f64) -> Bounds {
        let law = &self.law;
        let mut mean_nm = law.coulomb_nm * (1.0 + law.over_position.map_or(0.0, |wave| wave.at(position_rad)));
        mean_nm += law.per_load * drive_nm.abs();
        if let Some((excess_nm, speed)) = law.stribeck {
            mean_nm += excess_nm * (-(speed_rad_s / speed).powi(2)).exp();
        }
        self.rest_s = if speed_rad_s.abs() < REST_RAD_S { self.rest_s + self.step_s } else { 0.0 };
        if let Some((excess_nm, time_s)) = law.ageing {
            mean_nm -= excess_nm * (-self.rest_s / time_s).exp_m1();
        }
        let half_nm = 0.5 * law.difference_nm;
        let level_nm = [mean_nm + half_nm, mean_nm - half_nm].map(|level| level.max(0.0));
        let uneven = 0.5 * law.viscous_difference_nm_s_rad * speed_rad_s.signum();
        // Warmth thins what is linear in the speed; drag with its square is of the air.
        let thinned = law.warming.map_or(1.0, |(per_j, _)| (-per_j * self.heat_j).exp());
        let linear = thinned * (law.viscous_nm_s_rad + uneven);
        let viscous_nm_s_rad = linear + law.quadratic_nm_s2_rad2 * speed_rad_s.abs();
        match law.presliding_nm_rad {
            None => Bounds { level_nm, viscous_nm_s_rad, known_nm: 0.0 },
            Some(stiffness) => {
                // Dahl: df/dx = k (1 - s f/F), over the way of this step.
                let travel = speed_rad_s * self.step_s;
                let level = if travel >= 0.0 { level_nm[0] } else { level_nm[1] };
                let slope = stiffness * (1.0 - travel.signum() * self.bristle_nm / level);
                self.bristle_nm = (self.bristle_nm + slope * travel).clamp(-level_nm[1], level_nm[0]);
                Bounds { level_nm: [0.0; 2], viscous_nm_s_rad, known_nm: self.bristle_nm }
            }
        }
    }

    /// Takes the power of all drag over a step into the store, W.
    pub(crate) fn warm(&mut self, power_w: f64) {
        if let Some((_, cooling_per_s)) = self.law.warming {
            self.heat_j += self.step_s * (power_w - cooling_per_s * self.heat_j);
        }
    }
}

/// The fluid below yield: a spring that slips at the level of its torque.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Yield {
    stiffness_nm_rad: f64,
    torque_nm: f64,
}

impl Yield {
    pub(crate) fn new(stiffness_nm_rad: f64) -> Self {
        Self { stiffness_nm_rad, torque_nm: 0.0 }
    }

    /// Torque after a way, rad, under a yield level, N m; signed like the motion.
    pub(crate) fn pass(&mut self, travel_rad: f64, level_nm: f64) -> f64 {
        self.torque_nm = (self.torque_nm + self.stiffness_nm_rad * travel_rad).clamp(-level_nm, level_nm);
        self.torque_nm
    }
}
