//! `servo-lab diagnose`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::Overwrite;
use crate::Error;
use crate::conclude::{self, OfFiles};
use crate::output::{self, Output, Outputs, Provenance, formats};
use crate::progress::Course;
use crate::propose;
use crate::report::html::{PlotData, page};
use crate::report::{self, Answer, Verdict};

/// Every draw of a diagnosis begins with it, so that it gives the same answer twice.
pub const SEED: u64 = 1;

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
    /// Ends with exit code 1 where the verdict is one of these; separated by commas.
    #[arg(long, value_enum, value_name = "VERDICT", value_delimiter = ',')]
    fail_on: Vec<Verdict>,
    /// Threads; as many as there are cores by default.
    #[arg(long, value_name = "N", value_parser = super::threads)]
    jobs: Option<usize>,
    /// Prints on standard error how long each stage took.
    #[arg(long)]
    stages: bool,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Recordings to diagnose, of any format that is read (`help formats`).
    #[arg(required = true, value_name = "RECORDING")]
    recordings: Vec<PathBuf>,
}

/// The outputs that were asked for.
struct Asked {
    json: Option<Output>,
    html: Option<Output>,
    model: Option<Output>,
    experiment: Option<Output>,
}

/// Diagnoses the recordings, `verbose` with how long each stage took; every verdict is success but those of `--fail-on`.
///
/// # Errors
/// Files that cannot be read, effects that do not exist, data that nothing can be computed from, outputs that cannot be
/// written.
pub fn run(args: &Args, verbose: bool) -> Result<ExitCode, Error> {
    let (asked, mut outputs) = args.files()?;
    super::use_threads(args.jobs)?;
    let vocabulary = conclude::vocabulary(&args.only, &args.without)?;
    let OfFiles { machine, recordings, holdout, mut diagnosis } =
        conclude::of_files(&args.machine, &args.recordings, &args.holdout, &vocabulary, &Course::begin("diagnosis"))?;
    if args.stages || verbose {
        diagnosis.stages.taken().iter().for_each(|(stage, took)| eprintln!("{stage:24} {:7.3} s", took.as_secs_f64()));
    }
    if let (Some(output), Some(proposal), Some(experiment)) = (
        asked.experiment,
        diagnosis.proposal.as_ref().filter(|proposal| !proposal.reference.is_empty()),
        &mut diagnosis.answer.experiment,
    ) {
        let text = propose::reference_csv(machine.axis.kind, &proposal.reference);
        output::text(&mut outputs, output, &text)?;
        experiment.reference_csv = Some(outputs.file(output).display().to_string());
    }
    if let Some(html) = asked.html {
        let (plot, made) = (PlotData::new(&diagnosis, &recordings, &holdout)?, Provenance::of(&outputs, Some(SEED))?);
        let page = page(&machine.name, &diagnosis.answer, &plot, &made)?;
        output::text(&mut outputs, html, &formats::markup(&page))?;
    }
    args.write(&asked, &mut outputs, &diagnosis.answer)?;
    Ok(if args.fail_on.contains(&diagnosis.answer.verdict) { ExitCode::from(1) } else { ExitCode::SUCCESS })
}

impl Args {
    /// Whether the answer as JSON goes to standard output, and nothing else does.
    fn to_stdout(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    fn files(&self) -> Result<(Asked, Outputs), Error> {
        let mut files = self.overwrite.files();
        files.reads(&self.machine);
        files.reads_all(self.recordings.iter().chain(&self.holdout));
        let mut writes = |file: &Option<PathBuf>| file.as_ref().map(|file| files.writes(file));
        let asked = Asked {
            json: if self.to_stdout() { None } else { writes(&self.json) },
            html: writes(&self.html),
            model: writes(&self.write_model),
            experiment: writes(&self.experiment),
        };
        Ok((asked, files.check()?))
    }

    /// The answer where it was asked for: JSON, machine file, and in words unless the JSON goes to standard output.
    fn write(&self, asked: &Asked, outputs: &mut Outputs, answer: &Answer) -> Result<(), Error> {
        let json = match &self.json {
            Some(_) => Some(formats::json(answer, &Provenance::of(outputs, Some(SEED))?)?),
            None => None,
        };
        if let (Some(output), Some(text)) = (asked.json, &json) {
            output::text(outputs, output, text)?;
        }
        // An answer is not lost for a machine file that is gone by now.
        let model = asked.model.map_or(Ok(()), |model| self.write_model(model, outputs, answer));
        outputs.finish()?;
        match json.filter(|_| self.to_stdout()) {
            Some(text) => output::print(&text)?,
            None => output::print(&report::summary(answer))?,
        }
        model
    }

    /// The machine file with the effects.
    fn write_model(&self, model: Output, outputs: &mut Outputs, answer: &Answer) -> Result<(), Error> {
        let improved = report::improved_machine(&read_text(&self.machine)?, answer);
        output::text(outputs, model, &formats::toml(&improved))
    }
}

fn read_text(file: &Path) -> Result<String, Error> {
    std::fs::read_to_string(file).map_err(|error| Error::input(file, None, "", error.to_string()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::report::testing::effect;
    use clap::Parser as _;

    #[derive(clap::Parser)]
    struct Flags {
        #[command(flatten)]
        args: Args,
    }

    fn answer(verdict: Verdict) -> Answer {
        let effect = effect("gravity_load", "amplitude_nm", 18.0, 1.0);
        Answer { verdict, effects: vec![effect], ..Answer::default() }
    }

    /// The model that is written of such an answer.
    fn written(verdict: Verdict) -> String {
        let folder = tempfile::tempdir().unwrap();
        let [machine, model] = ["m.toml", "improved.toml"].map(|name| folder.path().join(name));
        std::fs::write(&machine, "schema = 1\n").unwrap();
        let words =
            ["diagnose", "--machine", machine.to_str().unwrap(), "--write-model", model.to_str().unwrap(), "r.csv"];
        let args = Flags::try_parse_from(words).unwrap().args;
        let (asked, mut outputs) = args.files().unwrap();
        args.write(&asked, &mut outputs, &answer(verdict)).unwrap();
        std::fs::read_to_string(&model).unwrap()
    }

    #[test]
    fn the_model_of_an_answer_has_its_effects() {
        for verdict in [Verdict::Named, Verdict::Partial, Verdict::Ambiguous] {
            assert!(written(verdict).contains("gravity_load"), "{verdict:?}");
        }
    }
}
