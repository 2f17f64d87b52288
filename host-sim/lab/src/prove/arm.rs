//! What kind of question a case asks.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Arms of the proof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Arm {
    /// Nothing is concealed: nothing may be named.
    Clean,
    /// Nothing is concealed in the machine, but the log is coarse or uneven: nothing may be named.
    Decoy,
    /// One effect of the vocabulary.
    Single,
    /// Two effects of the vocabulary.
    Pair,
    /// One effect whose name is taken out of the library: `unknown` is right.
    Removed,
    /// One effect the library never knew: `unknown` is right.
    Outside,
    /// The law that ran is not the one in the machine file.
    Controller,
}

impl Arm {
    /// Every arm, in the order of the report.
    pub const ALL: [Self; 7] =
        [Self::Clean, Self::Decoy, Self::Single, Self::Pair, Self::Removed, Self::Outside, Self::Controller];

    /// Whether the right answer is to name what was concealed.
    pub fn nameable(self) -> bool {
        matches!(self, Self::Single | Self::Pair)
    }
}

impl fmt::Display for Arm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Clean => "clean",
            Self::Decoy => "decoy",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Removed => "removed",
            Self::Outside => "outside",
            Self::Controller => "controller",
        })
    }
}
