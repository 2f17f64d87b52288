//! `servo-lab paper`: the paper's figures, what became of its claims, and the control beyond it.

mod page;

use std::path::{Path, PathBuf};

use super::Overwrite;
use crate::beyond::compare;
use crate::output::{Files, Output, Provenance, formats};
use crate::paper::{figures, reproduce, table};
use crate::progress::Course;
use crate::read::{AxisKind, Machine, Recording};
use crate::{Error, output};

/// Flags of `paper`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the figures and the table; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/paper")]
    out: PathBuf,
    /// Writes table and figures as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Recording of a step of 30 degrees from 0, drawn dashed into Figs. 12 to 18.
    #[arg(long, value_name = "FILE", conflicts_with = "beyond")]
    measured: Option<PathBuf>,
    /// Machine file whose section `columns` says what the columns of the recording are; without it, they are the format's own.
    #[arg(long, value_name = "FILE", requires = "measured")]
    machine: Option<PathBuf>,
    /// In place of the paper's figures and claims: the control it asks for, beside its own law, in one table and one figure.
    #[arg(long)]
    beyond: bool,
}

/// Reproduces the paper, writes figures and table, prints the table.
///
/// # Errors
/// A recording that cannot be read, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    if args.beyond {
        return beyond(args, files);
    }
    files.reads_all(args.measured.iter().chain(&args.machine));
    let picture = |name: &'static str| (name, files.writes(&args.out.join(name)));
    let pictures: Vec<(&str, Output)> = figures::FILES.into_iter().map(picture).collect();
    let claims = files.writes(&args.out.join("claims.md"));
    let html = args.html.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let measured = args.measured.as_ref().map(|file| args.read(file)).transpose()?;
    // Its steps take from milliseconds to half of the time: a count of them would tell a wrong end.
    let course = Course::begin("paper");
    course.enter("runs, claims and figures");
    let paper = reproduce(measured.as_ref())?;
    drop(course);
    for (name, picture) in pictures {
        let named = paper.figures.iter().find(|named| named.file == name);
        named.map_or(Ok(()), |named| output::figure(&mut outputs, picture, &named.figure))?;
    }
    output::text(&mut outputs, claims, &formats::markdown(&table::markdown(&paper)))?;
    if let Some(html) = html {
        let page = page::page(&paper, &Provenance::of(&outputs, None)?)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    outputs.finish()?;
    output::print(&format!(
        "{}{} figures and claims.md written to {}\n{}.\n",
        table::plain(&paper),
        paper.figures.len(),
        args.out.display(),
        figures::LEFT_OUT
    ))
}

impl Args {
    /// The measured recording, by the columns of the machine file where one is given.
    fn read(&self, recording: &Path) -> Result<Recording, Error> {
        let Some(file) = &self.machine else { return Recording::read(recording, Some(AxisKind::Rotary)) };
        let machine = Machine::read(file)?;
        if machine.axis.kind != AxisKind::Rotary {
            return Err(Error::input(file, None, "axis.kind", "the paper's servo is a rotary axis"));
        }
        Recording::of(recording, &machine)
    }
}

fn beyond(args: &Args, mut files: Files) -> Result<(), Error> {
    let (table, figure) = (files.writes(&args.out.join("beyond.md")), files.writes(&args.out.join("beyond.svg")));
    let html = args.html.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let course = Course::begin("paper");
    course.enter("the control beyond it");
    let comparison = compare()?;
    drop(course);
    output::figure(&mut outputs, figure, &comparison.figure()?)?;
    let text = comparison.markdown();
    output::text(&mut outputs, table, &formats::markdown(&text))?;
    if let Some(html) = html {
        let page = page::beyond(&comparison, &Provenance::of(&outputs, None)?)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    outputs.finish()?;
    let (table, figure) = (outputs.file(table).display(), outputs.file(figure).display());
    output::print(&format!("{text}\nwrote {table} and {figure}\n"))
}
