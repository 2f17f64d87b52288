//! The files of one run, known before anything is computed.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use super::place::{self, Identity};
use super::{Growing, Staged, failed, mark, parquet_recording, temporary_beside};
use crate::{Cells, Error, Recording};

/// Everything a command will read and write, told before it begins.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let (input, report) = (folder.path().join("in.csv"), folder.path().join("new/report.md"));
/// use recording::output::Files;
///
/// let mut files = Files::new(false);
/// files.reads(&input);
/// let report = files.writes(&report);
/// let mut outputs = files.check()?; // refuses what would lose a file or cannot be written
/// // ... compute ...
/// outputs.write(report, |to| std::io::Write::write_all(to, b"done\n"))?;
/// outputs.finish()?; // all of them appear
/// # Ok::<(), recording::Error>(())
/// ```
#[derive(Debug, Default)]
pub struct Files {
    force: bool,
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
    filled: Option<Filled>,
}

/// Folders that a command fills with files whose names it need not tell.
#[derive(Debug)]
struct Filled {
    folders: Vec<PathBuf>,
    /// With the tool's mark: the folders are its own.
    label: Output,
}

/// One of the outputs that [`Files::writes`] was told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Output(usize);

/// Outputs that can be written; none of them appears before [`Outputs::finish`].
#[derive(Debug)]
pub struct Outputs {
    inputs: Vec<PathBuf>,
    outputs: Vec<PathBuf>,
    staged: Vec<Staged>,
}

impl Files {
    /// With `force`, files that servo-lab did not write are replaced too; inputs never are.
    pub fn new(force: bool) -> Self {
        Self { force, ..Self::default() }
    }

    /// Tells a file that will be read.
    pub fn reads(&mut self, file: &Path) {
        self.inputs.push(file.to_path_buf());
    }

    /// Tells files that will be read.
    pub fn reads_all<'a>(&mut self, files: impl IntoIterator<Item = &'a PathBuf>) {
        self.inputs.extend(files.into_iter().cloned());
    }

    /// Tells a file that may be written.
    pub fn writes(&mut self, file: &Path) -> Output {
        self.outputs.push(file.to_path_buf());
        Output(self.outputs.len() - 1)
    }

    /// Tells folders that will be filled, which from now on are the tool's own: anything in them may be replaced. `label`, a
    /// file outside of them that must be written first, tells so.
    pub fn fills(&mut self, folders: Vec<PathBuf>, label: &Path) -> Output {
        let label = self.writes(label);
        self.filled = Some(Filled { folders, label });
        label
    }

    /// Refuses an output that is an input or another output (by whatever name or link), that exists and was not written by
    /// servo-lab, or in whose place no file can be made; a folder to fill that holds any of them, or files and no label. Nothing
    /// is changed.
    ///
    /// # Errors
    ///
    /// [`Error::Output`] with the first such output.
    pub fn check(self) -> Result<Outputs, Error> {
        // An input that has no identity cannot be opened either, and reading it tells why.
        let inputs: Vec<_> = self.inputs.iter().filter_map(|file| Some((file, Identity::of(file).ok()?))).collect();
        let mut earlier: Vec<(&PathBuf, Identity)> = Vec::new();
        for file in &self.outputs {
            if is_stream(file) {
                continue;
            }
            let refused = |reason: String| Error::Output { file: file.clone(), reason };
            let identity = Identity::of(file).map_err(|error| failed(file, &error))?;
            if let Some((input, _)) = inputs.iter().find(|(_, input)| input.is(&identity)) {
                return Err(refused(format!("it is the input `{}`; choose another name", input.display())));
            }
            if let Some((other, _)) = earlier.iter().find(|(_, other)| other.is(&identity)) {
                return Err(refused(format!("it is the output `{}` too; choose another name", other.display())));
            }
            self.replaceable(&identity.path).map_err(refused)?;
            probe(&identity.path).map_err(|error| failed(file, &error))?;
            earlier.push((file, identity));
        }
        if let Some(filled) = &self.filled {
            let told: Vec<_> = inputs.into_iter().chain(earlier).collect();
            filled.folders.iter().try_for_each(|folder| self.may_fill(folder, filled.label, &told))?;
        }
        Ok(Outputs { inputs: self.inputs, outputs: self.outputs, staged: Vec::new() })
    }

    /// Whether a folder may be filled, and everything in it replaced.
    fn may_fill(&self, folder: &Path, label: Output, told: &[(&PathBuf, Identity)]) -> Result<(), Error> {
        let refused = |reason: String| Error::Output { file: folder.to_path_buf(), reason };
        let place = place::resolved(folder).map_err(|error| failed(folder, &error))?;
        if let Some((file, _)) = told.iter().find(|(_, one)| one.path.starts_with(&place)) {
            return Err(refused(format!(
                "it will be filled, and `{}` is in it; choose another folder",
                file.display()
            )));
        }
        match place.ancestors().find(|above| above.exists()) {
            Some(above) if !above.is_dir() => return Err(refused(format!("{} is no folder", above.display()))),
            Some(above) if above == place => {}
            _ => return Ok(()),
        }
        let is_empty = fs::read_dir(&place).map_err(|error| failed(folder, &error))?.next().is_none();
        if is_empty || self.force || mark::is_marked(&self.outputs[label.0]).unwrap_or(false) {
            return Ok(());
        }
        Err(refused("it holds files and servo-lab did not fill it; choose another, or fill it with --force".to_owned()))
    }

    /// Whether what is there may go.
    fn replaceable(&self, place: &Path) -> Result<(), String> {
        let Ok(there) = fs::metadata(place) else { return Ok(()) };
        if there.is_dir() {
            return Err("it is a folder".to_owned());
        }
        if self.force {
            return Ok(());
        }
        if there.permissions().readonly() {
            return Err("it is write-protected; choose another name, or replace it with --force".to_owned());
        }
        match mark::is_marked(place) {
            Ok(true) => Ok(()),
            Ok(false) => {
                Err("it is there and servo-lab did not write it; choose another name, or replace it with --force"
                    .to_owned())
            }
            Err(error) => Err(format!("what is there cannot be looked at ({error}); --force replaces it")),
        }
    }
}

/// Whether it is there and neither file nor folder: a pipe or a device is written into and loses nothing.
fn is_stream(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Makes a temporary file where the output will be, and removes it and the folders it needed: nothing is left of a run that
/// ends early.
fn probe(place: &Path) -> io::Result<()> {
    if place.file_name().is_none() {
        return Err(io::Error::other("it names no file"));
    }
    let made = place::make_folder(&place::folder_of(place))?;
    let made_file = temporary_beside(place).map(drop);
    for folder in made.iter().rev() {
        // Not empty any more where another program writes at the same time; then it is needed.
        let _ = fs::remove_dir(folder);
    }
    made_file
}

impl Outputs {
    /// The inputs that were told, as the user named them.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
    }

    /// The file of an output, as the user named it.
    pub fn file(&self, output: Output) -> &Path {
        &self.outputs[output.0]
    }

    /// Writes the content of an output through `fill`; it appears with [`Outputs::finish`].
    ///
    /// # Errors
    ///
    /// [`Error::Output`]; no output has appeared then, and none will.
    pub fn write(
        &mut self,
        output: Output,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
    ) -> Result<(), Error> {
        self.staged.push(Staged::new(self.file(output), fill)?);
        Ok(())
    }

    /// Writes a recording, as [`Recording::write`] does; it appears with [`Outputs::finish`].
    ///
    /// # Errors
    ///
    /// As [`Outputs::write`].
    pub fn recording(&mut self, output: Output, recording: &Recording) -> Result<(), Error> {
        self.staged.push(recording.stage(self.file(output))?);
        Ok(())
    }

    /// Writes columns of one length as a Parquet table of that name; it appears with [`Outputs::finish`].
    ///
    /// # Errors
    ///
    /// As [`Outputs::write`].
    pub fn table(&mut self, output: Output, name: &str, columns: &[(&str, Cells<'_>)]) -> Result<(), Error> {
        self.write(output, |to| parquet_recording::write_table(name, columns, to).map_err(io::Error::other))
    }

    /// Begins a recording that is written as it comes; it appears when it is finished.
    ///
    /// # Errors
    ///
    /// As [`Growing::create`].
    pub fn growing(&self, output: Output) -> Result<Growing, Error> {
        Growing::create(self.file(output))
    }

    /// Gives every output written since the last time its name.
    ///
    /// # Errors
    ///
    /// [`Error::Output`] with the first that cannot take its name.
    pub fn finish(&mut self) -> Result<(), Error> {
        self.staged.drain(..).try_for_each(Staged::finish)
    }
}
