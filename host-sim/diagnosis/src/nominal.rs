//! The nominal machine as the plant's model.

use plant::{Er, Model};
use recording::{EffectEntry, Machine, vocabulary};

use crate::effects::{Effect, VOCABULARY};
use crate::physics::Physics;

impl Physics {
    /// The machine of a machine file with its `[[effects]]`; `recordings` are the names in the order they will be numbered.
    pub fn nominal(machine: &Machine, recordings: &[&str]) -> Self {
        let plant = &machine.plant;
        let mut physics = Self::new(Model {
            coulomb: plant.coulomb,
            viscous: plant.viscous,
            torque_gain: plant.torque_gain,
            torque_offset: plant.torque_offset,
            torque_limit: plant.torque_limit,
            torque_delay_s: plant.torque_delay_s,
            er: plant.er.as_ref().map(|er| Er::new(er.a, er.b, er.dead_time_s, er.lag_s)),
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
