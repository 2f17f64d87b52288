//! Loads on springs that are not always as stiff, springs that lose work, masses that come and go, and liquids at a wall.

use std::f64::consts::{PI, TAU};

use super::super::beyond::TwoStates;
use super::super::{Hidden, Rub, Seen};

/// A share of the inertia on a spring that may be stiffer here than there.
struct Hung {
    share: f64,
    inertia: f64,
    /// Angular frequency of the load alone where the spring is what it is called, 1/s.
    omega: f64,
    damping_ratio: f64,
    at: f64,
    speed: f64,
}

impl Hung {
    /// Share, Hz, damping ratio, inertia.
    fn new(v: &[f64]) -> Self {
        Self { share: v[0], inertia: v[3], omega: TAU * v[1], damping_ratio: v[2], at: 0.0, speed: 0.0 }
    }

    /// Torque on the axis; `springs` makes of a twist that of a straight spring.
    fn pass(&mut self, seen: &Seen, springs: impl Fn(f64) -> f64) -> f64 {
        let middle = self.at + 0.5 * seen.step_s * self.speed;
        let damps = 2.0 * self.damping_ratio * self.omega * (seen.speed - self.speed);
        let gains = self.omega * self.omega * springs(seen.position - middle) + damps;
        self.speed += seen.step_s * gains;
        self.at = middle + 0.5 * seen.step_s * self.speed;
        -self.share * self.inertia * gains
    }
}

/// A nut on a screw that is held at one end: the more of the screw is between them, the softer it is (Varanasi and Nayfeh, J. Dyn. Sys. Meas.
/// Control 126 (2004) 857: dynamics of lead screws); share, Hz in the middle, damping ratio, inertia, way to the bearing.
pub(in crate::outside) struct ScrewLength {
    load: Hung,
    way: f64,
}

impl ScrewLength {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { load: Hung::new(v), way: v[4] }
    }
}

impl Hidden for ScrewLength {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let length = 1.0 + (seen.position / self.way).clamp(-0.9, 0.9);
        self.load.pass(seen, |twist| twist / length)
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.load.share
    }
}

/// Stiffness of a strain wave gear about no torque, over that under a large one, 1.
const SOFT: f64 = 0.2;

/// A load behind a strain wave gear, which is soft about no torque and stiffens as it winds up (Tuttle and Seering, IEEE Trans. Robot. Autom.
/// 12 (1996) 368); share, Hz when wound up, damping ratio, inertia, twist.
pub(in crate::outside) struct WindsUp {
    load: Hung,
    twist: f64,
}

impl WindsUp {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { load: Hung::new(v), twist: v[4] }
    }
}

impl Hidden for WindsUp {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let whole = self.twist;
        self.load.pass(seen, |twist| {
            let squared = twist * twist;
            twist * (SOFT + (1.0 - SOFT) * squared / (squared + whole * whole))
        })
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.load.share
    }
}

/// A shaft with a crack that closes when it is wound one way and opens the other, where it is softer (Dimarogonas, Eng. Fract. Mech. 55 (1996)
/// 831: cracks that breathe); share, Hz when closed, damping ratio, inertia, stiffness when open over that.
pub(in crate::outside) struct Cracked {
    load: Hung,
    open: f64,
}

impl Cracked {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { load: Hung::new(v), open: v[4] }
    }
}

impl Hidden for Cracked {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let open = self.open;
        self.load.pass(seen, |twist| if twist > 0.0 { twist } else { open * twist })
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.load.share
    }
}

/// A wire of an alloy with memory of its shape: beyond a strain its grain turns over at one stress, and turns back at a lower one (Auricchio,
/// Taylor and Lubliner, Comput. Methods Appl. Mech. Eng. 146 (1997) 281: superelasticity); stiffness, way of the whole turning over, way to the
/// higher stress, the lower over that.
pub(in crate::outside) struct Superelastic {
    law: [f64; 4],
    turned: f64,
}

impl Superelastic {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { law: [v[0], v[1], v[2], v[3] * v[2]], turned: 0.0 }
    }
}

impl Hidden for Superelastic {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [stiffness, most, high, low] = self.law;
        let beyond = |way: f64, from: f64| (way - from).max(0.0).min(most);
        let at = seen.position;
        let least = beyond(at, high) - beyond(-at, low);
        self.turned = self.turned.max(least).min(beyond(at, low) - beyond(-at, high));
        -stiffness * (at - self.turned)
    }
}

/// A pack of leaves: a spring whose leaves are pressed on each other, and rub, the more it is bent (Fancher and others, SAE 800905, 1980:
/// leaf springs of trucks); stiffness, friction over the force of the spring.
pub(in crate::outside) struct Leaves(pub(in crate::outside) [f64; 2]);

impl Hidden for Leaves {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.0[0] * seen.position
    }

    fn friction(&mut self, seen: &Seen) -> Rub {
        Rub::level(self.0[1] * self.0[0] * seen.position.abs())
    }
}

/// A hopper that is filled while it moves: what falls in takes its momentum from the axis (Cveticanin, Dynamics of Machines with Variable
/// Mass, 1998); share, from when, for how long, inertia.
pub(in crate::outside) struct HopperFills(pub(in crate::outside) [f64; 4]);

impl Hidden for HopperFills {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [share, from_s, over_s, inertia] = self.0;
        let fills = (from_s..from_s + over_s).contains(&seen.t_s);
        if fills { -share * inertia / over_s * seen.speed } else { 0.0 }
    }

    fn inertia(&self, seen: &Seen) -> f64 {
        let [share, from_s, over_s, _] = self.0;
        1.0 + share * ((seen.t_s - from_s) / over_s).clamp(0.0, 1.0)
    }
}

/// Weights that dry friction holds where they are: they fly out at one speed, and come back only at a much lower one (Vyshnegradskii,
/// Civilingenieur 23 (1877) 95: regulators with friction). The momentum stays as they move; share, speed, time, inertia.
pub(in crate::outside) struct WeightsStick {
    share: f64,
    inertia: f64,
    out: TwoStates,
    before: f64,
    at: f64,
}

impl WeightsStick {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], inertia: v[3], out: TwoStates::new(v[1], 0.3, v[2]), before: 0.0, at: 0.0 }
    }
}

impl Hidden for WeightsStick {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.before = self.at;
        self.at = self.out.after(seen);
        -self.share * self.inertia * (self.at - self.before) / seen.step_s * seen.speed
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 + self.share * self.at
    }
}

/// Layers of liquid that are dragged along after one another, and how many times thicker each is than the one before.
const LAYERS: usize = 8;
const THICKER: f64 = 4.0;

/// A disc in a liquid: what is near it turns with it at once, what is farther off by and by, so that it drags with half a derivative of
/// the speed (Basset, A Treatise on Hydrodynamics, 1888: the force remembers how the speed was gained); coefficient, rate of the
/// thickest layer that the vessel has room for.
pub(in crate::outside) struct LiquidLayer {
    coefficient: f64,
    rates: [f64; LAYERS],
    late: [f64; LAYERS],
}

impl LiquidLayer {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let rates = std::array::from_fn(|index| v[1] * THICKER.powi(index as i32));
        Self { coefficient: v[0], rates, late: [0.0; LAYERS] }
    }

    /// Of s^(1/2) = integral of x^(1/2) s / (s + x) over ln x, over pi.
    fn weight(rate: f64) -> f64 {
        rate.sqrt() * THICKER.ln() / PI
    }
}

impl Hidden for LiquidLayer {
    fn friction(&mut self, _: &Seen) -> Rub {
        let whole: f64 = self.rates.iter().map(|rate| Self::weight(*rate)).sum();
        Rub { viscous: self.coefficient * whole, ..Rub::NONE }
    }

    fn torque(&mut self, seen: &Seen) -> f64 {
        let mut carried = 0.0;
        for (rate, late) in self.rates.iter().zip(&mut self.late) {
            *late += seen.share_of_lag(1.0 / rate) * (seen.speed - *late);
            carried += Self::weight(*rate) * *late;
        }
        self.coefficient * carried
    }
}
