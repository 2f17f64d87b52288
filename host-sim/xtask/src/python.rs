//! The Python package: an environment with the versions of the lock file, a wheel by maturin, its tests.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::root;
use crate::run::{cargo, output, run};

/// Exits with 0 where this Python can build the package and has what an environment is made with.
const FIT: &str = "import sys, venv, ensurepip; sys.exit(sys.version_info < (3, 11))";

/// As [`test()`], in an environment that has been made; where that could not be, says why and goes on, but not in CI.
///
/// # Errors
///
/// As [`test()`].
pub fn in_all_tests(environment: Result<Environment, String>) -> Result<(), String> {
    match environment {
        Ok(environment) => environment.test(),
        Err(reason) if std::env::var_os("CI").is_none() => {
            println!("skipped: {reason}");
            Ok(())
        }
        Err(reason) => Err(reason),
    }
}

/// Builds the package and runs its tests, notebook and snippets of the book included.
///
/// # Errors
///
/// No Python, packages that cannot be installed, a failed build or test.
pub fn test() -> Result<(), String> {
    environment()?.test()
}

/// A virtual environment under `target`.
pub struct Environment {
    folder: PathBuf,
}

/// The environment with the packages of the lock file, made where it is not there or the file has changed.
///
/// # Errors
///
/// No Python that fits, packages that cannot be installed.
pub fn environment() -> Result<Environment, String> {
    let folder = root().join("target/python");
    let (environment, lock) = (Environment { folder: folder.clone() }, package().join("requirements.lock"));
    let wanted = fs::read(&lock).map_err(|error| format!("{}: {error}", lock.display()))?;
    let stamp = folder.join("installed.lock");
    if fs::read(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(environment);
    }
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    if output(Command::new(&python).args(["-c", FIT])).is_none() {
        return Err(format!(
            "the Python package needs Python 3.11 or newer with venv, and `{}` is none; on Debian `apt-get install python3 \
             python3-venv`, or name another one in PYTHON",
            Path::new(&python).display()
        ));
    }
    let mut venv = Command::new(&python);
    venv.args(["-m", "venv", "--clear"]).arg(folder.join("venv"));
    run(venv)?;
    let mut install = environment.command("pip");
    install.args(["install", "--quiet", "--disable-pip-version-check", "--no-deps", "--requirement"]).arg(&lock);
    run(install)?;
    fs::write(&stamp, wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
    Ok(environment)
}

/// The package's folder.
fn package() -> PathBuf {
    root().join("host-sim/python")
}

impl Environment {
    /// A program of the environment.
    fn command(&self, program: impl AsRef<OsStr>) -> Command {
        let mut command = Command::new(self.folder.join("venv/bin").join(program.as_ref()));
        command.current_dir(root());
        command
    }

    fn test(&self) -> Result<(), String> {
        // Both packages: with the same features as the wheel, nothing is compiled twice.
        let packages = ["--package", "lab", "--package", "servo-lab-python", "--bin", "servo-lab"];
        run(cargo(&root(), &[&["build", "--release"], &packages[..]].concat()))?;
        let wheel = self.wheel()?;
        let mut install = self.command("pip");
        install.args(["install", "--quiet", "--disable-pip-version-check", "--no-deps", "--force-reinstall"]);
        install.arg(&wheel);
        run(install)?;
        // Not in the package's folder: Python would take the sources there for the package that is installed.
        let mut tests = self.command("pytest");
        tests.current_dir(package().join("tests")).env("SERVO_LAB", root().join("target/release/servo-lab"));
        tests.env("PYTHONDONTWRITEBYTECODE", "1");
        run(tests)
    }

    /// Builds the wheel, the only one in its folder.
    fn wheel(&self) -> Result<PathBuf, String> {
        let wheels = self.folder.join("wheels");
        // One of an earlier version is none of ours to install.
        let _ = fs::remove_dir_all(&wheels);
        let mut maturin = self.command("maturin");
        maturin.args(["build", "--release", "--quiet", "--out"]).arg(&wheels);
        maturin.arg("--manifest-path").arg(package().join("Cargo.toml"));
        maturin.arg("--interpreter").arg(self.folder.join("venv/bin/python"));
        run(maturin)?;
        let unreadable = |error: std::io::Error| format!("{}: {error}", wheels.display());
        let mut files = fs::read_dir(&wheels).map_err(unreadable)?;
        let file = files.next().ok_or_else(|| format!("{}: maturin wrote no wheel", wheels.display()))?;
        file.map(|file| file.path()).map_err(unreadable)
    }
}
