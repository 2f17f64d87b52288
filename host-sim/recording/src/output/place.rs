//! Where an output goes, and whether two paths are one file.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

/// More links on the way to a file than systems follow: a circle.
const MOST_LINKS: usize = 40;

/// The absolute path without links, `.` and `..` of a file that need not exist yet.
///
/// # Errors
///
/// A circle of links, a working folder that is gone.
pub(super) fn resolved(file: &Path) -> io::Result<PathBuf> {
    let mut place = PathBuf::new();
    let mut left = parts(&std::path::absolute(file)?);
    let mut links = 0;
    while let Some(part) = left.pop_front() {
        if part == ".." {
            place.pop();
            continue;
        }
        let next = place.join(&part);
        match fs::read_link(&next) {
            Ok(link) => {
                links += 1;
                if links > MOST_LINKS {
                    return Err(io::Error::other("its links lead in a circle"));
                }
                // An absolute one begins with the root, which `join` starts anew from.
                for part in parts(&link).into_iter().rev() {
                    left.push_front(part);
                }
            }
            // No link, or not there.
            Err(_) => place = next,
        }
    }
    Ok(place)
}

fn parts(path: &Path) -> VecDeque<OsString> {
    let kept = path.components().filter(|part| *part != Component::CurDir);
    kept.map(|part| part.as_os_str().to_owned()).collect()
}

/// What makes a file the same as another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Identity {
    pub(super) path: PathBuf,
    /// Device and number on it: two names of one file (hard links) share them. None before the file exists.
    #[cfg(unix)]
    number: Option<(u64, u64)>,
}

impl Identity {
    /// Of a file that need not exist.
    ///
    /// # Errors
    ///
    /// As [`resolved`].
    pub(super) fn of(file: &Path) -> io::Result<Self> {
        let path = resolved(file)?;
        #[cfg(unix)]
        let number = {
            use std::os::unix::fs::MetadataExt as _;
            fs::metadata(&path).ok().map(|there| (there.dev(), there.ino()))
        };
        Ok(Self {
            path,
            #[cfg(unix)]
            number,
        })
    }

    /// Whether both are one file.
    pub(super) fn is(&self, other: &Self) -> bool {
        #[cfg(unix)]
        if self.number.is_some() && self.number == other.number {
            return true;
        }
        self.path == other.path
    }
}

/// The folder a file is in.
pub(super) fn folder_of(file: &Path) -> PathBuf {
    let above = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    above.map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Makes a folder and those above it; gives those that were not there, the outermost first.
pub(super) fn make_folder(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut missing = Vec::new();
    for above in folder.ancestors().filter(|above| !above.as_os_str().is_empty()) {
        if above.is_dir() {
            break;
        }
        if above.exists() {
            return Err(io::Error::other(format!("{} is no folder", above.display())));
        }
        missing.push(above.to_path_buf());
    }
    missing.reverse();
    fs::create_dir_all(folder)?;
    Ok(missing)
}
