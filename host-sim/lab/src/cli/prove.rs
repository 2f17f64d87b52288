//! `servo-lab prove`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::time::Duration;

use conceal::plan::{Arm, ROUND, Version, plan, plan_of_steps};
use conceal::subject;
use diagnosis::effects::find;

use super::Overwrite;
use crate::conclude::unknown_effect;
use crate::output::{Output, Outputs, Provenance, formats};
use crate::prove::follow::{self, Change};
use crate::prove::results::{self, Origin, Results};
use crate::prove::run::{self, Ran, Settings};
use crate::prove::tool::Tool;
use crate::prove::{Score, folder, page, real, text};
use crate::{Error, output};

/// Flags of `prove`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// How seeds are read: `fixed` has one machine and lists of effects, `drawn` draws machines, effects and sizes, `steps` has the
    /// paper's own experiment, single steps under a delayed fluid.
    #[arg(long, value_name = "PLAN", default_value = "drawn")]
    plan: Version,
    /// First seed; below 10000 for tuning, from 20000 for a score.
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Number of seeds; one round of the plan by default.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
    /// Runs one case alone and keeps its files.
    #[arg(long, value_name = "SEED")]
    case: Option<u64>,
    /// Only these arms; separated by commas.
    #[arg(long, value_delimiter = ',')]
    arm: Vec<Arm>,
    /// Only cases that conceal one of these effects, of the fixed plan or of steps; separated by commas.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    effect: Vec<String>,
    /// Only two cases of each arm.
    #[arg(long)]
    quick: bool,
    /// Only share I of N, I from 1.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Counts the outcomes of these folders together, and runs nothing.
    #[arg(long, value_name = "DIR", num_args = 1..)]
    merge: Vec<PathBuf>,
    /// Writes recordings, machine file and truth of the cases into DIR/ARM/SEED, and diagnoses nothing.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["merge", "real"])]
    write_only: Option<PathBuf>,
    /// Diagnoses the real machines of --data with effects left out of their models, in place of the plan.
    #[arg(long, conflicts_with = "merge")]
    real: bool,
    /// With --real or --follow, only these sets of --data; separated by commas.
    #[arg(long, value_name = "SET", value_delimiter = ',')]
    set: Vec<String>,
    /// With --real, holds out only the first N recordings of each set, one after another.
    #[arg(long, value_name = "N")]
    folds: Option<usize>,
    /// Changes recordings in ways whose effect on the answer is known, and asks whether the answer follows: real ones, and with
    /// --count simulated ones.
    #[arg(long, conflicts_with_all = ["merge", "real", "write_only"])]
    follow: bool,
    /// With --follow, only these changes; separated by commas.
    #[arg(long, value_enum, value_name = "CHANGE", value_delimiter = ',')]
    change: Vec<Change>,
    /// Folder of the real recordings.
    #[arg(long, value_name = "DIR", default_value = "../shared/data")]
    data: PathBuf,
    /// Folder of seals, outcomes and, with --keep, recordings. Cases with an outcome there are not run again.
    #[arg(long, short, value_name = "DIR", default_value = "out/prove")]
    out: PathBuf,
    /// The program that diagnoses; this one by default.
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
    /// Cases at a time.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = super::threads)]
    workers: usize,
    /// Threads of each diagnosis.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::threads)]
    jobs: usize,
    /// Keeps the recordings.
    #[arg(long)]
    keep: bool,
    /// Does not diagnose again with the true effects only, which the held-out error is compared with.
    #[arg(long)]
    no_oracle: bool,
    /// Does not run the rivals.
    #[arg(long)]
    no_rivals: bool,
    /// Ends a diagnosis after this long; its case is listed as without an answer.
    #[arg(long, value_name = "S", default_value_t = 300)]
    limit_s: u64,
    /// Writes the counts and every outcome as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Writes the report as one page that opens in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Writes the report as Markdown, with the command and the build that made it.
    #[arg(long, value_name = "FILE")]
    write_results: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

fn shard(text: &str) -> Result<(u64, u64), String> {
    let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    parts.filter(|(i, n)| (1..=*n).contains(i)).ok_or_else(|| "must be I/N with I from 1 to N, as 1/4".to_owned())
}

/// Runs the cases and prints the counts.
///
/// # Errors
/// Folders that cannot be read or written.
pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(folder) = &args.write_only {
        let seeds = args.seeds()?;
        let mut files = args.overwrite.files();
        let mut cases = Vec::new();
        for seed in &seeds {
            cases.push((args.arm(*seed)?.0, *seed));
        }
        let label = folder::of_cases(&mut files, folder, &cases);
        folder::claim(&mut files.check()?, label)?;
        run::write_only(&seeds, args.plan, folder)?;
        return output::print(&format!("{} cases written, {}/ARM/SEED each\n", seeds.len(), folder.display()));
    }
    let (asked, mut outputs) = args.files()?;
    let settings = args.settings()?;
    // Flags that leave no case are known before a folder is made.
    let drawn_none = args.follow && args.count.is_none() && args.case.is_none();
    let none = args.real || drawn_none || !args.merge.is_empty();
    let seeds = if none { Vec::new() } else { args.seeds()? };
    asked.folder.map_or(Ok(()), |label| folder::claim(&mut outputs, label))?;
    if args.real {
        return args.prove_real(&settings, &asked, outputs);
    }
    if args.follow {
        return args.prove_followed(&settings, &asked, &seeds, outputs);
    }
    let ran = if args.merge.is_empty() { prove(&seeds, &settings)? } else { run::merged(&args.merge)? };
    let score = Score::of(&ran);
    let printed = text::report(&score, &ran.outcomes);
    if !asked.is_nothing() {
        let origin = Origin::now(&settings.tool.program, &ran)?;
        let made = Provenance::of(&outputs, Some(origin.seeds[0]))?;
        let results = Results { origin, score, outcomes: ran.outcomes };
        let document = || formats::markdown(&results::document(&results));
        asked.json.map_or(Ok(()), |json| output::text(&mut outputs, json, &formats::json(&results, &made)?))?;
        let page = || Ok::<_, Error>(formats::markup(&page::page(&results, &made)?));
        asked.html.map_or(Ok(()), |html| output::text(&mut outputs, html, &page()?))?;
        asked.results.map_or(Ok(()), |results| output::text(&mut outputs, results, &document()))?;
        outputs.finish()?;
    }
    output::print(&printed)
}

/// The reports that were asked for.
struct Asked {
    /// The label of the folder that is filled; none where outcomes are only counted.
    folder: Option<Output>,
    json: Option<Output>,
    html: Option<Output>,
    results: Option<Output>,
}

impl Asked {
    fn is_nothing(&self) -> bool {
        self.json.is_none() && self.html.is_none() && self.results.is_none()
    }

    /// Writes the page and the Markdown of a proof that is one table: title, table, what it comes to, what has no answer.
    fn tabled(
        &self,
        (title, table, summary, without): (&str, &text::Table, &str, &[String]),
        outputs: &mut Outputs,
    ) -> Result<(), Error> {
        if let Some(html) = self.html {
            let page = page::of_table(title, table, summary, without, &Provenance::of(outputs, None)?);
            output::text(outputs, html, &formats::markup(&page))?;
        }
        let Some(results) = self.results else { return Ok(()) };
        let document = results::table_document(title, table, without);
        output::text(outputs, results, &formats::markdown(&document))
    }
}

impl Args {
    fn files(&self) -> Result<(Asked, Outputs), Error> {
        let mut files = self.overwrite.files();
        files.reads_all(&self.program);
        files.reads_all(Some(&self.data).filter(|data| self.real && data.is_dir()));
        files.reads_all(&run::to_merge(&self.merge)?);
        let folder = self.merge.is_empty().then(|| folder::of_run(&mut files, &self.out));
        let mut writes = |file: &Option<PathBuf>| file.as_ref().map(|file| files.writes(file));
        let (json, html, results) = (writes(&self.json), writes(&self.html), writes(&self.write_results));
        let asked = Asked { folder, json, html, results };
        Ok((asked, files.check()?))
    }

    fn settings(&self) -> Result<Settings, Error> {
        let own =
            || std::env::current_exe().map_err(|error| Error::Usage(format!("the tool cannot find itself: {error}")));
        let unknown = |error: std::io::Error| Error::Usage(format!("--program: {error}"));
        let named = self.program.as_ref().map(|program| program.canonicalize().map_err(unknown));
        Ok(Settings {
            plan: self.plan,
            out: self.out.clone(),
            tool: Tool {
                // It runs in other folders.
                program: named.unwrap_or_else(own)?,
                jobs: self.jobs,
                limit: Duration::from_secs(self.limit_s),
            },
            workers: self.workers,
            keep: self.keep || self.case.is_some(),
            oracle: !self.no_oracle,
            rivals: !self.no_rivals,
        })
    }

    fn prove_real(&self, settings: &Settings, asked: &Asked, mut outputs: Outputs) -> Result<(), Error> {
        let only = real::Asked { sets: self.set.clone(), folds: self.folds, workers: settings.workers };
        let (outcomes, skipped) = real::run(&self.data, &settings.out, &settings.tool, &only)?;
        if let Some(json) = asked.json {
            let content = serde_json::json!({ "outcomes": outcomes, "skipped": skipped });
            let text = formats::json(&content, &Provenance::of(&outputs, None)?)?;
            output::text(&mut outputs, json, &text)?;
        }
        let table = real::table(&outcomes);
        asked.tabled(("Real machines with known effects hidden", &table, "", &skipped), &mut outputs)?;
        outputs.finish()?;
        let skipped: String = skipped.iter().map(|line| format!("{line}\n")).collect();
        output::print(&(text::aligned(&table) + &skipped))
    }

    fn prove_followed(
        &self,
        settings: &Settings,
        asked: &Asked,
        seeds: &[u64],
        mut outputs: Outputs,
    ) -> Result<(), Error> {
        let only = follow::Asked { seeds: seeds.to_vec(), sets: self.set.clone(), changes: self.change.clone() };
        let (outcomes, skipped) = follow::run(&self.data, settings, &only)?;
        let table = follow::table(&outcomes);
        if let Some(json) = asked.json {
            let content = serde_json::json!({ "outcomes": outcomes, "skipped": skipped });
            let text = formats::json(&content, &Provenance::of(&outputs, None)?)?;
            output::text(&mut outputs, json, &text)?;
        }
        let summary = follow::summary(&outcomes);
        asked.tabled(("Answers that must follow", &table, &summary, &skipped), &mut outputs)?;
        outputs.finish()?;
        let skipped: String = skipped.iter().map(|line| format!("{line}\n")).collect();
        output::print(&(text::aligned(&table) + &summary + &skipped))
    }

    fn seeds(&self) -> Result<Vec<u64>, Error> {
        if let Some(seed) = self.case {
            return Ok(vec![seed]);
        }
        let round = match self.plan {
            Version::Fixed => plan().len() as u64,
            Version::Drawn => ROUND,
            Version::Steps => plan_of_steps().len() as u64,
        };
        let (mut seeds, mut met) = (Vec::new(), BTreeSet::new());
        for seed in self.first..self.first.saturating_add(self.count.unwrap_or(round)) {
            let (arm, effects) = self.arm(seed)?;
            let wanted = |id: &&str| self.effect.iter().any(|wanted| wanted == id);
            if (self.arm.is_empty() || self.arm.contains(&arm))
                && (self.effect.is_empty() || effects.iter().any(wanted))
            {
                seeds.push(seed);
            }
            met.extend(effects);
        }
        // A plan may conceal what no diagnosis names.
        if let Some(id) = self.effect.iter().find(|id| find(id).is_none() && !met.contains(id.as_str())) {
            return Err(unknown_effect(id));
        }
        if self.quick {
            seeds = self.two_of_each_arm(&seeds)?;
        }
        let (share, shares) = self.shard.unwrap_or((1, 1));
        seeds.retain(|seed| seed % shares == share - 1);
        if seeds.is_empty() {
            return Err(Error::Usage("no case is left by these flags".to_owned()));
        }
        Ok(seeds)
    }

    fn arm(&self, seed: u64) -> Result<(Arm, Vec<&'static str>), Error> {
        subject::arm(self.plan, seed).map_err(|error| Error::Usage(error.to_string()))
    }

    /// The first case of each arm and the one in the middle, by seed.
    fn two_of_each_arm(&self, seeds: &[u64]) -> Result<Vec<u64>, Error> {
        let mut by_arm: BTreeMap<Arm, Vec<u64>> = BTreeMap::new();
        for &seed in seeds {
            by_arm.entry(self.arm(seed)?.0).or_default().push(seed);
        }
        let mut chosen: Vec<u64> = by_arm.values().flat_map(|seeds| [seeds[0], seeds[seeds.len() / 2]]).collect();
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }
}

/// Seals the cases, then runs them.
fn prove(seeds: &[u64], settings: &Settings) -> Result<Ran, Error> {
    let (cases, failures, hash) = run::seal(seeds, settings)?;
    output::print(&format!("{} cases, sealed: SHA-256 {hash} of sealed/SHA256SUMS\n\n", cases.len()))?;
    let mut ran = run::run(&cases, settings)?;
    ran.failures.extend(failures);
    Ok(ran)
}
