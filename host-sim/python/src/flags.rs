//! The flags of a command, which the keyword arguments of its Python function are.

use clap::Parser;
use lab::Error;

#[derive(Debug, Parser)]
#[command(name = "servo_lab", disable_help_flag = true)]
struct Flags<A: clap::Args> {
    #[command(flatten)]
    args: A,
}

/// Parses words as the command line does.
///
/// # Errors
/// A value that a flag does not take.
pub fn parsed<A: clap::Args>(words: &[String]) -> Result<A, Error> {
    let words = std::iter::once("servo_lab").chain(words.iter().map(String::as_str));
    let parsed = Flags::try_parse_from(words).map_err(|error| {
        let text = error.to_string();
        // What follows is about `--help`.
        let message = text.split("\n\nUsage:").next().unwrap_or_default();
        let message = message.split("\n\nFor more information").next().unwrap_or_default();
        Error::Usage(message.trim_start_matches("error: ").trim_end().to_owned())
    })?;
    Ok(parsed.args)
}
