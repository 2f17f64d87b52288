//! The score as the text that is kept in the repository.

use std::path::Path;
use std::process::Command;

use serde::{Deserialize, Serialize};

use super::run::Ran;
use super::text::{self, Table, markdown};
use super::{Outcome, Score};
use crate::Error;

/// What made a score.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// The command as it was typed, without the folders of the machine it ran on.
    pub command: String,
    /// Commit of the sources that lie here, and whether they differ from it.
    pub commit: String,
    /// SHA-256 of the program that diagnosed.
    pub program: String,
    /// Lowest and highest seed.
    pub seeds: [u64; 2],
}

impl Origin {
    /// Of this run.
    ///
    /// # Errors
    /// A program that cannot be read.
    pub fn now(program: &Path, ran: &Ran) -> Result<Self, Error> {
        let bytes = std::fs::read(program).map_err(|error| Error::input(program, None, "", error.to_string()))?;
        let git = |arguments: &[&str]| {
            let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success());
            output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
        };
        let commit = git(&["rev-parse", "HEAD"]).unwrap_or_else(|| "unknown: not run inside the repository".to_owned());
        let changed = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|text| !text.is_empty());
        let seeds =
            || ran.outcomes.iter().map(|outcome| outcome.truth.seed).chain(ran.failures.iter().map(|(seed, _)| *seed));
        Ok(Self {
            command: command(std::env::args().skip(1)),
            commit: if changed { format!("{commit}, with changes") } else { commit },
            program: conceal::seal::hash(&bytes),
            seeds: [seeds().min().unwrap_or(0), seeds().max().unwrap_or(0)],
        })
    }
}

/// Everything a run found, as JSON has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// What made it.
    pub origin: Origin,
    /// The counts.
    pub score: Score,
    /// Case by case.
    pub outcomes: Vec<Outcome>,
}

/// The results as Markdown.
pub fn document(results: &Results) -> String {
    let Results { origin, score, outcomes } = results;
    let [first, last] = origin.seeds;
    let mut text = format!(
        "# Proof on concealed effects\n\nMade by `{}`; seeds {first} to {last}, {} cases, {} without an answer. Sources at \
         {}; SHA-256 of the program that diagnosed: {}.\n\nWritten by the command. What had been \
         looked into before a round is in `docs/scores.md`.\n\n",
        origin.command,
        outcomes.len(),
        score.failures.len(),
        origin.commit,
        origin.program
    );
    for (title, table) in [
        ("Pass line", text::pass(score)),
        ("Arms", text::arms(score)),
        ("Conclusions", text::verdicts(score)),
        ("Detectable sizes", text::power(score)),
        ("Before and after the proposed experiment", text::experiment(score)),
        ("Rivals on the same files", text::rivals(score)),
        ("Confusions", text::confusion(score)),
        ("Intervals", text::coverage(score)),
        ("Misses, each again with `servo-lab prove --case SEED`", text::misses(score, outcomes)),
    ] {
        text += &format!("## {title}\n\n{}\n", markdown(&table));
    }
    text += "## Figures\n\n";
    text += &text::figures(score).iter().map(|line| format!("- {line}\n")).collect::<String>();
    text
}

/// One table as Markdown, with the reasons where there is no answer.
pub fn table_document(title: &str, table: &Table, without: &[String]) -> String {
    let table = markdown(table);
    let without: String = without.iter().map(|line| format!("\n{line}\n")).collect();
    format!("# {title}\n\nMade by `{}`.\n\n{table}{without}", command(std::env::args().skip(1)))
}

/// The command with those words: of a path from the root only its last part, for the rest is of one machine.
fn command(words: impl Iterator<Item = String>) -> String {
    let told = |word: String| match Path::new(&word) {
        path if path.is_absolute() => path.file_name().map_or(word.clone(), |name| name.to_string_lossy().into_owned()),
        _ => word,
    };
    std::iter::once("servo-lab".to_owned()).chain(words.map(told)).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::command;

    #[test]
    fn a_command_is_told_without_the_folders_of_a_machine() {
        let words = ["prove", "--count", "4", "--out", "/home/a/out", "--write-results", "docs/R.md", "--set", "/"];
        let told = command(words.map(str::to_owned).into_iter());
        assert_eq!(told, "servo-lab prove --count 4 --out out --write-results docs/R.md --set /");
    }
}
