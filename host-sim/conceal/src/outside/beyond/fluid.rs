//! A damper whose particles move, whose chains go with the strain, and whose electrodes hold a charge.

use super::super::{Hidden, Seen};
use super::TwoStates;

/// A share that comes at one rate and goes at another, 1/s, after a step; implicit, for a motion may be fast.
fn balance(share: f64, comes: f64, goes: f64, step_s: f64) -> f64 {
    (share + step_s * comes) / (1.0 + step_s * (comes + goes))
}

/// Particles with a charge that a steady field draws to one electrode, and that shear stirs up again (Block and Kelly, J. Phys. D 21 (1988)
/// 1661: electrophoresis in such fluids). What is nominal is half of that; share, time, way, field.
pub(in crate::outside) struct Electrophoresis {
    share: f64,
    time_s: f64,
    way: f64,
    full_kv_mm: f64,
    field_kv_mm: f64,
    drawn: f64,
}

impl Electrophoresis {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        let [share, time_s, way, full_kv_mm] = [v[0], v[1], v[2], v[3]];
        Self { share, time_s, way, full_kv_mm, field_kv_mm: 0.0, drawn: 0.5 }
    }
}

impl Hidden for Electrophoresis {
    fn field(&mut self, field_kv_mm: f64) -> f64 {
        self.field_kv_mm = field_kv_mm;
        field_kv_mm
    }

    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let comes = self.field_kv_mm / self.full_kv_mm.max(1e-6) / self.time_s;
        self.drawn = balance(self.drawn, comes, seen.speed.abs() / self.way, seen.step_s);
        level * (1.0 + self.share * (0.5 - self.drawn))
    }
}

/// Particles heavier than their oil that the speed throws out of the gap, and that come back in a time (Svedberg and Pedersen, The
/// Ultracentrifuge, 1940: sedimentation in rotors). What is nominal is half of that; share, speed, time.
pub(in crate::outside) struct SpunOut {
    share: f64,
    speed: f64,
    time_s: f64,
    out: f64,
}

impl SpunOut {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], speed: v[1], time_s: v[2], out: 0.5 }
    }
}

impl Hidden for SpunOut {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let comes = (seen.speed / self.speed).powi(2) / self.time_s;
        self.out = balance(self.out, comes, 1.0 / self.time_s, seen.step_s);
        level * (1.0 + self.share * (0.5 - self.out))
    }
}

/// Chains that need strain to carry: after the field rises the stress builds up over a way of shear, not over a time; when the field falls
/// they let go at once (Parthasarathy and Klingenberg, Mater. Sci. Eng. R 17 (1996) 57: transients under shear).
pub(in crate::outside) struct StrainBuilds {
    way: f64,
    creep: f64,
    carries: f64,
}

impl StrainBuilds {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { way: v[0], creep: v[1], carries: 0.0 }
    }
}

/// Share of the way to a new stress after a step of shear; a speed stands in for what builds up at rest.
fn over_strain(seen: &Seen, way: f64, creep: f64) -> f64 {
    -(-seen.step_s * (seen.speed.abs() + creep) / way).exp_m1()
}

impl Hidden for StrainBuilds {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        self.carries += over_strain(seen, self.way, self.creep) * (level - self.carries);
        self.carries = self.carries.min(level);
        self.carries
    }
}

/// Chains that outlast their field: it lets them go, but they hold together until shear has torn them (Parthasarathy and Klingenberg, as
/// above).
pub(in crate::outside) struct Outlast {
    way: f64,
    creep: f64,
    carries: f64,
}

impl Outlast {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { way: v[0], creep: v[1], carries: 0.0 }
    }
}

impl Hidden for Outlast {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        self.carries += over_strain(seen, self.way, self.creep) * (level - self.carries);
        self.carries = self.carries.max(level);
        self.carries
    }
}

/// Rings of particles along the shear: they form while field and shear act together, carry more than chains, and fall apart without a field
/// (Henley and Filisko, J. Rheol. 43 (1999) 1323).
pub(in crate::outside) struct Rings {
    share: f64,
    way: f64,
    time_s: f64,
    half_level: f64,
    formed: f64,
}

impl Rings {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], way: v[1], time_s: v[2], half_level: v[3], formed: 0.0 }
    }
}

impl Hidden for Rings {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let on = level / (level + self.half_level);
        self.formed = balance(self.formed, on * seen.speed.abs() / self.way, (1.0 - on) / self.time_s, seen.step_s);
        level * (1.0 + self.share * self.formed)
    }
}

/// Electrodes whose capacity goes with the angle: their charge is that of the supply only after a time, so that turning pumps the voltage up
/// and down (Smythe, Static and Dynamic Electricity, 1968: electrodes that move); share, order, phase, time.
pub(in crate::outside) struct ChargePumped {
    share: f64,
    order: f64,
    phase: f64,
    time_s: f64,
    charge: f64,
}

impl ChargePumped {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], order: v[1], phase: v[2], time_s: v[3], charge: 1.0 + v[0] * v[2].sin() }
    }
}

impl Hidden for ChargePumped {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        let capacity = 1.0 + self.share * (self.order * seen.position + self.phase).sin();
        self.charge += seen.share_of_lag(self.time_s) * (capacity - self.charge);
        level * self.charge / capacity
    }
}

/// Fluid that loses its hold on a smooth electrode beyond a speed, and takes hold again only at a much lower one (Barnes, J. Non-Newtonian
/// Fluid Mech. 56 (1995) 221: slip at walls). What is nominal is the mean of both.
pub(in crate::outside) struct WallSlip {
    share: f64,
    slips: TwoStates,
}

impl WallSlip {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], slips: TwoStates::new(v[1], 0.05, v[2]) }
    }
}

impl Hidden for WallSlip {
    fn drag(&mut self, seen: &Seen, level: f64) -> f64 {
        level * (1.0 + self.share * (0.5 - self.slips.after(seen)))
    }
}
