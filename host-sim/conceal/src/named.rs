//! Effects of the vocabulary by the names that answers and machine files have for their parameters.

use crate::catalogue::find;
use crate::physics::Physics;

/// A parameter's name with the units of a linear axis (diagnosis.md).
pub(crate) fn on_linear_axis(name: &str) -> String {
    const UNITS: [(&str, &str); 8] = [
        ("_nm_s2_rad2", "_n_s2_m2"),
        ("_nm_s_rad", "_n_s_m"),
        ("_nm_rad", "_n_m"),
        ("_kg_m2", "_kg"),
        ("velocity_rad_s", "velocity_m_s"),
        ("gap_rad", "gap_m"),
        ("size_rad", "size_m"),
        ("order_per_rev", "order_per_m"),
    ];
    let unit = UNITS.iter().find(|(rotary, _)| name.ends_with(rotary));
    let replaced = unit.map(|(rotary, linear)| name.replace(rotary, linear));
    replaced.unwrap_or_else(|| if name.ends_with("_nm") { name.replace("_nm", "_n") } else { name.to_owned() })
}

/// Puts an effect of the vocabulary with the parameters of an answer or a machine file, named as on either kind of axis, into a
/// machine; false where the machine as numbers has no such effect, or a parameter is missing.
pub fn put_named(id: &str, parameters: &[(String, f64)], physics: &mut Physics) -> bool {
    let Some(entry) = find(id).filter(|entry| entry.in_vocabulary) else { return false };
    let value = |name: &&str| {
        let linear = on_linear_axis(name);
        parameters.iter().find(|(given, _)| given == name || *given == linear).map(|(_, value)| *value)
    };
    let values: Option<Vec<f64>> = entry.parameters().iter().map(value).collect();
    values.is_some_and(|values| {
        entry.put(physics, &values);
        true
    })
}
