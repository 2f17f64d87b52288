//! A case of either plan.

use std::path::Path;

use crate::Error;
use crate::case;
use crate::drawn;
use crate::plan::{Arm, Blueprint, Drawn, Version};
use crate::seal::Truth;

/// A case, whichever plan its seed was read by.
#[derive(Debug, Clone)]
pub enum Subject {
    /// Of the fixed plan, or of that of single steps.
    Fixed(Box<case::Case>),
    /// Of the drawn plan.
    Drawn(Box<drawn::Case>),
}

impl Subject {
    /// Draws the case of a seed.
    ///
    /// # Errors
    /// As [`drawn::Case::draw`].
    pub fn draw(version: Version, seed: u64) -> Result<Self, Error> {
        Ok(match version {
            Version::Fixed => Self::Fixed(Box::new(case::Case::draw(seed))),
            Version::Drawn => Self::Drawn(Box::new(drawn::Case::draw(seed)?)),
            Version::Steps => Self::Fixed(Box::new(case::Case::of(seed, Blueprint::of_steps(seed)))),
        })
    }

    /// The seed.
    pub fn seed(&self) -> u64 {
        self.truth().seed
    }

    /// What is concealed.
    pub fn truth(&self) -> &Truth {
        match self {
            Self::Fixed(case) => &case.truth,
            Self::Drawn(case) => &case.truth,
        }
    }

    /// Names of the recordings to fit.
    pub fn fitted(&self) -> &'static [&'static str] {
        match self {
            Self::Fixed(case) => case.fitted(),
            Self::Drawn(_) => &case::FITTED,
        }
    }

    /// Names of what is concealed.
    pub fn effects(&self) -> Vec<&str> {
        self.truth().effects.iter().map(|effect| effect.id.as_str()).collect()
    }

    /// Simulates the recordings and writes them with the machine file into a folder that is there.
    ///
    /// # Errors
    /// A motion that is lost, a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        match self {
            Self::Fixed(case) => case.write(folder),
            Self::Drawn(case) => case.write(folder),
        }
    }

    /// Plays an experiment's reference (the text of a CSV file) on the same machine, twice.
    ///
    /// # Errors
    /// A reference that is none, a motion that is lost, a file that cannot be written.
    pub fn write_experiment(&self, reference: &str, folder: &Path) -> Result<(), Error> {
        match self {
            Self::Fixed(case) => case.write_experiment(reference, folder),
            Self::Drawn(case) => case.write_experiment(reference, folder),
        }
    }
}

/// The arm of a seed, and what the fixed plan or that of steps conceals there; the drawn one does not know before it is drawn.
///
/// # Errors
/// As [`Drawn::of`].
pub fn arm(version: Version, seed: u64) -> Result<(Arm, Vec<&'static str>), Error> {
    let of = |blueprint: Blueprint| (blueprint.arm, blueprint.effects);
    Ok(match version {
        Version::Fixed => of(Blueprint::of(seed)),
        Version::Drawn => (Drawn::of(seed)?.arm, Vec::new()),
        Version::Steps => of(Blueprint::of_steps(seed)),
    })
}
