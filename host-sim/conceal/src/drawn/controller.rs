//! The generator's own controllers: what other people's machines are driven by, and what the machine file says nothing of.

use rand::Rng;
use rand::rngs::StdRng;

/// How the field is commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FieldRule {
    /// On and off: period, s, and level, kV/mm.
    Square(f64, f64),
    /// On near the reference: distance, rad or m, and level, kV/mm.
    Near(f64, f64),
    /// With the speed, up to a level: speed that gives it, and level, kV/mm.
    Speed(f64, f64),
}

/// State feedback of the measured position and its filtered difference, with or without an integral.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Controller {
    stiffness: f64,
    damping: f64,
    integral: f64,
    filter_s: f64,
    limit: f64,
    field: Option<FieldRule>,
}

/// What the controller remembers.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct State {
    position: f64,
    pub(crate) speed: f64,
    sum: f64,
}

impl FieldRule {
    pub(crate) fn draw(bandwidth_rad_s: f64, travel: f64, random: &mut StdRng) -> Self {
        let level = random.random_range(1.0..3.0);
        match random.random_range(0..3) {
            0 => Self::Square(random.random_range(4.0..20.0) / bandwidth_rad_s, level),
            1 => Self::Near(travel * random.random_range(0.05..0.3), level),
            _ => Self::Speed(travel * bandwidth_rad_s * random.random_range(0.2..1.0), level),
        }
    }

    fn at(self, t_s: f64, error: f64, speed: f64) -> f64 {
        match self {
            Self::Square(period_s, level) => {
                if (t_s / period_s).fract() < 0.5 {
                    0.0
                } else {
                    level
                }
            }
            Self::Near(within, level) => {
                if error.abs() < within {
                    level
                } else {
                    0.0
                }
            }
            Self::Speed(full, level) => level * (speed.abs() / full).min(1.0),
        }
    }
}

impl Controller {
    /// For an inertia and a bandwidth; torques held within a limit.
    pub(crate) fn draw(
        inertia: f64,
        bandwidth: f64,
        limit: f64,
        field: Option<FieldRule>,
        random: &mut StdRng,
    ) -> Self {
        let integral = if random.random_bool(0.4) { 0.15 * inertia * bandwidth.powi(3) } else { 0.0 };
        Self {
            stiffness: inertia * bandwidth * bandwidth,
            damping: inertia * bandwidth * random.random_range(1.2..2.0),
            integral,
            filter_s: 0.1 / bandwidth,
            limit,
            field,
        }
    }

    /// Torque and field after a reading.
    pub(crate) fn step(&self, state: &mut State, t_s: f64, period_s: f64, reference: f64, position: f64) -> (f64, f64) {
        let raw = (position - state.position) / period_s;
        state.position = position;
        state.speed += period_s / (period_s + self.filter_s) * (raw - state.speed);
        let error = reference - position;
        let torque = self.stiffness * error + self.integral * state.sum - self.damping * state.speed;
        // What is held at the limit is not summed up.
        if torque.abs() < self.limit {
            state.sum += period_s * error;
        }
        let field = self.field.map_or(0.0, |rule| rule.at(t_s, error, state.speed));
        (torque.clamp(-self.limit, self.limit), field)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn controllers_have_an_integral_in_two_of_five_and_each_rule_for_the_field_in_a_third() {
        let mut random = StdRng::seed_from_u64(1);
        let integrals =
            (0..400).filter(|_| Controller::draw(1.0, 30.0, 10.0, None, &mut random).integral > 0.0).count();
        let mut rules = [0; 3];
        for _ in 0..400 {
            match FieldRule::draw(30.0, 1.0, &mut random) {
                FieldRule::Square(..) => rules[0] += 1,
                FieldRule::Near(..) => rules[1] += 1,
                FieldRule::Speed(..) => rules[2] += 1,
            }
        }
        println!("{integrals} of 400 with an integral, rules {rules:?}");
        // Four deviations of a binomial draw: 39 and 38.
        assert!((121..=199).contains(&integrals) && rules.iter().all(|count| (95..=171).contains(count)));
    }
}
