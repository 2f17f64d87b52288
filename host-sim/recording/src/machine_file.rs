//! Machine files, read and written.

use std::path::Path;

use super::controller::controller_config;
use super::nearest::{misspelt, quoted};
use super::toml_section::{Section, Source};
use super::vocabulary::{self, Allowed, EffectKind, Occurs};
use super::{Axis, AxisKind, EffectEntry, ErElectrode, ErFluid, ErNominal, Machine, Mapping, PlantNominal};
use crate::Error;

/// The version of the format this tool reads and writes.
pub(super) const SCHEMA: u8 = 1;

/// Longest delay of the drive or of the field, s.
const DELAY: Allowed = Allowed::Between(0.0, 1.0);

impl Machine {
    /// Reads a machine file.
    ///
    /// # Errors
    ///
    /// [`Error::Input`] with file, line and key for whatever is not as the format says.
    pub fn read(file: &Path) -> Result<Self, Error> {
        let bytes =
            std::fs::read(file).map_err(|error| Error::input(file, None, "", format!("cannot open: {error}")))?;
        Self::from_bytes(file, &bytes)
    }

    /// Reads a machine file from its bytes; `file` names it in messages.
    ///
    /// # Errors
    ///
    /// As [`Machine::read`].
    pub fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Self, Error> {
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count() as u64;
            Error::input(file, Some(line), "", "is not UTF-8 text")
        })?;
        // Editors on Windows put a byte order mark first.
        let source = Source { file, text: text.strip_prefix('\u{feff}').unwrap_or(text) };
        let document = source.parse()?;
        let top = Section::top(source, &document);
        top.only(&["schema", "name", "axis", "plant", "controller", "columns", "effects"])?;
        top.required_number("schema", Allowed::Between(f64::from(SCHEMA), f64::from(SCHEMA)))?;
        let (name, _) = top.required_text("name", "a name in quotes")?;
        let axis = axis(&top.required_section("axis")?)?;
        let plant = plant(&top.required_section("plant")?)?;
        let controller =
            top.section("controller")?.map(|section| controller_config(&section, &section.pairs()?)).transpose()?;
        let columns =
            top.section("columns")?.map(|section| Mapping::read(&section, axis.kind)).transpose()?.unwrap_or_default();
        let effects = effects(&top.sections("effects")?, axis.kind)?;
        Ok(Self { file: file.to_path_buf(), name: name.to_owned(), axis, plant, controller, columns, effects })
    }
}

fn axis(section: &Section<'_, '_>) -> Result<Axis, Error> {
    section.only(&["kind", "sample_period_s", "resolution"])?;
    let allowed = "\"rotary\" or \"linear\"";
    let kind = match section.required_text("kind", allowed)? {
        ("rotary", _) => AxisKind::Rotary,
        ("linear", _) => AxisKind::Linear,
        (other, span) => {
            let message = format!("{} is not allowed; must be {allowed}", quoted(other));
            return Err(section.error(&span, "kind", message));
        }
    };
    Ok(Axis {
        kind,
        sample_period_s: section.required_number("sample_period_s", Allowed::AboveZeroUpTo(1.0))?,
        resolution: section.required_number("resolution", Allowed::AtLeastZero)?,
    })
}

fn plant(section: &Section<'_, '_>) -> Result<PlantNominal, Error> {
    section.only(&[
        "inertia",
        "coulomb",
        "viscous",
        "torque_gain",
        "torque_offset",
        "torque_limit",
        "sample_to_output_s",
        "torque_delay_s",
        "er",
    ])?;
    let or = |key, allowed, default| Ok::<_, Error>(section.number(key, allowed)?.unwrap_or(default));
    Ok(PlantNominal {
        inertia: section.required_number("inertia", Allowed::AboveZero)?,
        coulomb: or("coulomb", Allowed::AtLeastZero, 0.0)?,
        viscous: or("viscous", Allowed::AtLeastZero, 0.0)?,
        torque_gain: or("torque_gain", Allowed::AboveZero, 1.0)?,
        torque_offset: or("torque_offset", Allowed::Finite, 0.0)?,
        torque_limit: section.number("torque_limit", Allowed::AboveZero)?,
        sample_to_output_s: or("sample_to_output_s", DELAY, 0.0)?,
        torque_delay_s: or("torque_delay_s", DELAY, 0.0)?,
        er: section.section("er")?.map(|section| er(&section)).transpose()?,
    })
}

fn er(section: &Section<'_, '_>) -> Result<ErNominal, Error> {
    section.only(&["a", "b", "dead_time_s", "lag_s", "fluid"])?;
    let or_zero = |key, allowed| Ok::<_, Error>(section.number(key, allowed)?.unwrap_or(0.0));
    Ok(ErNominal {
        a: or_zero("a", Allowed::AtLeastZero)?,
        b: or_zero("b", Allowed::AtLeastZero)?,
        dead_time_s: or_zero("dead_time_s", DELAY)?,
        lag_s: or_zero("lag_s", DELAY)?,
        fluid: section.section("fluid")?.map(|section| fluid(&section)).transpose()?,
    })
}

/// Powers of the field in a time constant, and the relative change of a property by a kelvin: a factor of e is more than any has.
const POWER: Allowed = Allowed::Between(0.0, 2.0);
const PER_K: Allowed = Allowed::Between(-1.0, 1.0);
/// Further from its reference no liquid stays one, K.
const WARMER: Allowed = Allowed::Between(-200.0, 200.0);

fn fluid(section: &Section<'_, '_>) -> Result<ErFluid, Error> {
    section.only(&[
        "consistency",
        "consistency_per_kv_mm",
        "flow_exponent",
        "rise_exponent",
        "fall_exponent",
        "above_reference_k",
        "yield_per_k",
        "viscosity_per_k",
        "electrode_capacitance_f",
        "amplifier_current_a",
        "gap_m",
    ])?;
    let or = |key, allowed, default| Ok::<_, Error>(section.number(key, allowed)?.unwrap_or(default));
    Ok(ErFluid {
        consistency: or("consistency", Allowed::AtLeastZero, 0.0)?,
        consistency_per_kv_mm: or("consistency_per_kv_mm", Allowed::AtLeastZero, 0.0)?,
        flow_exponent: or("flow_exponent", Allowed::Between(0.1, 1.0), 1.0)?,
        rise_exponent: or("rise_exponent", POWER, 0.0)?,
        fall_exponent: or("fall_exponent", POWER, 0.0)?,
        above_reference_k: or("above_reference_k", WARMER, 0.0)?,
        yield_per_k: or("yield_per_k", PER_K, 0.0)?,
        viscosity_per_k: or("viscosity_per_k", PER_K, 0.0)?,
        electrode: electrode(section)?,
    })
}

/// None where none of the three keys stands; an error where one is missing beside another.
fn electrode(section: &Section<'_, '_>) -> Result<Option<ErElectrode>, Error> {
    let keys = ["electrode_capacitance_f", "amplifier_current_a", "gap_m"];
    let mut given = false;
    for key in keys {
        given |= section.number(key, Allowed::AboveZero)?.is_some();
    }
    if !given {
        return Ok(None);
    }
    let value = |key| section.required_number(key, Allowed::AboveZero);
    Ok(Some(ErElectrode { capacitance_f: value(keys[0])?, current_a: value(keys[1])?, gap_m: value(keys[2])? }))
}

fn effects(sections: &[Section<'_, '_>], axis: AxisKind) -> Result<Vec<EffectEntry>, Error> {
    let mut entries: Vec<EffectEntry> = Vec::with_capacity(sections.len());
    for section in sections {
        let entry = effect(section, axis)?;
        let clash = entries.iter().position(|earlier| excludes(earlier, &entry));
        if let Some(earlier) = clash {
            let message = format!("{} is there already, as effects[{}]", entry.id, earlier + 1);
            return Err(section.error(section.span(), "id", message));
        }
        entries.push(entry);
    }
    Ok(entries)
}

/// Whether two entries state the same effect of the same recording.
fn excludes(earlier: &EffectEntry, entry: &EffectEntry) -> bool {
    earlier.id == entry.id
        && vocabulary::effect(&entry.id).is_some_and(|kind| kind.occurs == Occurs::Once)
        && (earlier.recording.is_none() || entry.recording.is_none() || earlier.recording == entry.recording)
}

fn effect(section: &Section<'_, '_>, axis: AxisKind) -> Result<EffectEntry, Error> {
    let (id, span) = section.required_text("id", "the identifier of an effect, in quotes")?;
    let Some(kind) = vocabulary::effect(id) else {
        let message = match misspelt(id, vocabulary::EFFECTS.iter().map(|effect| effect.id)) {
            _ if id == vocabulary::CONTROLLER => "`controller` is a finding, not a part of a model".to_owned(),
            Some(near) => format!("{} is not an effect; the nearest is `{near}`", quoted(id)),
            None => format!("{} is not an effect", quoted(id)),
        };
        return Err(section.error(&span, "id", message));
    };
    let recording = section.text("recording", "the file name of a recording, in quotes")?;
    if recording.is_none() && kind.occurs == Occurs::InNamedRecording {
        let message = format!("is missing; {id} happens in one recording, whose file name must be given");
        return Err(section.error(section.span(), "recording", message));
    }
    Ok(EffectEntry {
        id: id.to_owned(),
        recording: recording.map(|(name, _)| name.to_owned()),
        parameters: parameters(section, kind, axis)?,
    })
}

fn parameters(section: &Section<'_, '_>, kind: &EffectKind, axis: AxisKind) -> Result<Vec<(String, f64)>, Error> {
    let mut known = vec!["id", "recording"];
    known.extend(kind.parameters.iter().map(|parameter| parameter.id(axis)));
    section.only(&known)?;
    kind.parameters
        .iter()
        .map(|parameter| {
            let id = parameter.id(axis);
            Ok((id.to_owned(), section.required_number(id, parameter.allowed)?))
        })
        .collect()
}
