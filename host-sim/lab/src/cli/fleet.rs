//! `servo-lab fleet`.

use std::path::PathBuf;

use super::Overwrite;
use crate::Error;
use crate::fleet::summary::Summary;
use crate::fleet::{manifest, run as diagnosed, table};
use crate::output::{self, Input, Provenance, formats, sha256};

/// Flags of `fleet`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Manifest, CSV or Parquet: columns machine and recordings, and holdout and date if wanted; `;` between the files of a cell, which
    /// are relative to the manifest.
    #[arg(value_name = "MANIFEST")]
    manifest: PathBuf,
    /// Table of the answers, .parquet, one row a diagnosis. Rows that it has already are not done again.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    /// Writes the summary as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Threads; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = super::threads)]
    jobs: Option<usize>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Diagnoses every row of the manifest, writes the table after each, and prints the summary.
///
/// # Errors
/// A manifest that cannot be read, an output that cannot be written; after all rows are tried, the first without an answer.
pub fn run(args: &Args) -> Result<(), Error> {
    if args.out.extension().is_none_or(|extension| extension != "parquet") {
        let reason = "the name of the table must end in .parquet".to_owned();
        return Err(Error::Output { file: args.out.clone(), reason });
    }
    let tasks = manifest::read(&args.manifest)?;
    let mut files = args.overwrite.files();
    files.reads(&args.manifest);
    for task in &tasks {
        files.reads(&task.machine_file());
        files.reads_all(task.recording_files().iter().flatten());
    }
    let (out, html) = (files.writes(&args.out), args.html.as_ref().map(|file| files.writes(file)));
    let mut outputs = files.check()?;
    super::use_threads(args.jobs)?;
    let earlier = table::earlier(&args.out)?;
    let rows = diagnosed(&tasks, &earlier, |rows| table::write(&mut outputs, out, rows))?;
    // Also where nothing was left to do: rows that are no longer in the manifest go.
    table::write(&mut outputs, out, &rows.iter().collect::<Vec<_>>())?;
    let summary = Summary::of(&rows);
    if let Some(html) = html {
        let hashed =
            sha256(&args.manifest).map_err(|error| Error::input(&args.manifest, None, "", error.to_string()))?;
        let inputs = vec![Input { file: args.manifest.display().to_string(), sha256: hashed }];
        let made = Provenance { inputs, ..Provenance::without_inputs(None) };
        let page = summary.page(&args.manifest.display().to_string(), &made);
        output::text(&mut outputs, html, &formats::markup(&page))?;
        outputs.finish()?;
    }
    output::print(&format!("{}\nwrote {}: {} rows\n", summary.text(), args.out.display(), rows.len()))?;
    Summary::complete(&args.manifest, &rows)
}
