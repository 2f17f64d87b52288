//! The nominal model as the text of a machine file.

use std::fmt::Write as _;

use er_servo::{Config, parameters};

use crate::recording::Resolution;
use crate::seal::Concealed;

/// Share by which a misleading machine file is off.
const OFF: f64 = 0.05;

/// What the machine file says where it can mislead; the default is the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Nominal {
    inertia_kg_m2: f64,
    torque_gain: f64,
    coulomb_nm: f64,
    er_share: f64,
    /// Dead time and lag of the field.
    field_s: [f64; 2],
}

impl Default for Nominal {
    fn default() -> Self {
        Self { inertia_kg_m2: 0.075, torque_gain: 1.0, coulomb_nm: 0.763, er_share: 1.0, field_s: [0.002, 0.003] }
    }
}

impl Nominal {
    /// Of a fluid that acts at once.
    pub(crate) fn at_once() -> Self {
        Self { field_s: [0.0; 2], ..Self::default() }
    }

    /// Puts one parameter 5 % off, up or down; gives the effect that sets it right.
    pub(crate) fn mislead(&mut self, id: &str, up: bool) -> Concealed {
        let by = if up { 1.0 + OFF } else { 1.0 - OFF };
        let (parameter, value) = match id {
            "inertia" => ("inertia_kg_m2", &mut self.inertia_kg_m2),
            "torque_gain" => ("gain", &mut self.torque_gain),
            "coulomb_friction" => ("coulomb_nm", &mut self.coulomb_nm),
            _ => ("scale", &mut self.er_share),
        };
        // The strength of the fluid is no key of the file: there the scale is what the machine has over it.
        let truth = if id == "er_strength" { 1.0 / by } else { *value };
        *value *= by;
        let parameters = vec![(parameter.to_owned(), truth)];
        Concealed { id: id.to_owned(), in_vocabulary: true, size: OFF, strength: OFF, parameters }
    }
}

/// The file's text.
pub(crate) fn text(nominal: &Nominal, resolution: Resolution, controller: bool) -> String {
    let Nominal { inertia_kg_m2, torque_gain, coulomb_nm, er_share, field_s: [dead_time_s, lag_s] } = nominal;
    let (a, b) = (0.0704 * er_share, 0.470 * er_share);
    let mut text = format!(
        "schema = 1\nname = \"er-dd-servo\"\n\n[axis]\nkind = \"rotary\"\nsample_period_s = 0.0005\nresolution = {:?}\n\n\
         [plant]\ninertia = {inertia_kg_m2:?}\ncoulomb = {coulomb_nm:?}\nviscous = 0.0\ntorque_gain = {torque_gain:?}\n\
         torque_offset = 0.0\ntorque_limit = 30.0\ntorque_delay_s = 0.005\n\n\
         [plant.er]\na = {a:?}\nb = {b:?}\ndead_time_s = {dead_time_s:?}\nlag_s = {lag_s:?}\n",
        resolution.step_rad()
    );
    if controller {
        text += "\n[controller]\n";
        for parameter in parameters::TABLE {
            let value = (parameter.get)(&Config::default());
            let _ = match parameter.unit {
                "flag" => writeln!(text, "{} = {}", parameter.name, value != 0.0),
                _ => writeln!(text, "{} = {value:?}", parameter.name),
            };
        }
    }
    text
}
