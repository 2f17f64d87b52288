//! What gains guarantee: the least margins of the linear loop over every delay and viscosity it may meet.

use rand::{Rng, SeedableRng, rngs::StdRng};

use super::series::{SeriesLoop, SeriesMargins};
use crate::stability::Gains;

/// Margins that must be kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demands {
    /// Phase margin, degrees.
    pub phase_deg: f64,
    /// Gain margin, a factor above 1.
    pub gain: f64,
    /// Delay margin: delay on top of all others, as a share of the nominal L.
    pub delay_share: f64,
}

/// The delays and viscosities a loop may meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// J, kg m2.
    pub inertia_kg_m2: f64,
    /// Nominal L, s.
    pub torque_delay_s: f64,
    /// What the law adds to L for certain, s: hold and speed estimate.
    pub law_delay_s: f64,
    /// Nominal dead time and lag of the fluid, s; none without a damper.
    pub fluid_s: Option<(f64, f64)>,
    /// Each delay may be off by this share, up or down.
    pub uncertainty: f64,
    /// Viscosity without delay, N m s/rad.
    pub q0_nm_s_rad: f64,
    /// Largest viscosity behind the fluid's delay, N m s/rad.
    pub q1_nm_s_rad: f64,
}

/// The least margins over a range, each of them with where it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guarantee {
    /// The least of the margins over those demanded; 1 keeps them, 0 is the edge of stability.
    pub level: f64,
    /// The loop whose margin that is.
    pub worst: SeriesLoop,
    /// Least phase margin, degrees; infinite if no loop has one.
    pub phase_deg: f64,
    /// Least gain margin, a factor; infinite if no loop has one up to 10.
    pub gain: f64,
    /// Least delay margin, s; infinite if no loop has one.
    pub delay_s: f64,
}

/// Shares of an uncertainty that are looked at. Margins need not fall evenly with a delay: its middle counts too.
const SHARES: [f64; 3] = [1.0, 0.0, -1.0];
/// Viscosities between none and the largest, as shares of it. Worst first, so that bad gains are soon refused.
const VISCOSITIES: [f64; 6] = [1.0, 0.0, 0.6, 0.3, 0.1, 0.01];

impl Range {
    /// The loops that are looked at, the worst of most gains first.
    #[must_use]
    pub fn loops(&self, gains: Gains) -> Vec<SeriesLoop> {
        let mut loops = Vec::new();
        let factors = SHARES.map(|share| 1.0 + share * self.uncertainty);
        for viscosity in VISCOSITIES {
            for torque in factors {
                for dead_time in factors {
                    for lag in factors {
                        loops.push(self.at(gains, viscosity, [torque, dead_time, lag]));
                    }
                }
            }
        }
        // A delay that is zero, and the fluid's at no viscosity, make the same loop several times in a row.
        loops.dedup();
        loops
    }

    /// The loop with a share of the largest viscosity, and L, dead time and lag times a factor each.
    fn at(&self, gains: Gains, viscosity: f64, [torque, dead_time, lag]: [f64; 3]) -> SeriesLoop {
        let q1_nm_s_rad = self.fluid_s.map_or(0.0, |_| viscosity * self.q1_nm_s_rad);
        let fluid_s = self.fluid_s.filter(|_| q1_nm_s_rad > 0.0);
        let (dead_time_s, lag_s) = fluid_s.map_or((0.0, 0.0), |(dead_s, lag_s)| (dead_s * dead_time, lag_s * lag));
        SeriesLoop {
            inertia_kg_m2: self.inertia_kg_m2,
            torque_delay_s: self.torque_delay_s * torque + self.law_delay_s,
            q0_nm_s_rad: self.q0_nm_s_rad,
            q1_nm_s_rad,
            dead_time_s,
            lag_s,
            gains,
        }
    }

    /// The guarantee of gains; none if some loop is unstable, or too near to it to tell.
    #[must_use]
    pub fn guarantee(&self, gains: Gains, demands: &Demands) -> Option<Guarantee> {
        let mut least: Option<Guarantee> = None;
        for worst in self.loops(gains) {
            let found = worst.margins()?;
            let level = self.level(&found, demands);
            let SeriesMargins { phase_deg, gain, delay_s, .. } = found;
            least = Some(match least {
                None => Guarantee { level, worst, phase_deg, gain, delay_s },
                Some(least) => Guarantee {
                    level: least.level.min(level),
                    worst: if level < least.level { worst } else { least.worst },
                    phase_deg: least.phase_deg.min(phase_deg),
                    gain: least.gain.min(gain),
                    delay_s: least.delay_s.min(delay_s),
                },
            });
        }
        least
    }

    /// The least margin over its demand.
    #[must_use]
    pub fn level(&self, found: &SeriesMargins, demands: &Demands) -> f64 {
        let gain = found.gain.min(found.gain_down).ln() / demands.gain.ln();
        let phase = found.phase_deg / demands.phase_deg;
        let delay = found.delay_s / (demands.delay_share * self.nominal_delay_s());
        gain.min(phase).min(delay)
    }

    /// The delay that scales gains and the delay margin, s: L, or what the law adds where the machine has none.
    #[must_use]
    pub fn nominal_delay_s(&self) -> f64 {
        if self.torque_delay_s > 0.0 { self.torque_delay_s } else { self.law_delay_s }
    }

    /// The viscosity above which the slowest fluid of the range makes the damper unstable by itself, without control
    /// torque, N m s/rad; none if it does not up to the largest.
    #[must_use]
    pub fn unstable_alone_nm_s_rad(&self) -> Option<f64> {
        // A spring too weak to matter keeps the root at zero off the axis.
        let gains = Gains { k_p_nm_rad: 1e-3, k_d_nm_s_rad: 0.0 };
        let stable = |share: f64| {
            let alone = SeriesLoop { torque_delay_s: 0.0, ..self.at(gains, share, [1.0 + self.uncertainty; 3]) };
            alone.unstable_roots() == Some(0)
        };
        if stable(1.0) {
            return None;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if stable(middle) { low = middle } else { high = middle }
        }
        Some(low * self.q1_nm_s_rad)
    }

    /// Loops drawn evenly within the uncertainty of each delay and the viscosities, the same for the same seed.
    pub fn draws(&self, gains: Gains, count: usize, seed: u64) -> impl Iterator<Item = SeriesLoop> {
        let mut random = StdRng::seed_from_u64(seed);
        (0..count).map(move |_| {
            let factors = [(); 3].map(|()| 1.0 + self.uncertainty * random.random_range(-1.0..=1.0));
            self.at(gains, random.random_range(0.0..=1.0), factors)
        })
    }
}
