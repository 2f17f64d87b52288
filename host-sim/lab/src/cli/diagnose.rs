//! `servo-lab diagnose`.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::Error;
use crate::decide::{Request, diagnose};
use crate::effects::{self, Effect};
use crate::read::{Machine, Recording};
use crate::report::Answer;
use crate::report::html::{PlotData, page};
use crate::{output, propose, report};

/// Flags of `diagnose`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file: the nominal model.
    #[arg(long, value_name = "FILE")]
    machine: PathBuf,
    /// Recordings that are only predicted, never fitted; without one, blocks of the others are held out.
    #[arg(long, value_name = "RECORDING")]
    holdout: Vec<PathBuf>,
    /// Writes the answer as JSON; `-` for standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the answer as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Writes the machine file with the effects added, a model like any other.
    #[arg(long, value_name = "FILE")]
    write_model: Option<PathBuf>,
    /// Writes the reference to record next as CSV, where the verdict is ambiguous.
    #[arg(long, value_name = "FILE")]
    experiment: Option<PathBuf>,
    /// Names only these effects; separated by commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    only: Vec<String>,
    /// Never names these effects; separated by commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    without: Vec<String>,
    /// Threads; as many as there are cores by default.
    #[arg(long, value_name = "N")]
    jobs: Option<usize>,
    /// Prints on standard error how long each stage took.
    #[arg(long)]
    stages: bool,
    /// Recordings to diagnose, CSV or Parquet.
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
}

/// Diagnoses the recordings; every verdict is success.
///
/// # Errors
/// Files that cannot be read, effects that do not exist, outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(jobs) = args.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(jobs)
            .build_global()
            .map_err(|error| Error::Usage(format!("--jobs {jobs}: {error}")))?;
    }
    let vocabulary = vocabulary(&args.only, &args.without)?;
    let machine = Machine::read(&args.machine)?;
    let read = |files: &[PathBuf]| -> Result<Vec<Recording>, Error> {
        files.iter().map(|file| Recording::read(file, Some(machine.axis.kind))).collect()
    };
    let (recordings, holdout) = (read(&args.recordings)?, read(&args.holdout)?);
    let request = Request { machine: &machine, recordings: &recordings, holdout: &holdout, vocabulary: &vocabulary };
    let mut diagnosis = diagnose(&request)?;
    if args.stages {
        diagnosis.stages.taken().iter().for_each(|(stage, took)| eprintln!("{stage:24} {:7.3} s", took.as_secs_f64()));
    }
    if let (Some(file), Some(proposal), Some(experiment)) = (
        &args.experiment,
        diagnosis.proposal.as_ref().filter(|proposal| !proposal.reference.is_empty()),
        &mut diagnosis.answer.experiment,
    ) {
        propose::write_reference(file, machine.axis.kind, &proposal.reference)?;
        experiment.reference_csv = Some(file.display().to_string());
    }
    if let Some(file) = &args.html {
        let plot = PlotData::new(&diagnosis, &recordings, &holdout)?;
        output::write_text(file, &page(&machine.name, &diagnosis.answer, &plot)?)?;
    }
    write(args, &diagnosis.answer)
}

/// The answer where it was asked for: JSON, machine file, and in words unless the JSON goes to standard output.
fn write(args: &Args, answer: &Answer) -> Result<(), Error> {
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(answer)
            .map_err(|error| Error::Output { file: file.clone(), reason: error.to_string() })?;
        if to_stdout {
            println!("{text}");
        } else {
            output::write(file, |out| writeln!(out, "{text}"))?;
        }
    }
    if let Some(file) = &args.write_model {
        let text = report::improved_machine(&read_text(&args.machine)?, answer);
        output::write(file, |out| out.write_all(text.as_bytes()))?;
    }
    if !to_stdout {
        print!("{}", report::summary(answer));
    }
    Ok(())
}

fn read_text(file: &Path) -> Result<String, Error> {
    std::fs::read_to_string(file).map_err(|error| Error::input(file, None, "", error.to_string()))
}

/// The effects that may be named.
fn vocabulary(only: &[String], without: &[String]) -> Result<Vec<&'static Effect>, Error> {
    for id in only.iter().chain(without) {
        if effects::find(id).is_none() && id != crate::read::vocabulary::CONTROLLER {
            let known: Vec<&str> = effects::VOCABULARY.iter().map(|effect| effect.id).collect();
            return Err(Error::Usage(format!("there is no effect `{id}`; known are {}", known.join(", "))));
        }
    }
    let kept = |effect: &&'static Effect| {
        (only.is_empty() || only.iter().any(|id| id == effect.id)) && !without.iter().any(|id| id == effect.id)
    };
    Ok(effects::VOCABULARY.iter().copied().filter(kept).collect())
}
