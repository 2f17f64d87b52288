//! A diagnosis from files, or from what was read of them: looked at, concluded.

use std::path::{Path, PathBuf};

use diagnosis::effects::Effect;

use super::{Diagnosis, Request, diagnose_on};
use crate::Error;
use crate::precheck::{self, Purpose};
use crate::progress::Course;
use crate::read::{Machine, Recording};

/// A diagnosis with what was read for it.
#[derive(Debug)]
pub struct OfFiles {
    /// The machine file.
    pub machine: Machine,
    /// Recordings to fit.
    pub recordings: Vec<Recording>,
    /// Recordings that are only predicted.
    pub holdout: Vec<Recording>,
    /// What was concluded; the answer's warnings begin with what the data themselves show.
    pub diagnosis: Diagnosis,
}

/// Diagnoses recordings with the machine file of their nominal model, and shows how far it is.
///
/// # Errors
/// Files that cannot be read, data that nothing can be computed from, and as [`diagnosis::pipeline::diagnose`].
pub fn of_files(
    machine: &Path,
    recordings: &[PathBuf],
    holdout: &[PathBuf],
    vocabulary: &[&'static Effect],
    course: &Course,
) -> Result<OfFiles, Error> {
    course.enter("reading");
    let machine = Machine::read(machine)?;
    let read = |files: &[PathBuf]| -> Result<Vec<Recording>, Error> {
        files.iter().map(|file| Recording::of(file, &machine)).collect()
    };
    let (recordings, holdout) = (read(recordings)?, read(holdout)?);
    of_recordings(machine, recordings, holdout, vocabulary, course)
}

/// Diagnoses recordings that are in memory, and shows how far it is.
///
/// # Errors
/// Data that nothing can be computed from, and as [`diagnosis::pipeline::diagnose`].
pub fn of_recordings(
    machine: Machine,
    recordings: Vec<Recording>,
    holdout: Vec<Recording>,
    vocabulary: &[&'static Effect],
    course: &Course,
) -> Result<OfFiles, Error> {
    let warnings = precheck::warnings(&machine, &recordings, &holdout, Purpose::Diagnose)?;
    let request = Request { machine: &machine, recordings: &recordings, holdout: &holdout, vocabulary };
    let mut diagnosis = diagnose_on(&request, course)?;
    diagnosis.answer.warnings.splice(0..0, warnings);
    Ok(OfFiles { machine, recordings, holdout, diagnosis })
}
