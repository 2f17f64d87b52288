//! The nominal machine as the plant's model.

use plant::{Er, Model};
use recording::{EffectEntry, Machine, vocabulary};

use crate::effects::{Effect, VOCABULARY};
use crate::physics::Physics;

impl Physics {
    /// The machine of a machine file with its `[[effects]]`; `recordings` are the names in the order they will be numbered.
    pub fn nominal(machine: &Machine, recordings: &[&str]) -> Self {
        let plant = &machine.plant;
        let to_output_s = plant.sample_to_output_s;
        let mut physics = Self::new(Model {
            coulomb: plant.coulomb,
            viscous: plant.viscous,
            torque_gain: plant.torque_gain,
            torque_offset: plant.torque_offset,
            torque_limit: plant.torque_limit,
            torque_delay_s: plant.torque_delay_from_sample_s(),
            er: plant.er.as_ref().map(|er| Er::new(er.a, er.b, to_output_s + er.dead_time_s, er.lag_s)),
            ..Model::new(plant.inertia)
        });
        for entry in &machine.effects {
            let effect = VOCABULARY.iter().find(|effect| effect.id == entry.id);
            if let Some((effect, values)) =
                effect.and_then(|effect| Some((effect, values(machine, effect, entry, recordings)?)))
            {
                (effect.put)(&mut physics, &values);
            }
        }
        physics
    }
}

/// Fitted values of an entry of the file; none for what belongs to no recording here.
fn values(machine: &Machine, effect: &Effect, entry: &EffectEntry, recordings: &[&str]) -> Option<Vec<f64>> {
    let value = |id: &str| entry.parameters.iter().find(|(name, _)| name == id).map(|(_, value)| *value);
    let kinds = vocabulary::effect(&entry.id)?.parameters;
    let reported: Option<Vec<f64>> = kinds.iter().map(|kind| value(kind.id(machine.axis.kind))).collect();
    let recording = match &entry.recording {
        Some(name) => Some(recordings.iter().position(|other| other == name)?),
        None => None,
    };
    (effect.fitted)(&reported?, recording)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn delays_of_the_file_count_from_the_outputs_and_those_of_the_plant_from_the_sample() {
        let text = "schema = 1\nname = \"drive\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\nresolution = 1e-5\n\
                    [plant]\ninertia = 0.075\nsample_to_output_s = 1e-5\ntorque_delay_s = 0.005\n\
                    [plant.er]\na = 0.07\nb = 0.47\ndead_time_s = 0.002\n";
        let machine = Machine::from_bytes(std::path::Path::new("m.toml"), text.as_bytes()).unwrap();
        let physics = Physics::nominal(&machine, &[]);
        assert_eq!(physics.model.torque_delay_s, 0.005_01);
        assert_eq!(physics.field().unwrap().dead_time_s, 0.002_01);
    }
}
