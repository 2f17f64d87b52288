//! What `servo-lab link set` is given: on the command line, or in a file.

use std::path::PathBuf;

use er_servo::parameters::Parameter;
use wire::parameter::{check, find};

use crate::Error;
use crate::read::read_parameters;

/// Name of a parameter, and its value.
pub type Assignment = (&'static str, f32);

/// Flags of `link set`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Names and values.
    #[arg(required_unless_present = "from", conflicts_with = "from", value_name = "NAME=VALUE", value_parser = assignment)]
    values: Vec<(String, f32)>,
    /// Those in a file: what `get` has printed, or the section `controller` of a machine file.
    #[arg(long, value_name = "FILE")]
    from: Option<PathBuf>,
    /// Even if the loop would be unstable; the drive logs it.
    #[arg(long)]
    pub force: bool,
}

fn assignment(text: &str) -> Result<(String, f32), String> {
    let (name, value) = text.split_once('=').ok_or("NAME=VALUE is expected")?;
    let value = match value.trim() {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| format!("`{number}` is not a number"))?,
    };
    Ok((name.trim().to_owned(), value))
}

impl Args {
    /// Every parameter that was given, each within its range. The drive refuses those of a file that its image has built in
    /// where they differ: a set for another period is one for another image.
    ///
    /// # Errors
    ///
    /// A name that is no parameter's, a value out of range, a file that cannot be read.
    pub fn values(&self) -> Result<Vec<Assignment>, Error> {
        let usage = |error: wire::parameter::ParameterError| Error::Usage(error.to_string());
        let given: Vec<(&'static Parameter, f32)> = match &self.from {
            Some(file) => read_parameters(file)?,
            None => {
                let found = self.values.iter().map(|(name, value)| Ok((find(name)?.1, *value)));
                found.collect::<Result<_, _>>().map_err(usage)?
            }
        };
        given.iter().try_for_each(|(parameter, value)| check(parameter, *value)).map_err(usage)?;
        Ok(given.into_iter().map(|(parameter, value)| (parameter.name, value)).collect())
    }
}
