//! A machine as the text of a machine file.

use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::controller::controller_pairs;
use super::machine_file::SCHEMA;
use super::toml_section::Setting;
use super::{AxisKind, EffectEntry, ErFluid, Machine, MappedColumn, Mapping};

impl Machine {
    /// The text of a machine file that reads back as this machine, every number to the same bits.
    ///
    /// # Errors
    ///
    /// What TOML cannot express; nothing in a machine that was read from a file is.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string(&FileForm(self))
    }
}

/// The machine in the order of the file.
struct FileForm<'a>(&'a Machine);

impl Serialize for FileForm<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Machine { name, axis, plant, controller, columns, effects, file: _ } = self.0;
        let mut top = serializer.serialize_map(None)?;
        top.serialize_entry("schema", &SCHEMA)?;
        top.serialize_entry("name", name)?;
        let axis_keys = [("sample_period_s", axis.sample_period_s), ("resolution", axis.resolution)];
        top.serialize_entry("axis", &Keys { texts: &[("kind", axis.kind.name())], numbers: &axis_keys, below: None })?;
        let mut plant_keys = vec![
            ("inertia", plant.inertia),
            ("coulomb", plant.coulomb),
            ("viscous", plant.viscous),
            ("torque_gain", plant.torque_gain),
            ("torque_offset", plant.torque_offset),
            ("torque_delay_s", plant.torque_delay_s),
        ];
        if plant.sample_to_output_s > 0.0 {
            plant_keys.push(("sample_to_output_s", plant.sample_to_output_s));
        }
        plant_keys.extend(plant.torque_limit.map(|limit| ("torque_limit", limit)));
        let er = plant
            .er
            .as_ref()
            .map(|er| [("a", er.a), ("b", er.b), ("dead_time_s", er.dead_time_s), ("lag_s", er.lag_s)]);
        let fluid = plant.er.as_ref().and_then(|er| er.fluid.as_ref()).map(fluid_keys);
        let fluid = fluid.as_ref().map(|fluid| Keys { texts: &[], numbers: fluid, below: None });
        let er =
            er.as_ref().map(|er| Keys { texts: &[], numbers: er, below: fluid.as_ref().map(|keys| ("fluid", keys)) });
        let below = er.as_ref().map(|keys| ("er", keys));
        top.serialize_entry("plant", &Keys { texts: &[], numbers: &plant_keys, below })?;
        if let Some(controller) = controller {
            top.serialize_entry("controller", &Settings(&controller_pairs(controller)))?;
        }
        if !columns.is_empty() {
            top.serialize_entry("columns", &ColumnsForm(columns, axis.kind))?;
        }
        if !effects.is_empty() {
            top.serialize_entry("effects", &effects.iter().map(EffectForm).collect::<Vec<_>>())?;
        }
        top.end()
    }
}

/// The keys of `[plant.er.fluid]`.
fn fluid_keys(fluid: &ErFluid) -> Vec<(&'static str, f64)> {
    let mut keys = vec![
        ("consistency", fluid.consistency),
        ("consistency_per_kv_mm", fluid.consistency_per_kv_mm),
        ("flow_exponent", fluid.flow_exponent),
        ("rise_exponent", fluid.rise_exponent),
        ("fall_exponent", fluid.fall_exponent),
        ("above_reference_k", fluid.above_reference_k),
        ("yield_per_k", fluid.yield_per_k),
        ("viscosity_per_k", fluid.viscosity_per_k),
    ];
    if let Some(electrode) = fluid.electrode {
        keys.push(("electrode_capacitance_f", electrode.capacitance_f));
        keys.push(("amplifier_current_a", electrode.current_a));
        keys.push(("gap_m", electrode.gap_m));
    }
    keys
}

/// A section: texts, numbers, and at most one section below it.
struct Keys<'a> {
    texts: &'a [(&'a str, &'a str)],
    numbers: &'a [(&'a str, f64)],
    below: Option<(&'a str, &'a Keys<'a>)>,
}

impl Serialize for Keys<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut section = serializer.serialize_map(None)?;
        for (key, text) in self.texts {
            section.serialize_entry(key, text)?;
        }
        for (key, number) in self.numbers {
            section.serialize_entry(key, number)?;
        }
        if let Some((key, below)) = self.below {
            section.serialize_entry(key, below)?;
        }
        section.end()
    }
}

struct ColumnsForm<'a>(&'a Mapping, AxisKind);

impl Serialize for ColumnsForm<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut section = serializer.serialize_map(Some(self.0.columns().len()))?;
        for MappedColumn { column, name, unit, scale, wrap, .. } in self.0.columns() {
            let texts = [("name", name.as_str()), ("unit", unit.as_str())];
            let texts = if unit.is_empty() { &texts[..1] } else { &texts[..] };
            let scale = (!unit.is_empty()).then_some(("scale", *scale));
            let numbers: Vec<_> = scale.into_iter().chain(wrap.map(|wrap| ("wrap", wrap))).collect();
            section.serialize_entry(column.key(self.1), &Keys { texts, numbers: &numbers, below: None })?;
        }
        section.end()
    }
}

struct Settings<'a>(&'a [(&'static str, Setting)]);

impl Serialize for Settings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut section = serializer.serialize_map(Some(self.0.len()))?;
        for (key, setting) in self.0 {
            match setting {
                // The controller computes in single precision: the digits that tell one such number from the next.
                Setting::Number(number) => section.serialize_entry(key, &(*number as f32))?,
                Setting::Flag(flag) => section.serialize_entry(key, flag)?,
            }
        }
        section.end()
    }
}

struct EffectForm<'a>(&'a EffectEntry);

impl Serialize for EffectForm<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let EffectEntry { id, recording, parameters } = self.0;
        let mut section = serializer.serialize_map(None)?;
        section.serialize_entry("id", id)?;
        if let Some(recording) = recording {
            section.serialize_entry("recording", recording)?;
        }
        for (key, value) in parameters {
            section.serialize_entry(key, value)?;
        }
        section.end()
    }
}
