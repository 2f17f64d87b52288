//! `servo-lab guide`.

use std::path::PathBuf;

use crate::guide::{Guide, markdown};
use crate::{Error, effects, output};

/// Flags of `guide`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the pictures and the table; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/guide")]
    out: PathBuf,
    /// Pages of these effects only; separated by commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
}

/// Computes the guide, writes pictures and table, prints the table.
///
/// # Errors
/// An effect that does not exist, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(id) = args.only.iter().find(|id| effects::find(id).is_none()) {
        return Err(Error::Usage(format!("there is no effect `{id}`")));
    }
    output::folder(&args.out)?;
    let pages = Guide::default().pages(&args.only);
    for page in &pages {
        if let Some(figure) = &page.figure {
            figure.write(&args.out.join(format!("{}.svg", page.id)))?;
        }
    }
    let table = markdown(&pages);
    output::write_text(&args.out.join("guide.md"), &table)?;
    output::print(&table)
}
