//! What a window starts from.

use nalgebra::DVector;
use plant::{Model, State};

/// A difference quotient of the rotor's start is over this share of the way in the window,
const ASIDE: f64 = 1e-3;
/// of at least this much, rad (m);
const LEAST_TRAVEL: f64 = 1e-5;
/// and that of a state which no sensor shows over what may move the rotor by this, rad (m): a gap is small.
const HIDDEN_ASIDE: f64 = 1e-6;
/// A speed that moves the rotor by less than this share of what a free rotor would go is not told by the window,
const NO_SPEED: f64 = 1e-6;
/// and likewise a state which no sensor shows: a load that does not touch, a bristle that yields at once.
const NO_HIDDEN: f64 = 1e-3;

/// The start state of a window as unknowns, in this order: position and speed of the rotor, and of what the machine has
/// inside, the load's twist and the rate of that, the torque of the dry bristle, the torque of the fluid's spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unknowns {
    /// Which of the four the machine has inside.
    has: [bool; 4],
    /// Free play of the load, rad (m).
    gap: f64,
    inertia: f64,
}

impl Unknowns {
    /// Of a machine.
    pub(super) fn of(model: &Model) -> Self {
        let shaft = model.shaft.filter(|shaft| shaft.inertia_ratio > 0.0);
        let (load, bristle) = (shaft.is_some(), model.presliding_stiffness.is_some());
        let spring = model.er.as_ref().is_some_and(|er| er.preyield_stiffness.is_some());
        Self { has: [load, load, bristle, spring], gap: shaft.map_or(0.0, |shaft| shaft.gap), inertia: model.inertia }
    }

    /// Of four things, those that belong to what the machine has inside.
    fn held<T>(&self, all: [T; 4]) -> impl Iterator<Item = T> {
        all.into_iter().zip(self.has).filter_map(|(each, has)| has.then_some(each))
    }

    /// The unknowns of a rotor with this position and speed, and what is `inside` a state.
    pub(super) fn pack(&self, rotor: [f64; 2], inside: &State) -> DVector<f64> {
        let inside = [inside.twist, inside.twist_rate, inside.bristle_torque, inside.spring_torque];
        DVector::from_vec(rotor.into_iter().chain(self.held(inside)).collect())
    }

    /// The state that has the values of the unknowns.
    pub(super) fn unpack(&self, values: &DVector<f64>) -> State {
        let mut state = State::new(values[0], values[1]);
        let State { twist, twist_rate, bristle_torque, spring_torque, .. } = &mut state;
        let inside = self.held([twist, twist_rate, bristle_torque, spring_torque]);
        inside.zip(values.iter().skip(2)).for_each(|(value, found)| *value = *found);
        state
    }

    /// The unknowns of a rotor beside a load that touches either end of its gap; none without one.
    pub(super) fn touching(&self, rotor: [f64; 2], inside: State) -> Vec<DVector<f64>> {
        let at = |twist| {
            let mut inside = inside;
            inside.twist = twist;
            self.pack(rotor, &inside)
        };
        if self.gap > 0.0 { vec![at(0.5 * self.gap), at(-0.5 * self.gap)] } else { Vec::new() }
    }

    /// Of each unknown, how much of it moves a free rotor by 1 rad (m) until the end of a window.
    fn units(&self, span_s: f64) -> impl Iterator<Item = f64> {
        let (rate, torque) = (span_s.recip(), 2.0 * self.inertia / (span_s * span_s));
        [1.0, rate].into_iter().chain(self.held([1.0, rate, torque, torque]))
    }

    /// Steps of the difference quotients, for a window of `span_s` over a way of `travel`, rad (m), that starts with `speed`,
    /// rad/s (m/s).
    pub(super) fn steps(&self, span_s: f64, travel: f64, speed: f64) -> Vec<f64> {
        let way = ASIDE * travel.max(speed.abs() * span_s).max(LEAST_TRAVEL);
        let units = self.units(span_s).enumerate();
        units.map(|(place, unit)| unit * if place < 2 { way } else { way.min(HIDDEN_ASIDE) }).collect()
    }

    /// What is added to the squares of the derivatives by each unknown, where those by the position have the sum `square`:
    /// an unknown that makes no difference stays where it is.
    pub(super) fn stays(&self, span_s: f64, square: f64) -> Vec<f64> {
        let units = self.units(span_s).enumerate();
        let nothing = |place: usize| [0.0, NO_SPEED].get(place).copied().unwrap_or(NO_HIDDEN);
        units.map(|(place, unit)| square * (nothing(place) / unit).powi(2)).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use plant::effects::Shaft;

    use super::*;

    #[test]
    fn a_state_goes_through_the_unknowns_of_a_machine_that_has_it() {
        let shaft = Shaft { resonance_hz: 40.0, damping_ratio: 0.03, inertia_ratio: 0.4, gap: 0.0 };
        let mut state = State::new(1.0, 2.0);
        (state.twist, state.twist_rate) = (3.0, 4.0);
        let through = |unknowns: Unknowns, state: &State| unknowns.unpack(&unknowns.pack([1.0, 2.0], state));
        let rigid = Unknowns::of(&Model::new(0.1));
        assert_eq!(through(rigid, &state), State::new(1.0, 2.0));
        let loaded = Unknowns::of(&Model { shaft: Some(shaft), presliding_stiffness: Some(9.0), ..Model::new(0.1) });
        state.bristle_torque = 5.0;
        assert_eq!(through(loaded, &state), state);
        let all = Unknowns { has: [true; 4], gap: 0.5, inertia: 0.1 };
        state.spring_torque = 6.0;
        assert_eq!(through(all, &state), state);
        let sides = all.touching([1.0, 2.0], state);
        assert_eq!(sides.iter().map(|side| (side[2], side[3])).collect::<Vec<_>>(), [(0.25, 4.0), (-0.25, 4.0)]);
        assert!(loaded.touching([1.0, 2.0], state).is_empty());
        for unknowns in [rigid, all, loaded] {
            let count = unknowns.pack([1.0, 2.0], &state).len();
            assert_eq!(unknowns.steps(0.05, 0.0, 0.0).len(), count);
            assert!(unknowns.steps(0.05, 0.0, 0.0).iter().all(|step| *step > 0.0));
            assert_eq!(unknowns.stays(0.05, 1.0).len(), count);
        }
    }
}
