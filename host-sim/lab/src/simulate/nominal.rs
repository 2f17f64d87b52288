//! The nominal model of a machine file as physics.

use plant::{Er, Model};

use crate::read::Machine;

/// The machine's own model, without its `[[effects]]`.
pub fn nominal(machine: &Machine) -> Model {
    let plant = &machine.plant;
    Model {
        coulomb: plant.coulomb,
        viscous: plant.viscous,
        torque_gain: plant.torque_gain,
        torque_offset: plant.torque_offset,
        torque_limit: plant.torque_limit,
        torque_delay_s: plant.torque_delay_s,
        er: plant.er.as_ref().map(|er| Er::new(er.a, er.b, er.dead_time_s, er.lag_s)),
        ..Model::new(plant.inertia)
    }
}
