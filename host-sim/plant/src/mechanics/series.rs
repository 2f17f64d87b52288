//! One step of a motor and a load behind a shaft where everything else has a closed form: their power series.
//!
//! Between events such a machine is linear with constant coefficients, and what drives it is a constant and exponentials.
//! Each term of the series of its solution follows from the one before, so a step costs a dozen short products and no
//! iteration, whatever the shaft. (The eigenvalues would end in a closed form that loses all digits wherever two of them
//! meet: without damping, without viscous friction, in the gap.)

use super::state::{Motion, State};
use crate::effects::shaft::{Contact, ShaftLaw};

/// Largest product of rate and step for which the series is used: its terms then never grow.
pub(super) const MOST_PHASE: f64 = 1.0;
/// One over the whole numbers, for as many terms as leave nothing at that phase: 1/22! is 1e-21.
const INVERSES: [f64; 23] = {
    let mut inverses = [0.0; 23];
    let mut n = 1;
    while n < inverses.len() {
        inverses[n] = 1.0 / n as f64;
        n += 1;
    }
    inverses
};
/// Size of a term, over the sum so far, at which the series ends; the next one is smaller still.
const LAST: f64 = 1e-18;

/// Torque on the motor other than that of shaft and viscous friction, N m, from the start of the step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    /// What stays.
    pub(super) constant: f64,
    /// What decays: how much at the start, and the rate, 1/s.
    pub(super) decays: [(f64, f64); 3],
}

impl Push {
    /// Whether each decay is slow enough over a step of `h`.
    pub(super) fn is_smooth(&self, h: f64) -> bool {
        self.decays.iter().all(|(amplitude, rate)| *amplitude == 0.0 || rate * h <= MOST_PHASE)
    }
}

/// State `h` seconds after `x`, all in one motion and one contact, with a viscous coefficient, N m s/rad, on the motor.
pub(super) fn step(shaft: &ShaftLaw, per_motor_inertia: f64, push: &Push, viscous: f64, x: &State, h: f64) -> State {
    let (stiffness, damping) = if x.contact == Contact::Free { (0.0, 0.0) } else { (shaft.stiffness, shaft.damping) };
    let per_motor_inertia = if x.motion == Motion::Stuck { 0.0 } else { per_motor_inertia };
    let (mut position, mut velocity, mut twist, mut twist_rate) = (x.position, x.velocity, x.twist, x.twist_rate);
    // The term of each series, with its power of h.
    let (mut v, mut rate) = (x.velocity, x.twist_rate);
    let mut through = shaft.torque(x.contact, x.twist, x.twist_rate);
    let mut decays = push.decays;
    let mut drive = push.constant + decays.iter().map(|decay| decay.0).sum::<f64>();
    for inverse in &INVERSES[1..] {
        let over = h * inverse;
        let motor = (drive - viscous * v + through) * per_motor_inertia;
        let apart = -through * shaft.per_load_inertia - motor;
        position += over * v;
        let bend = over * rate;
        (v, rate) = (over * motor, over * apart);
        twist += bend;
        velocity += v;
        twist_rate += rate;
        through = stiffness * bend + damping * rate;
        drive = 0.0;
        for (amplitude, decay) in &mut decays {
            *amplitude *= -*decay * over;
            drive += *amplitude;
        }
        let small = |term: f64, sum: f64| term.abs() <= LAST * sum.abs();
        if small(v, velocity)
            && small(rate, twist_rate)
            && small(bend, twist)
            && drive.abs() <= LAST * push.constant.abs()
        {
            break;
        }
    }
    State { position, velocity, twist, twist_rate, ..*x }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::effects::Shaft;

    const NO_PUSH: Push = Push { constant: 0.0, decays: [(0.0, 0.0); 3] };

    fn shaft(damping_ratio: f64) -> ShaftLaw {
        let shaft = Shaft { resonance_hz: 100.0, damping_ratio, inertia_ratio: 0.5, gap: 0.0 };
        ShaftLaw::new(&shaft, 0.075).unwrap()
    }

    /// A motor that is held, a motor that is pushed in the gap, and both bodies along: each has a formula.
    #[test]
    fn the_series_is_the_closed_form() {
        let (shaft, motor) = (shaft(0.0), shaft(0.0).motor_inertia);
        let held = State { twist: 1e-3, ..State::default() };
        let omega = (shaft.stiffness * shaft.per_load_inertia).sqrt();
        let h = 0.9 / omega;
        let swung = step(&shaft, motor.recip(), &NO_PUSH, 0.0, &held, h);
        assert!((swung.twist - 1e-3 * 0.9_f64.cos()).abs() < 1e-18, "{swung:?}");
        assert!((swung.twist_rate + 1e-3 * omega * 0.9_f64.sin()).abs() < 1e-15 * omega, "{swung:?}");
        assert_eq!((swung.position, swung.velocity), (0.0, 0.0));

        let push = Push { constant: 2.0, decays: [(3.0, 400.0), (0.0, 0.0), (-1.0, 800.0)] };
        let free = State { contact: Contact::Free, ..State::new(0.0, 1.0) };
        let pushed = step(&shaft, motor.recip(), &push, 0.0, &free, 1e-3);
        let gained = (2e-3 + 3.0 * (1.0 - (-0.4_f64).exp()) / 400.0 - (1.0 - (-0.8_f64).exp()) / 800.0) / motor;
        assert!((pushed.velocity - 1.0 - gained).abs() < 1e-14, "{pushed:?}");
        assert!((pushed.twist_rate + gained).abs() < 1e-14, "the load stays behind: {pushed:?}");
    }

    /// Two steps of half the length are one, damped and with viscous friction; shaft and push change no momentum but their own.
    #[test]
    fn a_step_is_two_halves_and_keeps_the_momentum() {
        let shaft = shaft(0.03);
        let push = Push { constant: 2.0, decays: [(3.0, 400.0), (0.0, 0.0), (0.0, 0.0)] };
        let x = State { twist: 1e-3, twist_rate: 0.2, ..State::new(0.3, 1.0) };
        let h = 0.5 / 628.0;
        let to = |push: &Push, viscous: f64, x: &State, h: f64| {
            step(&shaft, shaft.motor_inertia.recip(), push, viscous, x, h)
        };
        let whole = to(&push, 0.5, &x, h);
        let later = Push { decays: push.decays.map(|(size, rate)| (size * (-0.5 * rate * h).exp(), rate)), ..push };
        let halves = to(&later, 0.5, &to(&push, 0.5, &x, 0.5 * h), 0.5 * h);
        for (one, two) in [(whole.position, halves.position), (whole.velocity, halves.velocity)] {
            assert!((one - two).abs() < 1e-14, "{whole:?} {halves:?}");
        }
        assert!((whole.twist - halves.twist).abs() < 1e-17 && (whole.twist_rate - halves.twist_rate).abs() < 1e-14);
        let momentum =
            |x: &State| shaft.motor_inertia * x.velocity + (x.velocity + x.twist_rate) / shaft.per_load_inertia;
        let driven = to(&push, 0.0, &x, h);
        let given = 2.0 * h + 3.0 * (1.0 - (-400.0 * h).exp()) / 400.0;
        assert!((momentum(&driven) - momentum(&x) - given).abs() < 1e-15, "{driven:?}");
    }
}
