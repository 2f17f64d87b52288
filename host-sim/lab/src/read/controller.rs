//! Section `[controller]`: values over the defaults of the control library.

use super::toml_section::{Pair, Section, Setting};
use super::vocabulary::Allowed;
use crate::Error;

/// The configuration that the `pairs` of `section` make.
pub(super) fn controller_config(section: &Section<'_, '_>, pairs: &[Pair]) -> Result<er_servo::Config, Error> {
    section.only(&["kp_nm_rad"])?;
    let mut config = er_servo::Config { kp_nm_rad: 240.0 };
    for pair in pairs {
        match pair.setting {
            Setting::Number(value) if Allowed::AtLeastZero.holds(value) => config.kp_nm_rad = value as f32,
            Setting::Number(value) => {
                let message = format!("{value} is not allowed; must be {}", Allowed::AtLeastZero);
                return Err(section.error(&pair.span, &pair.key, message));
            }
            Setting::Flag(flag) => {
                let message = format!("{flag} is not allowed; must be {}", Allowed::AtLeastZero);
                return Err(section.error(&pair.span, &pair.key, message));
            }
        }
    }
    Ok(config)
}
