//! Isolated samples of the position are wrong by a size.

use super::{Effect, PLAIN, Parameter, Size, searched};

/// More than a rounded sample and its neighbours are off by, and less than any travel.
const OFF: Parameter = Parameter { size: Size::Step, ..searched(4.0, 1e9) };

/// The entry of the vocabulary.
pub static EFFECT: Effect = Effect {
    id: "sensor_glitch",
    sentence: "Isolated position samples are wrong: disturbed transmission, a bit lost on the bus, a fault of the converter.",
    parameters: &[searched(1e-6, 0.2), OFF],
    starts: |p, e| {
        let least = OFF.low * OFF.size.of(p, e);
        e.glitch.iter().map(|&(fraction, size)| vec![fraction, size.max(least)]).collect()
    },
    put: |p, v| p.glitch = Some((v[0], v[1])),
    once: true,
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use plant::Model;

    use super::EFFECT;
    use crate::effects::Excitation;
    use crate::physics::Physics;

    #[test]
    fn starts_are_within_their_ranges_on_an_axis_that_turns_a_thousand_times() {
        let physics = Physics::new(Model::new(1e-4));
        for step in [6e-4, 0.0] {
            let glitch = Some((0.01, 2.5e-3));
            let excitation = Excitation { glitch, step, travel: 4e3, ..Excitation::default() };
            let ranges = EFFECT.ranges(2, &physics, &excitation);
            for values in (EFFECT.starts)(&physics, &excitation) {
                for (range, value) in ranges.iter().zip(values) {
                    assert!(range.low <= value && value <= range.high, "{value}, not within {range:?}");
                }
            }
        }
    }
}
