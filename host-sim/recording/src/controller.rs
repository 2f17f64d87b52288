//! Section `[controller]`: values over the defaults of the control library, whose own table gives names and ranges.

use std::path::Path;

use er_servo::parameters::{self, Parameter};
use er_servo::{Config, ConfigError, Params};

use super::toml_section::{Pair, Section, Setting, Source};
use crate::Error;

/// The parameters that a file names, in its order, not checked against their ranges: lines as `[controller]` has them, or a
/// machine file,
/// of which only that section is looked at.
///
/// # Errors
///
/// [`Error::Input`] with file, line and key: no such file, not TOML, no `[controller]` where there are other sections, a name
/// that is no parameter's, or a value that is none.
pub fn read_parameters(file: &Path) -> Result<Vec<(&'static Parameter, f32)>, Error> {
    let text = std::fs::read_to_string(file)
        .map_err(|error| Error::input(file, None, "", format!("cannot be read: {error}")))?;
    let source = Source { file, text: text.strip_prefix('\u{feff}').unwrap_or(&text) };
    let document = source.parse()?;
    let top = Section::top(source, &document);
    // Only a machine file has a schema.
    let section = match top.section("controller")? {
        Some(section) => section,
        None if document.get_ref().contains_key("schema") => top.required_section("controller")?,
        None => top,
    };
    known(&section)?;
    let pairs = section.pairs()?;
    let found = pairs.iter().filter_map(|pair| Some((pair, parameters::find(&pair.key)?)));
    found.map(|(pair, parameter)| Ok((parameter, value(&section, pair, parameter)?))).collect()
}

fn known(section: &Section<'_, '_>) -> Result<(), Error> {
    let names: Vec<&str> = parameters::TABLE.iter().map(|parameter| parameter.name).collect();
    section.only(&names)
}

/// The configuration that the `pairs` of `section` make.
pub(super) fn controller_config(section: &Section<'_, '_>, pairs: &[Pair]) -> Result<Config, Error> {
    known(section)?;
    let mut config = Config::default();
    for pair in pairs {
        if let Some(parameter) = parameters::find(&pair.key) {
            (parameter.set)(&mut config, value(section, pair, parameter)?);
        }
    }
    Params::new(&config).map(|_| config).map_err(|error| {
        let key = match &error {
            ConfigError::OutOfRange { parameter, .. } => parameter.name,
            ConfigError::NearTooSmall { .. } => "near_rad",
            ConfigError::Positions { .. } => "position_min_rad",
            ConfigError::BuiltIn { name, .. } => name,
            ConfigError::Unstable(_) => "kp_nm_rad",
        };
        let span = pairs.iter().find(|pair| pair.key == key).map_or(section.span(), |pair| &pair.span);
        section.error(span, key, error.to_string())
    })
}

/// The value of one pair; a flag is true or false, or 1 or 0.
fn value(section: &Section<'_, '_>, pair: &Pair, parameter: &Parameter) -> Result<f32, Error> {
    let is_flag = parameter.unit == "flag";
    match pair.setting {
        Setting::Flag(flag) if is_flag => Ok(if flag { 1.0 } else { 0.0 }),
        Setting::Number(number) if is_flag && (number == 0.0 || number == 1.0) => Ok(number as f32),
        Setting::Number(number) if !is_flag => Ok(number as f32),
        Setting::Flag(_) => {
            let Parameter { unit, min, max, .. } = parameter;
            Err(section.error(&pair.span, &pair.key, format!("must be a number, {min} to {max} {unit}")))
        }
        Setting::Number(number) => {
            Err(section.error(&pair.span, &pair.key, format!("{number} is not allowed; must be true or false")))
        }
    }
}

/// Every key of the section with the value it has in `config`.
pub(super) fn controller_pairs(config: &Config) -> Vec<(&'static str, Setting)> {
    let setting = |parameter: &Parameter| match (parameter.get)(config) {
        value if parameter.unit == "flag" => Setting::Flag(value != 0.0),
        value => Setting::Number(value.into()),
    };
    parameters::TABLE.iter().map(|parameter| (parameter.name, setting(parameter))).collect()
}
