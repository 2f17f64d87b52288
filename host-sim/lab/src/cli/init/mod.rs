//! `servo-lab init`.

mod text;

use std::path::{Path, PathBuf};

use super::Overwrite;
use crate::first_model::{FirstModel, first_model};
use crate::output::formats;
use crate::precheck::windows::median_period_s;
use crate::precheck::wrong_rate;
use crate::read::{
    Axis, AxisKind, Cells, Column, Given, Guess, Machine, MapFlag, Mapping, Recording, Table, guess, places,
    position_step, wrap,
};
use crate::{Error, output};

/// Flags of `init`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Logs of one machine with the same columns: CSV (`,` `;` tab, decimal comma), Parquet, MCAP, also as .gz; `help formats`
    /// lists them all; - for standard input.
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
    /// What a column is: time, position, torque (force on a linear axis), reference, velocity and others, as
    /// `KEY=NAME[:UNIT[*SCALE]]`; units such as us, deg, mrad, rev, counts(8192), mm, mN m, A, V. Once for each column.
    #[arg(long, value_name = "KEY=NAME:UNIT*SCALE")]
    map: Vec<MapFlag>,
    /// The joint of a robot, or the run, where the logs hold several.
    #[arg(long, value_name = "NAME")]
    joint: Option<String>,
    /// The kind of axis, where no unit tells it.
    #[arg(long, value_name = "rotary|linear", value_parser = axis_kind)]
    axis: Option<AxisKind>,
    /// Where the machine file goes.
    #[arg(long, short, value_name = "FILE", default_value = "machine.toml")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

fn axis_kind(text: &str) -> Result<AxisKind, String> {
    let kind = AxisKind::ALL.into_iter().find(|kind| kind.name() == text);
    kind.ok_or_else(|| "must be rotary or linear".to_owned())
}

/// The longest `sample_period_s` that a machine file may have, s; a longer one would not read back.
const LONGEST_PERIOD_S: f64 = 1.0;

/// Everything that is known of the machine from its logs.
struct Findings<'a> {
    logs: &'a [PathBuf],
    axis: Axis,
    guesses: Vec<Guess>,
    /// What the columns are; empty where the logs have those of the format.
    mapping: Mapping,
    recordings: Vec<Recording>,
    /// Rows above the header of the first log.
    rows_above: usize,
    model: Option<FirstModel>,
}

/// Guesses a machine file, prints what it guessed and how sure, and writes it.
///
/// # Errors
/// Logs that cannot be read, columns that no name tells, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads_all(&args.logs);
    let out = files.writes(&args.out);
    let mut outputs = files.check()?;
    let findings = find(args)?;
    let machine = text::machine_file(&findings);
    // What is written reads back, or is not written.
    let read = Machine::from_bytes(&args.out, machine.as_bytes())?;
    output::text(&mut outputs, out, &formats::toml(&machine))?;
    outputs.finish()?;
    output::print(&text::summary(&findings, &read, outputs.file(out)))
}

fn find(args: &Args) -> Result<Findings<'_>, Error> {
    let Some(first) = args.logs.first() else { return Err(Error::Usage("no log is given".to_owned())) };
    let usage = |message: String| Error::input(first, None, "", message);
    let table = Table::read(first)?;
    let known = Given { flags: &args.map, joint: args.joint.as_deref(), axis: args.axis };
    let (kind, mut guesses) = guess(&table, known).map_err(usage)?;
    let mut axis = Axis { kind, sample_period_s: 1e-3, resolution: 0.0 };
    let mut mapping = mapping_of(&guesses, kind).map_err(usage)?;
    let mut recordings = read(&args.logs, &axis, &mapping)?;
    if let Some(short) = recordings.iter().find(|recording| recording.rows() < 2) {
        return Err(Error::Usage(format!("{}: one row tells nothing; record longer", short.name)));
    }
    if unwrap(&mut guesses, &recordings).map_err(usage)? {
        mapping = mapping_of(&guesses, kind).map_err(usage)?;
        recordings = read(&args.logs, &axis, &mapping)?;
    }
    axis.sample_period_s = period_s(&recordings).map_err(usage)?;
    let steps = recordings.iter().filter_map(|recording| position_step(&recording.position));
    axis.resolution = steps.reduce(f64::min).unwrap_or(0.0);
    let model = first_model(&axis, &recordings);
    if model.as_ref().is_some_and(|model| model.reversed) && !given(args, Column::EffortCmd) {
        for guess in guesses.iter_mut().filter(|guess| guess.mapped.column == Column::EffortCmd) {
            guess.mapped = guess.mapped.clone().reversed();
            guess.because += "; sign turned: it pushed against the acceleration";
            guess.unsure = true;
        }
        mapping = mapping_of(&guesses, kind).map_err(usage)?;
        recordings = read(&args.logs, &axis, &mapping)?;
    }
    let model = first_model(&axis, &recordings);
    Ok(Findings { logs: &args.logs, axis, guesses, mapping, recordings, rows_above: table.rows_above, model })
}

/// The period of the first log, s.
///
/// # Errors
/// One that no machine file may have, as a sentence with what it is.
fn period_s(recordings: &[Recording]) -> Result<f64, String> {
    let Some(first) = recordings.first() else { return Ok(1e-3) };
    let period_s = median_period_s(&first.t_s);
    if period_s <= LONGEST_PERIOD_S {
        return Ok(period_s);
    }
    Err(format!(
        "rows are {period_s} s apart, the median of {} steps, and `sample_period_s` of a machine file is at most \
         {LONGEST_PERIOD_S} s; is the time in another unit, as --map \"time=NAME:ms\" or :us says? If not: {}",
        first.rows() - 1,
        wrong_rate(period_s).unwrap_or_default()
    ))
}

/// Whether a flag gives the column, which is then left as it is.
fn given(args: &Args, column: Column) -> bool {
    args.map.iter().any(|flag| flag.column == column)
}

/// Says of positions and references that wrap that they do; whether there are any.
fn unwrap(guesses: &mut [Guess], recordings: &[Recording]) -> Result<bool, String> {
    let mut any = false;
    for guess in guesses.iter_mut().filter(|guess| matches!(guess.mapped.column, Column::Position | Column::Reference))
    {
        let column = guess.mapped.column;
        let values = |recording: &Recording| match recording.column(column) {
            Some(Cells::Real(values)) => wrap(values),
            _ => None,
        };
        let found: Vec<_> = recordings.iter().filter_map(values).collect();
        let Some(first) = found.first() else { continue };
        let width = first.width_in(guess.mapped.factor());
        let count: usize = found.iter().map(|wrap| wrap.rows.len()).sum();
        guess.because += &format!("; WRAPS: it jumps by {width:?} {} in {}", guess.mapped.unit, places(count));
        guess.mapped = guess.mapped.clone().wrapping(width)?;
        any = true;
    }
    Ok(any)
}

/// The mapping of the guesses; empty where they are the format's own columns.
fn mapping_of(guesses: &[Guess], axis: AxisKind) -> Result<Mapping, String> {
    let own = |guess: &Guess| {
        guess.mapped.name == guess.mapped.column.name(axis)
            && guess.mapped.factor() == 1.0
            && guess.mapped.wrap.is_none()
    };
    if guesses.iter().all(own) {
        return Ok(Mapping::default());
    }
    Mapping::new(guesses.iter().map(|guess| guess.mapped.clone()).collect(), axis)
}

fn read(logs: &[PathBuf], axis: &Axis, mapping: &Mapping) -> Result<Vec<Recording>, Error> {
    logs.iter().map(|log| Recording::mapped(log, axis.kind, mapping)).collect()
}

/// The name of a machine from that of its log, or of the folder of its logs.
fn name(logs: &[PathBuf]) -> String {
    let stem = |file: &Path| {
        let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.split('.').next().unwrap_or_default().to_owned()
    };
    let folder = |log: &PathBuf| std::path::absolute(log).ok()?.parent().map(stem).filter(|name| !name.is_empty());
    let name = match logs {
        [] => String::new(),
        [log] => stem(log),
        [log, ..] => folder(log).unwrap_or_else(|| stem(log)),
    };
    if name.is_empty() || name == "-" { "machine".to_owned() } else { name }
}
