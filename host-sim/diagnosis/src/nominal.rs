//! The nominal machine as the plant's model.

use plant::{Er, Model};
use recording::Machine;

use crate::physics::Physics;

impl Physics {
    /// The machine of a machine file, without its `[[effects]]`.
    pub fn nominal(machine: &Machine) -> Self {
        let plant = &machine.plant;
        Self::new(Model {
            coulomb: plant.coulomb,
            viscous: plant.viscous,
            torque_gain: plant.torque_gain,
            torque_offset: plant.torque_offset,
            torque_limit: plant.torque_limit,
            torque_delay_s: plant.torque_delay_s,
            er: plant.er.as_ref().map(|er| Er::new(er.a, er.b, er.dead_time_s, er.lag_s)),
            ..Model::new(plant.inertia)
        })
    }
}
