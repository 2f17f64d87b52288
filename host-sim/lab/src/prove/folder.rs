//! The folder that a run fills, and how it is known again as the tool's own.

use std::path::{Path, PathBuf};

use conceal::plan::Arm;

use crate::Error;
use crate::output::{self, Files, Output, Outputs, formats};

/// The file that says whose the folders beside it are.
const LABEL: &str = "about.md";
/// What a run fills in its folder.
const PARTS: [&str; 6] = ["sealed", "outcomes", "failures", "cases", "real", "follow"];
/// What the label says.
const WORDS: &str = "# Cases of `servo-lab prove`\n\nsealed, outcomes, failures, cases, real and follow, or one folder for each arm: a later \
                     run replaces what is in them. Keep nothing of your own there.\n";

/// Tells the files of a run in `folder`.
pub fn of_run(files: &mut Files, folder: &Path) -> Output {
    files.fills(PARTS.map(|part| folder.join(part)).to_vec(), &folder.join(LABEL))
}

/// Tells the files of cases that are only written, `ARM/SEED/` each.
pub fn of_cases(files: &mut Files, folder: &Path, cases: &[(Arm, u64)]) -> Output {
    let cases = cases.iter().map(|(arm, seed)| case(folder, *arm, *seed)).collect();
    files.fills(cases, &folder.join(LABEL))
}

/// Folder of a case that is only written.
pub fn case(folder: &Path, arm: Arm, seed: u64) -> PathBuf {
    folder.join(arm.name()).join(seed.to_string())
}

/// Writes the label: from now on the folders are the tool's own.
///
/// # Errors
/// A folder that cannot be written.
pub fn claim(outputs: &mut Outputs, label: Output) -> Result<(), Error> {
    output::text(outputs, label, &formats::markdown(WORDS))?;
    outputs.finish()
}
