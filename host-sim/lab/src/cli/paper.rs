//! `servo-lab paper`: the paper's figures, and what became of its claims.

use std::path::PathBuf;

use super::Overwrite;
use crate::output::{Output, formats};
use crate::paper::{figures, reproduce, table};
use crate::{Error, output};

/// Flags of `paper`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the figures and the table; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/paper")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Reproduces the paper, writes figures and table, prints the table.
///
/// # Errors
/// Outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    let picture = |name: &'static str| (name, files.writes(&args.out.join(name)));
    let pictures: Vec<(&str, Output)> = figures::FILES.into_iter().map(picture).collect();
    let claims = files.writes(&args.out.join("claims.md"));
    let mut outputs = files.check()?;
    let paper = reproduce()?;
    for (name, picture) in pictures {
        let named = paper.figures.iter().find(|named| named.file == name);
        named.map_or(Ok(()), |named| output::figure(&mut outputs, picture, &named.figure))?;
    }
    output::text(&mut outputs, claims, &formats::markdown(&table::markdown(&paper)))?;
    outputs.finish()?;
    output::print(&format!(
        "{}{} figures and claims.md written to {}\n{}.\n",
        table::plain(&paper),
        paper.figures.len(),
        args.out.display(),
        figures::LEFT_OUT
    ))
}
