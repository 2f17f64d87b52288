//! Loads behind couplings that skip, loads that lose contact, and a base that the axis pushes away.

use std::f64::consts::TAU;

use super::super::{Hidden, Seen};

/// A mass beside the axis, moved by the midpoint rule as the axis is.
struct Rider {
    at: f64,
    speed: f64,
}

impl Rider {
    fn at(at: f64) -> Self {
        Self { at, speed: 0.0 }
    }

    /// How far the axis is ahead in the middle of a step, and how much faster at its start.
    fn behind(&self, position: f64, speed: f64, step_s: f64) -> (f64, f64) {
        (position - self.at - 0.5 * step_s * self.speed, speed - self.speed)
    }

    fn gain(&mut self, acceleration: f64, step_s: f64) {
        self.at += step_s * (self.speed + 0.5 * step_s * acceleration);
        self.speed += step_s * acceleration;
    }
}

/// A spring with a damper, for each unit of the mass behind it.
struct Link {
    /// Angular frequency of the mass alone, 1/s.
    omega: f64,
    damping_ratio: f64,
}

impl Link {
    /// Hz, damping ratio.
    fn new(v: &[f64]) -> Self {
        Self { omega: TAU * v[0], damping_ratio: v[1] }
    }

    fn pulls(&self, twist: f64, slip: f64) -> f64 {
        self.omega * self.omega * twist + 2.0 * self.damping_ratio * self.omega * slip
    }
}

/// A load behind a coupling of magnets: a spring about each pole, that lets go where the twist is too large and takes hold at the next pole
/// (Charpentier and Lemarquand, IEEE Trans. Magn. 35 (1999) 1037: synchronous couplings); share, Hz, damping ratio, inertia, poles a radian.
pub(in crate::outside) struct MagnetCoupling {
    share: f64,
    inertia: f64,
    poles: f64,
    link: Link,
    load: Rider,
}

impl MagnetCoupling {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], inertia: v[3], poles: v[4], link: Link::new(&v[1..3]), load: Rider::at(0.0) }
    }
}

impl Hidden for MagnetCoupling {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let (twist, slip) = self.load.behind(seen.position, seen.speed, seen.step_s);
        let pulls = self.link.pulls((self.poles * twist).sin() / self.poles, slip);
        self.load.gain(pulls, seen.step_s);
        -self.share * self.inertia * pulls
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.share
    }
}

/// Way from pocket to pocket over the twist at which balls leave theirs, 1.
const POCKETS: f64 = 3.0;
/// Slip at which they fall into one, over that of a swing from there, 1.
const SLOWLY: f64 = 0.2;

/// A load behind balls in pockets: they ride out where the twist is too large, and fall into the next pocket they meet slowly enough
/// (Niemann and Winter, Maschinenelemente 3, 2003: overload couplings); share, Hz, damping ratio, inertia, twist.
pub(in crate::outside) struct BallDetent {
    share: f64,
    inertia: f64,
    most: f64,
    link: Link,
    load: Rider,
    out: bool,
    pocket: f64,
}

impl BallDetent {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let (link, load) = (Link::new(&v[1..3]), Rider::at(0.0));
        Self { share: v[0], inertia: v[3], most: v[4], link, load, out: false, pocket: 0.0 }
    }
}

impl Hidden for BallDetent {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let (twist, slip) = self.load.behind(seen.position, seen.speed, seen.step_s);
        let way = (twist - self.pocket).abs();
        if !self.out {
            self.out = way > self.most;
        } else if way > POCKETS * self.most && slip.abs() < SLOWLY * self.most * self.link.omega {
            (self.out, self.pocket) = (false, twist);
        }
        let held = if self.out { 0.0 } else { twist - self.pocket };
        let pulls = self.link.pulls(held, slip);
        self.load.gain(pulls, seen.step_s);
        -self.share * self.inertia * pulls
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.share
    }
}

/// What a rope and a floor take up: of their force, over what is elastic, at the speed that the weight gains in one radian of a swing, 1.
const TAKE_UP: [f64; 2] = [0.5, 2.0];

/// A weight on a rope, which a spring of constant force balances.
struct Hanging {
    share: f64,
    inertia: f64,
    falls: f64,
    /// Angular frequency of the weight on its rope, 1/s.
    omega: f64,
    weight: Rider,
}

impl Hanging {
    /// Share, Hz, inertia, gain of speed in falling.
    fn new(v: &[f64]) -> Self {
        let omega = TAU * v[1];
        Self { share: v[0], inertia: v[2], falls: v[3], omega, weight: Rider::at(-v[3] / omega.powi(2)) }
    }

    /// Of a contact that only pushes, which a blow stiffens the more the deeper it is (Hunt and Crossley, J. Appl. Mech. 42 (1975) 440).
    fn contact(&self, deep: f64, closes: f64, takes_up: f64) -> f64 {
        let rate = takes_up * self.omega / self.falls;
        self.omega * self.omega * deep.max(0.0) * (1.0 + rate * closes).max(0.0)
    }

    /// Torque on the axis; the weight may lie on a floor.
    fn pass(&mut self, seen: &Seen, floor: Option<f64>) -> f64 {
        let [rope, ground] = TAKE_UP;
        let (stretch, slip) = self.weight.behind(seen.position, seen.speed, seen.step_s);
        let pulls = self.contact(stretch, slip, rope);
        let lifts = floor.map_or(0.0, |floor| {
            let (sinks, closes) = self.weight.behind(floor, 0.0, seen.step_s);
            self.contact(sinks, closes, ground)
        });
        self.weight.gain(pulls + lifts - self.falls, seen.step_s);
        self.share * self.inertia * (self.falls - pulls)
    }
}

/// A weight on a rope: where the axis lets it down faster than it falls the rope goes slack, and jerks when it is taut again (Janovsky,
/// Elevator Mechanical Design, 1999: jumps of counterweights); share, Hz, inertia, gain of speed in falling.
pub(in crate::outside) struct WeightJumps(Hanging);

impl WeightJumps {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self(Hanging::new(v))
    }
}

impl Hidden for WeightJumps {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.0.pass(seen, None)
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.0.share
    }
}

/// A weight on a rope that comes down on a floor: below, the axis has all of what balances it, and its mass no more (Janovsky, as above:
/// buffers); share, Hz, inertia, gain of speed in falling, way down to the floor.
pub(in crate::outside) struct WeightLands {
    hanging: Hanging,
    floor: f64,
}

impl WeightLands {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { hanging: Hanging::new(v), floor: -v[4] }
    }
}

impl Hidden for WeightLands {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.hanging.pass(seen, Some(self.floor))
    }

    fn inertia(&self, _: &Seen) -> f64 {
        1.0 - self.hanging.share
    }
}

/// A machine whose feet slide on the floor where its own torque pushes it too hard: the sensor rides on the base, and what the base gains the
/// axis shows too (Chernousko, J. Appl. Math. Mech. 66 (2002) 1: bodies on dry ground moved from within); inertia of the axis over that of
/// the base, friction of the feet.
pub(in crate::outside) struct FeetSlide {
    share: f64,
    level: f64,
    momentum: f64,
}

impl FeetSlide {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], level: v[1], momentum: 0.0 }
    }
}

impl Hidden for FeetSlide {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let (before, most) = (self.momentum, seen.step_s * self.level);
        let free = before - seen.step_s * seen.drive;
        self.momentum = free - free.clamp(-most, most);
        -self.share * (self.momentum - before) / seen.step_s
    }
}

/// A machine on a raft that turns the other way, and that the water brakes with the square of its speed (Fossen, Handbook of Marine Craft
/// Hydrodynamics and Motion Control, 2011: damping); inertia of the axis over that of the raft, drag over the square of its momentum.
pub(in crate::outside) struct RaftTurns {
    share: f64,
    drag: f64,
    momentum: f64,
}

impl RaftTurns {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], drag: v[1], momentum: 0.0 }
    }
}

impl Hidden for RaftTurns {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let before = self.momentum;
        let brakes = 1.0 + seen.step_s * self.drag * before.abs();
        self.momentum = (before - seen.step_s * seen.drive) / brakes;
        -self.share * (self.momentum - before) / seen.step_s
    }
}
