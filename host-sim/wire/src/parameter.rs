//! The drive's parameters by the names a user knows them by, checked before they are sent.

use er_servo::ConfigError;
use er_servo::parameters::{Parameter, TABLE};

/// A parameter that the drive would not take.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// No parameter of that name.
    #[error("there is no parameter `{name}`; the nearest is `{nearest}`")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What was probably meant.
        nearest: &'static str,
    },
    /// The value is no number in the parameter's range.
    #[error("{}: {value} {} is not allowed, {} to {} is", parameter.name, parameter.unit, parameter.min, parameter.max)]
    Range {
        /// The parameter.
        parameter: &'static Parameter,
        /// What was asked for.
        value: f32,
    },
    /// The values do not fit together.
    #[error("{0}")]
    Combination(ConfigError),
}

/// A parameter and its index on the link, by name.
///
/// # Errors
///
/// [`ParameterError::Unknown`].
pub fn find(name: &str) -> Result<(u8, &'static Parameter), ParameterError> {
    let found = (0..).zip(TABLE).find(|(_, parameter)| parameter.name == name);
    found.ok_or_else(|| {
        // Comparing is quadratic in the length; no name is longer than this.
        let short: String = name.chars().take(64).collect();
        let likeness = |parameter: &&Parameter| strsim::normalized_damerau_levenshtein(&short, parameter.name);
        let nearest = TABLE.iter().max_by(|one, other| likeness(one).total_cmp(&likeness(other)));
        ParameterError::Unknown { name: short.clone(), nearest: nearest.map_or("", |parameter| parameter.name) }
    })
}

/// Whether a value lies in the parameter's range.
///
/// # Errors
///
/// [`ParameterError::Range`], for what is not a number too.
pub fn check(parameter: &'static Parameter, value: f32) -> Result<(), ParameterError> {
    let is_allowed = (parameter.min..=parameter.max).contains(&value);
    if is_allowed { Ok(()) } else { Err(ParameterError::Range { parameter, value }) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn every_parameter_is_found_by_its_name_at_its_index() {
        for (index, parameter) in (0..).zip(TABLE) {
            assert_eq!(find(parameter.name), Ok((index, parameter)));
        }
    }

    #[test]
    fn what_cannot_be_says_what_can() {
        let message = |error: ParameterError| error.to_string();
        assert!(message(find("kp_nm_rd").unwrap_err()).ends_with("the nearest is `kp_nm_rad`"));
        assert!(message(find(&"x".repeat(100_000)).unwrap_err()).len() < 200);
        let (_, limit) = find("torque_limit_nm").unwrap();
        assert_eq!(message(check(limit, 31.0).unwrap_err()), "torque_limit_nm: 31 N m is not allowed, 0 to 30 is");
        assert!(check(limit, f32::NAN).is_err() && check(limit, 30.0).is_ok());
    }
}
