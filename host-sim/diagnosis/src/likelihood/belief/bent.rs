//! The torque of a load's shaft over a substep, with a gap or without.

use plant::laws::ShaftLaw;

use crate::likelihood::gaussian::beyond;

/// Mean torque of the shaft on the motor over a substep, were its speed to stay, and how it changes.
#[derive(Default)]
pub(super) struct Bent {
    pub(super) torque: f64,
    /// Over the twist at the start.
    pub(super) per_twist: f64,
    /// Over the twist's rate at the start.
    pub(super) per_rate: f64,
    /// What the motor's change of speed takes from it: the damper feels the mean of the rates at both ends.
    pub(super) per_change: f64,
}

impl Bent {
    /// Of a twist and its rate, over a substep, with a twist that spreads by `sd`.
    pub(super) fn new(law: &ShaftLaw, twist: f64, rate: f64, dt_s: f64, sd: f64) -> Self {
        let half_s = 0.5 * dt_s;
        // With this stiffness the step of Verlet turns motor and load against each other at just the shaft's own resonance
        // (Hochbruck and Lubich, Numer. Math. 83 (1999) 403, the filter sinc^2); beyond two substeps a period, at that.
        let per_inertia = law.motor_inertia.recip() + law.per_load_inertia;
        let angle = (half_s * (law.stiffness * per_inertia).sqrt()).min(std::f64::consts::FRAC_PI_2);
        let sinc = if angle > 1e-4 { angle.sin() / angle } else { 1.0 };
        let stiffness = law.stiffness * sinc * sinc;
        let middle = twist + half_s * rate;
        let (torque, slope) = if law.half_gap > 0.0 {
            in_gap(law, stiffness, middle, rate, sd)
        } else {
            (stiffness * middle + law.damping * rate, 1.0)
        };
        let damping = law.damping * slope;
        let share = (1.0 + half_s * damping * law.per_load_inertia).recip();
        Self {
            torque: share * torque,
            per_twist: share * stiffness * slope,
            per_rate: share * (stiffness * slope * half_s + damping),
            per_change: share * 0.5 * damping,
        }
    }
}

/// Torque of a shaft behind a gap, and the probability of contact. Teeth push and do not pull: on the way out of a contact its damper
/// takes from the spring's push till none is left.
#[inline]
fn in_gap(law: &ShaftLaw, stiffness: f64, twist: f64, rate: f64, sd: f64) -> (f64, f64) {
    let sign = rate.signum();
    let onto = beyond(sign * twist - law.half_gap, sd);
    let out_of = beyond(-sign * twist - law.half_gap - law.damping / stiffness * rate.abs(), sd);
    let spring = stiffness * sign * (onto.0 - out_of.0);
    (spring + law.damping * rate * onto.1, onto.1 + out_of.1)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use plant::effects::Shaft;
    use plant::laws::ShaftLaw;

    use super::Bent;

    #[test]
    fn teeth_push_and_do_not_pull() {
        let shaft = Shaft { resonance_hz: 50.0, damping_ratio: 0.1, inertia_ratio: 0.5, gap: 0.02 };
        let law = ShaftLaw::new(&shaft, 0.1).unwrap();
        // Over next to no time, known for certain: the law itself.
        let torque = |twist: f64, rate: f64| Bent::new(&law, twist, rate, 1e-9, 1e-12).torque;
        for sign in [1.0, -1.0] {
            for (bent, rate) in
                [(0.002, 0.5), (0.002, -0.1), (0.002, -0.9), (0.002, -5.0), (-0.001, 0.5), (-0.001, -5.0)]
            {
                let push = law.stiffness * bent + law.damping * rate;
                let expected = if bent > 0.0 && push > 0.0 { push } else { 0.0 };
                let found = sign * torque(sign * (law.half_gap + bent), sign * rate);
                assert!(
                    (found - expected).abs() < 1e-5 * law.stiffness * 0.002,
                    "{bent} {rate}: {found}, not {expected}"
                );
            }
        }
    }
}
