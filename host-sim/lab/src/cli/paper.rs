//! `servo-lab paper`: the paper's figures, and what became of its claims.

use std::path::PathBuf;

use crate::paper::{figures, reproduce, table};
use crate::{Error, output};

/// Flags of `paper`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the figures and the table; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/paper")]
    out: PathBuf,
}

/// Reproduces the paper, writes figures and table, prints the table.
///
/// # Errors
/// Outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    output::folder(&args.out)?;
    let paper = reproduce()?;
    for named in &paper.figures {
        named.figure.write(&args.out.join(named.file))?;
    }
    let file = args.out.join("claims.md");
    output::write_text(&file, &table::markdown(&paper))?;
    output::print(&format!(
        "{}{} figures and claims.md written to {}\n{}.\n",
        table::plain(&paper),
        paper.figures.len(),
        args.out.display(),
        figures::LEFT_OUT
    ))
}
