//! `servo-lab guide`.

use std::path::PathBuf;

use crate::guide::{Guide, markdown};
use crate::{Error, output};

/// Flags of `guide`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the pictures and the table; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/guide")]
    out: PathBuf,
}

/// Computes the guide, writes pictures and table, prints the table.
///
/// # Errors
/// Outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    output::folder(&args.out)?;
    let pages = Guide::default().pages();
    for page in &pages {
        if let Some(figure) = &page.figure {
            figure.write(&args.out.join(format!("{}.svg", page.id)))?;
        }
    }
    let table = markdown(&pages);
    output::write_text(&args.out.join("guide.md"), &table)?;
    output::print(&table)
}
