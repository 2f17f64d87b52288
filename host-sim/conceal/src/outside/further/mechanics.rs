//! Oil and air that leak from where they are pressed, and loads that lie loose.

use super::super::{Hidden, Seen};

/// Pressure that a way builds up and that an orifice lets go with its root: dp/dt = speed / way - sign(p) sqrt(|p|) / time.
struct Chamber {
    way: f64,
    time_s: f64,
    pressure: f64,
}

impl Chamber {
    fn new(way: f64, time_s: f64) -> Self {
        Self { way, time_s, pressure: 0.0 }
    }

    /// Pressure after a step with this speed, 1; implicit in the outflow, which is endlessly steep about zero.
    fn after(&mut self, speed: f64, step_s: f64) -> f64 {
        let pressed = self.pressure + step_s * speed / self.way;
        let leak = 0.5 * step_s / self.time_s;
        // Of root^2 + 2 leak root = |pressed|, without a difference of near numbers.
        let root = pressed.abs() / (leak + (leak * leak + pressed.abs()).sqrt()).max(f64::MIN_POSITIVE);
        self.pressure = root * root * pressed.signum();
        self.pressure
    }
}

/// A cylinder with a cushion: a check valve lets the piston go freely one way, the other way its air has to leave through an orifice
/// (Beater, Pneumatic Drives, 2007: cushions and dashpots).
pub(in crate::outside) struct OneWayCushion {
    level: f64,
    direction: f64,
    chamber: Chamber,
}

impl OneWayCushion {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], direction: v[3], chamber: Chamber::new(v[1], v[2]) }
    }
}

impl Hidden for OneWayCushion {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let pressure = self.chamber.after(self.direction * seen.speed, seen.step_s).max(0.0);
        self.chamber.pressure = pressure;
        -self.level * self.direction * pressure
    }
}

/// A hydraulic damper whose oil has air in it: an orifice behind a spring, stiff against quick ways and soft against slow ones (Dixon, The
/// Shock Absorber Handbook, 2007: compressible oil).
pub(in crate::outside) struct SoftDamper {
    level: f64,
    chamber: Chamber,
}

impl SoftDamper {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { level: v[0], chamber: Chamber::new(v[1], v[2]) }
    }
}

impl Hidden for SoftDamper {
    fn torque(&mut self, seen: &Seen) -> f64 {
        -self.level * self.chamber.after(seen.speed, seen.step_s)
    }
}

/// A drum with grains: they go up with it to a slope that is still stable, slide down to that of their repose, and go up again
/// (Rajchenbach, Phys. Rev. Lett. 65 (1990) 2221).
pub(in crate::outside) struct Avalanches {
    amplitude: f64,
    stable: f64,
    repose: f64,
    time_s: f64,
    slope: f64,
    slides: bool,
}

impl Avalanches {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { amplitude: v[0], stable: v[1], repose: v[2], time_s: v[3], slope: 0.0, slides: false }
    }
}

impl Hidden for Avalanches {
    fn torque(&mut self, seen: &Seen) -> f64 {
        self.slope += seen.step_s * seen.speed;
        let steep = self.slope.abs();
        self.slides = steep > if self.slides { self.repose } else { self.stable };
        if self.slides {
            self.slope -= seen.share_of_lag(self.time_s) * self.slope;
        }
        -self.amplitude * self.slope / self.stable
    }
}

/// Cargo that nobody lashed on a table that tilts: beyond an angle it slides to the lower side, pulls that way, and comes back only when the
/// table is tilted as far the other way (as in holds of ships: IMO, International Grain Code, 1991).
pub(in crate::outside) struct CargoSlides {
    amplitude: f64,
    angle: f64,
    time_s: f64,
    /// Where it lies, from -1 to 1.
    at: f64,
}

impl CargoSlides {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { amplitude: v[0], angle: v[1], time_s: v[2], at: 0.0 }
    }
}

impl Hidden for CargoSlides {
    fn torque(&mut self, seen: &Seen) -> f64 {
        let beyond = ((seen.position.abs() - self.angle) / self.angle).clamp(0.0, 1.0);
        self.at = (self.at + seen.position.signum() * beyond * seen.step_s / self.time_s).clamp(-1.0, 1.0);
        self.amplitude * self.at
    }
}
