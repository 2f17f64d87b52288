//! Loads that are taken along and left, springs that snap, gyroscopes, and axes beside this one.

use std::f64::consts::TAU;

use super::super::unseen::Swing;
use super::super::{Hidden, Seen};

/// A flywheel on a clutch that drives one way only: the axis has to bring it up to speed, and it runs on by itself (Niemann and Winter,
/// Maschinenelemente 3, 2003: freewheels).
pub(in crate::outside) struct Freewheel {
    share: f64,
    engaging_s: f64,
    coasting_s: f64,
    inertia: f64,
    speed: f64,
}

impl Freewheel {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], engaging_s: v[1], coasting_s: v[2], inertia: v[3], speed: 0.0 }
    }
}

impl Hidden for Freewheel {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let taken = seen.share_of_lag(self.engaging_s) * (seen.speed - self.speed).max(0.0);
        self.speed += taken - seen.share_of_lag(self.coasting_s) * self.speed;
        -self.share * self.inertia * taken / seen.step_s
    }
}

/// A chain that the axis picks up from the floor one way and lays down the other: what is picked up takes momentum, what is laid down brings
/// none back (Cayley, Proc. R. Soc. 8 (1857) 506); share, half of the way, inertia.
pub(in crate::outside) struct PicksUp(pub(in crate::outside) [f64; 3]);

impl Hidden for PicksUp {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [share, way, inertia] = self.0;
        let lifts = seen.speed > 0.0 && seen.position.abs() < way;
        if lifts { -0.5 * share * inertia / way * seen.speed * seen.speed } else { 0.0 }
    }

    fn inertia(&self, seen: &Seen) -> f64 {
        let [share, way, _] = self.0;
        // Nominal in the middle.
        1.0 + 0.5 * share * (seen.position / way).clamp(-1.0, 1.0)
    }
}

/// A buckled strip: it pushes to its rest on one side until the axis has come as far to the other, snaps over, and has its rest there
/// (Howell, Compliant Mechanisms, 2001: bistable mechanisms).
pub(in crate::outside) struct Snaps {
    level: f64,
    at: f64,
    time_s: f64,
    over: bool,
    side: f64,
}

impl Snaps {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], at: v[1], time_s: v[2], over: false, side: -1.0 }
    }
}

impl Hidden for Snaps {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.over = seen.position > if self.over { -self.at } else { self.at };
        let wanted = if self.over { 1.0 } else { -1.0 };
        self.side += seen.share_of_lag(self.time_s) * (wanted - self.side);
        self.level * (self.side - seen.position / self.at).clamp(-1.0, 1.0)
    }
}

/// A pawl on a spring: the axis bends it until it clicks over a tooth and is straight again, either way (Tomlinson, Phil. Mag. 7 (1929) 905:
/// what is plucked loses its work).
pub(in crate::outside) struct Clicks {
    level: f64,
    pitch: f64,
    tooth: f64,
}

impl Clicks {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], pitch: v[1], tooth: 0.0 }
    }
}

impl Hidden for Clicks {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.tooth += ((seen.position - self.tooth) / self.pitch).trunc() * self.pitch;
        -self.level * (seen.position - self.tooth) / self.pitch
    }
}

/// A spinning wheel in a gimbal whose bearings are dry: turned faster than these hold, it precesses, and pushes back as a spring that lets go
/// when the axis is slow (Arnold and Maunder, Gyrodynamics, 1961).
pub(in crate::outside) struct DryGimbal {
    stiffness: f64,
    /// At which the moment of the wheel breaks the bearings loose.
    speed: f64,
    pushes: f64,
}

impl DryGimbal {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { stiffness: v[0], speed: v[1], pushes: 0.0 }
    }
}

impl Hidden for DryGimbal {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let free = self.pushes + self.stiffness * seen.step_s * seen.speed;
        let most = self.stiffness * seen.step_s * self.speed;
        self.pushes = free - free.clamp(-most, most);
        -self.pushes
    }
}

/// The same wheel in a gimbal that turns freely between two stops, where it comes to rest: there it holds the axis no more (Arnold and
/// Maunder, as above); stiffness, Hz of nutation, angle of the stops.
pub(in crate::outside) struct GimbalStops {
    stiffness: f64,
    /// Of the gimbal's turning over the axis' way, 1/s.
    rate: f64,
    most: f64,
    turned: f64,
    twist: f64,
}

impl GimbalStops {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { stiffness: v[0], rate: TAU * v[1], most: v[2], turned: 0.0, twist: 0.0 }
    }
}

impl Hidden for GimbalStops {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.twist += seen.step_s * seen.speed;
        self.turned += seen.step_s * self.rate * self.twist;
        if self.turned.abs() > self.most {
            (self.turned, self.twist) = (self.turned.clamp(-self.most, self.most), 0.0);
        }
        -self.stiffness * self.twist
    }
}

/// An elbow behind this joint that swings on its own: the inertia goes up and down with the time (Craig, Introduction to Robotics, 2005:
/// Coriolis terms); share, Hz, phase, inertia.
pub(in crate::outside) struct Elbow(pub(in crate::outside) [f64; 4]);

impl Elbow {
    fn angle(&self, seen: &Seen) -> f64 {
        TAU * self.0[1] * (seen.t_s + 0.5 * seen.step_s) + self.0[2]
    }
}

impl Hidden for Elbow {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [share, hz, _, inertia] = self.0;
        -inertia * share * TAU * hz * self.angle(seen).cos() * seen.speed
    }

    fn inertia(&self, seen: &Seen) -> f64 {
        1.0 + self.0[0] * self.angle(seen).sin()
    }
}

/// A weight off its centre that springs balance on level ground, on a ship that rolls: gravity comes from other sides (Fossen, Handbook of
/// Marine Craft Hydrodynamics and Motion Control, 2011); amplitude, Hz, phase, order, angle of the roll.
pub(in crate::outside) struct RollingShip(pub(in crate::outside) [f64; 5]);

impl Hidden for RollingShip {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let [amplitude, hz, phase, order, most] = self.0;
        let roll = most * (TAU * hz * (seen.t_s + 0.5 * seen.step_s) + phase).sin();
        let at = order * seen.position;
        -amplitude * ((at + roll).sin() - at.sin())
    }
}

/// A crank that shakes a mass through a spring: near the resonance the mass takes the torque that drives the crank (Kononenko, Vibrating
/// Systems with a Limited Power Supply, 1969).
pub(in crate::outside) struct Shaker {
    level: f64,
    order: f64,
    phase: f64,
    mass: Swing,
}

impl Shaker {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], order: v[1], phase: v[2], mass: Swing::new(v[3], v[4]) }
    }
}

impl Hidden for Shaker {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let (angle, at_start) = (self.order * seen.position + self.phase, self.phase.cos());
        let mass = at_start + self.mass.pass(angle.cos() - at_start, seen.step_s)[0];
        -self.level * angle.sin() * (mass - angle.cos())
    }
}
