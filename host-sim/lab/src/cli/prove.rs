//! `servo-lab prove`.

use std::path::PathBuf;
use std::time::Duration;

use crate::prove::run::{self, Settings};
use crate::prove::{Arm, Blueprint, Outcome, plan, table};
use crate::{Error, output};

/// Cases of `--quick`, as steps through the plan.
const QUICK_STRIDE: usize = 23;

/// Flags of `prove`.
#[derive(Debug, clap::Args)]
pub struct Args {
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
    /// Only every 23rd case.
    #[arg(long)]
    quick: bool,
    /// Only share I of N, I from 1.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(u64, u64)>,
    /// Counts the outcomes of these folders together, and runs nothing.
    #[arg(long, value_name = "DIR", num_args = 1..)]
    merge: Vec<PathBuf>,
    /// Folder of seals, outcomes and, with --keep, recordings. Cases with an outcome there are not run again.
    #[arg(long, value_name = "DIR", default_value = "out/prove")]
    out: PathBuf,
    /// Diagnoses at a time.
    #[arg(long, value_name = "N", default_value_t = 2)]
    workers: usize,
    /// Threads of each diagnosis.
    #[arg(long, value_name = "N", default_value_t = 1)]
    jobs: usize,
    /// Keeps the recordings.
    #[arg(long)]
    keep: bool,
    /// Diagnoses again with the true effects only, for the held-out error to be compared with.
    #[arg(long)]
    oracle: bool,
    /// Ends a diagnosis after this long; its case is listed as not run.
    #[arg(long, value_name = "S", default_value_t = 300)]
    limit_s: u64,
    /// Writes every outcome as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
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
    let outcomes = if args.merge.is_empty() { args.prove()? } else { merged(&args.merge)? };
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(&outcomes).map_err(|error| Error::Usage(error.to_string()))?;
        output::write_text(file, &text)?;
    }
    output::print(&table::report(&outcomes))
}

impl Args {
    fn prove(&self) -> Result<Vec<Outcome>, Error> {
        let seeds = self.seeds();
        if seeds.is_empty() {
            return Err(Error::Usage("no case is left by these flags".to_owned()));
        }
        let settings = Settings {
            out: self.out.clone(),
            jobs: self.jobs.max(1),
            workers: self.workers.max(1),
            keep: self.keep || self.case.is_some(),
            oracle: self.oracle,
            limit: Duration::from_secs(self.limit_s),
        };
        let hash = run::seal(&seeds, &settings)?;
        output::print(&format!("{} cases, sealed: SHA-256 {hash} of sealed/SHA256SUMS\n", seeds.len()))?;
        let (mut outcomes, mut failures) = (Vec::new(), String::new());
        for result in run::run(&seeds, &settings)? {
            match result {
                Ok(outcome) => outcomes.push(outcome),
                Err(error) => failures.push_str(&format!("not run: {error}\n")),
            }
        }
        output::print(&failures)?;
        Ok(outcomes)
    }

    fn seeds(&self) -> Vec<u64> {
        if let Some(seed) = self.case {
            return vec![seed];
        }
        let count = self.count.unwrap_or(plan().len() as u64);
        let stride = if self.quick { QUICK_STRIDE } else { 1 };
        let wanted = |seed: &u64| self.arm.is_empty() || self.arm.contains(&Blueprint::of(*seed).arm);
        let (share, shares) = self.shard.unwrap_or((1, 1));
        let seeds = (self.first..self.first.saturating_add(count)).filter(wanted).step_by(stride);
        seeds.filter(|seed| seed % shares == share - 1).collect()
    }
}

fn merged(folders: &[PathBuf]) -> Result<Vec<Outcome>, Error> {
    let mut outcomes = Vec::new();
    for folder in folders {
        let folder = folder.join("outcomes");
        let entries = std::fs::read_dir(&folder).map_err(|error| Error::input(&folder, None, "", error.to_string()))?;
        for entry in entries {
            let file = entry.map_err(|error| Error::input(&folder, None, "", error.to_string()))?.path();
            if file.extension().is_some_and(|extension| extension == "json") {
                outcomes.push(run::read(&file)?);
            }
        }
    }
    outcomes.sort_by_key(|outcome| outcome.seed);
    outcomes.dedup_by_key(|outcome| outcome.seed);
    Ok(outcomes)
}
