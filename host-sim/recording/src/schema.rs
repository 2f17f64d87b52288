//! Every key of a machine file by its path, for the message about one that is not known.

use er_servo::parameters;

use crate::nearest::{likeness, quoted};
use crate::units;

/// Keys of a machine file but those of `[controller]`, which the control library names, and the parameters of effects.
const PATHS: &[&str] = &[
    "schema",
    "name",
    "axis",
    "axis.kind",
    "axis.sample_period_s",
    "axis.resolution",
    "plant",
    "plant.inertia",
    "plant.coulomb",
    "plant.viscous",
    "plant.torque_gain",
    "plant.torque_offset",
    "plant.torque_limit",
    "plant.sample_to_output_s",
    "plant.torque_delay_s",
    "plant.er",
    "plant.er.a",
    "plant.er.b",
    "plant.er.dead_time_s",
    "plant.er.lag_s",
    "plant.er.fluid",
    "plant.er.fluid.consistency",
    "plant.er.fluid.consistency_per_kv_mm",
    "plant.er.fluid.flow_exponent",
    "plant.er.fluid.rise_exponent",
    "plant.er.fluid.fall_exponent",
    "plant.er.fluid.above_reference_k",
    "plant.er.fluid.yield_per_k",
    "plant.er.fluid.viscosity_per_k",
    "plant.er.fluid.electrode_capacitance_f",
    "plant.er.fluid.amplifier_current_a",
    "plant.er.fluid.gap_m",
    "controller",
    "columns",
    "columns.time",
    "columns.position",
    "columns.torque",
    "columns.force",
    "columns.position.name",
    "columns.position.unit",
    "columns.position.scale",
    "columns.position.wrap",
    "effects",
    "effects.id",
    "effects.recording",
];

/// Other words for a key.
const SYNONYMS: &[(&str, &str)] = &[
    ("type", "effects.id"),
    ("type", "axis.kind"),
    ("mass", "plant.inertia"),
    ("moment_of_inertia", "plant.inertia"),
    ("j", "plant.inertia"),
    ("friction", "plant.coulomb"),
    ("damping", "plant.viscous"),
    ("delay_s", "plant.torque_delay_s"),
    ("max_torque", "plant.torque_limit"),
    ("dt", "axis.sample_period_s"),
    ("encoder", "axis.resolution"),
    ("version", "schema"),
    ("title", "name"),
    ("model", "plant"),
    ("control", "controller"),
];

/// At least this alike is a key of the same section,
const ALIKE_HERE: f64 = 0.5;
/// and of another: there are many.
const ALIKE_ELSEWHERE: f64 = 0.7;

/// What to say of `key` in the section called `section` (empty at the top, `plant.er`), which has the keys `known`: the nearest
/// key of the whole file, with its unit where that is another, or the keys of this section where none is near.
pub(crate) fn hint(section: &str, key: &str, known: &[&str]) -> String {
    let lower = key.to_lowercase();
    let here = best(&lower, known.iter().map(|key| (*key, *key)), ALIKE_HERE);
    let below = |path: &'static str| (path, path.rsplit('.').next().unwrap_or(path));
    let everywhere = PATHS.iter().copied().map(below);
    let elsewhere = || best(&lower, everywhere, ALIKE_ELSEWHERE).map(|(_, path)| path.to_owned());
    let controller = || {
        let known = parameters::TABLE.iter().find(|parameter| parameter.name == lower);
        known.map(|parameter| format!("controller.{}", parameter.name))
    };
    let certain_here = here.filter(|(score, _)| *score >= ALIKE_ELSEWHERE).map(|(_, key)| key.to_owned());
    let found = certain_here
        .or_else(|| synonym(section, &lower))
        .or_else(controller)
        .or_else(elsewhere)
        .or_else(|| here.map(|(_, key)| key.to_owned()));
    match found {
        Some(path) => {
            let unit = units::other_unit(key, path.rsplit('.').next().unwrap_or(&path));
            format!("the nearest key is `{path}`{unit}")
        }
        None => {
            let known: Vec<String> = known.iter().map(|key| quoted(key)).collect();
            format!("known here are {}", known.join(", "))
        }
    }
}

/// The candidate, given with the word it is found by, that resembles `key` most, if enough.
fn best<'a>(key: &str, candidates: impl Iterator<Item = (&'a str, &'a str)>, least: f64) -> Option<(f64, &'a str)> {
    let scored = candidates.map(|(path, word)| (likeness(key, word), path));
    scored.max_by(|one, other| one.0.total_cmp(&other.0)).filter(|(score, _)| *score >= least)
}

/// The key that another word is usual for, in this section if there is one.
fn synonym(section: &str, word: &str) -> Option<String> {
    let matching = || SYNONYMS.iter().filter(|(other, _)| *other == word).map(|(_, path)| *path);
    let here = matching().find(|path| path.rsplit_once('.').is_some_and(|(above, _)| above == section));
    let name_here = here.and_then(|path| path.rsplit('.').next());
    name_here.or_else(|| matching().next_back()).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_file_is_searched() {
        let top = ["schema", "name", "axis", "plant", "controller", "columns", "effects"];
        let plant = ["inertia", "coulomb", "torque_delay_s", "er"];
        for (section, key, known, message) in [
            ("", "inertia", &top[..], "the nearest key is `plant.inertia`"),
            ("", "plnt", &top, "the nearest key is `plant`"),
            ("", "kind", &top, "the nearest key is `axis.kind`"),
            ("", "sample_period_s", &top, "the nearest key is `axis.sample_period_s`"),
            ("", "kp_nm_rad", &top, "the nearest key is `controller.kp_nm_rad`"),
            ("axis", "type", &["kind", "sample_period_s", "resolution"], "the nearest key is `kind`"),
            ("effects", "type", &["id", "recording"], "the nearest key is `id`"),
            (
                "",
                "machine",
                &top,
                "known here are `schema`, `name`, `axis`, `plant`, `controller`, `columns`, `effects`",
            ),
            ("plant", "re", &plant, "the nearest key is `er`"),
            ("plant", "mass", &plant, "the nearest key is `inertia`"),
            (
                "plant",
                "torque_delay_ms",
                &plant,
                "the nearest key is `torque_delay_s`, in s: multiply the value by 0.001",
            ),
        ] {
            assert_eq!(hint(section, key, known), message, "{section}.{key}");
        }
    }
}
