//! `servo-lab guide`.

use std::path::PathBuf;

use diagnosis::effects::{Effect, VOCABULARY, find};

use super::Overwrite;
use crate::conclude::unknown_effect;
use crate::guide::{Guide, markdown};
use crate::output::{Output, formats};
use crate::{Error, output};

/// Flags of `guide`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the pictures and the table; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/guide")]
    out: PathBuf,
    /// Pages of these effects only; separated by commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Computes the guide, writes pictures and table, prints the table.
///
/// # Errors
/// An effect that does not exist, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(id) = args.only.iter().find(|id| find(id).is_none()) {
        return Err(unknown_effect(id));
    }
    let mut files = args.overwrite.files();
    let picture = |effect: &&Effect| (effect.id, files.writes(&args.out.join(format!("{}.svg", effect.id))));
    let pictures: Vec<(&str, Output)> = VOCABULARY.iter().map(picture).collect();
    let guide = files.writes(&args.out.join("guide.md"));
    let mut outputs = files.check()?;
    let pages = Guide::default().pages(&args.only);
    for page in &pages {
        let picture = pictures.iter().find(|(id, _)| *id == page.id);
        if let (Some(figure), Some((_, picture))) = (&page.figure, picture) {
            output::figure(&mut outputs, *picture, figure)?;
        }
    }
    let table = markdown(&pages);
    output::text(&mut outputs, guide, &formats::markdown(&table))?;
    outputs.finish()?;
    output::print(&table)
}
