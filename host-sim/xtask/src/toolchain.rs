//! A compiler for thumbv7em-none-eabihf, with rustup or without it.
//!
//! In this order: the target is installed; rustup installs it, given 20 s because it hangs rather than fails behind a
//! closed network; Debian's `rustc-web`, `cargo-web`, `rust-web-clippy` and `rust-web-src`, which build `core` from
//! source. Debian's packages are installed where they are missing and this runs as root.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use crate::run::{output, run, succeeds_within};

/// The target of the image.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const RUSTUP_LIMIT: Duration = Duration::from_secs(20);
/// After a failure rustup is left alone for this long, so that not every build waits for it.
const RUSTUP_RETRY: Duration = Duration::from_secs(24 * 3600);
const PACKAGES: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "rust-web-clippy"];
const DEBIAN_CARGO: &str = "/usr/bin/cargo";
const DEBIAN_CLIPPY: &str = "/usr/bin/cargo-clippy";
const DEBIAN_RUSTC: &str = "/usr/bin/rustc";
const DEBIAN_LIBRARY: &str = "/usr/lib/rustlib/src/rust/library";

/// How the image is compiled.
#[derive(Debug)]
pub enum Toolchain {
    /// The toolchain in use has the target.
    Installed,
    /// Debian's compiler, with `core` from source; the folder holds `rust-lld`.
    Debian {
        /// Folder to put on PATH for the linker.
        linker: PathBuf,
    },
}

impl Toolchain {
    /// Finds or installs one, and says on standard output what it set up.
    ///
    /// # Errors
    ///
    /// What was tried, and what to do.
    pub fn find(root: &Path) -> Result<Self, String> {
        if target_installed() {
            return Ok(Self::Installed);
        }
        if rustup_worth_trying(root) {
            println!("{TARGET} is not installed; asking rustup for it (at most {} s)", RUSTUP_LIMIT.as_secs());
            let mut rustup = Command::new("rustup");
            if succeeds_within(rustup.args(["target", "add", TARGET]), RUSTUP_LIMIT) && target_installed() {
                println!("rustup installed {TARGET}");
                return Ok(Self::Installed);
            }
            remember_rustup_failed(root);
        }
        Self::debian(root)
    }

    fn debian(root: &Path) -> Result<Self, String> {
        if !debian_installed() {
            install_debian()?;
        }
        let linker = linker_folder(root)?;
        let version = output(Command::new(DEBIAN_RUSTC).arg("--version")).unwrap_or_default();
        println!("{TARGET}: Debian's {version}, core from source, linker in {}", linker.display());
        Ok(Self::Debian { linker })
    }

    /// `cargo <arguments> --target thumbv7em-none-eabihf`, output in `target_dir`.
    pub fn cargo(&self, root: &Path, target_dir: &Path, arguments: &[&str]) -> Command {
        let mut command = match self {
            Self::Installed => crate::run::cargo(root, arguments),
            Self::Debian { linker } => {
                let mut command = Command::new(DEBIAN_CARGO);
                command.current_dir(root).args(arguments).arg("-Zbuild-std=core");
                // What rustup's cargo set for this process would send Debian's back to rustup's compiler.
                for variable in ["RUSTUP_TOOLCHAIN", "CARGO", "RUSTC_WRAPPER", "RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS"] {
                    command.env_remove(variable);
                }
                command.env("RUSTC", DEBIAN_RUSTC).env("RUSTDOC", "/usr/bin/rustdoc").env("RUSTC_BOOTSTRAP", "1");
                command.env("PATH", with_folder_first(linker));
                command
            }
        };
        command.args(["--target", TARGET]).arg("--target-dir").arg(target_dir);
        command
    }
}

fn sysroot() -> Option<PathBuf> {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    output(Command::new(rustc).args(["--print", "sysroot"])).map(PathBuf::from)
}

fn target_installed() -> bool {
    sysroot().is_some_and(|sysroot| sysroot.join("lib/rustlib").join(TARGET).join("lib").is_dir())
}

fn debian_installed() -> bool {
    [DEBIAN_CARGO, DEBIAN_CLIPPY, DEBIAN_RUSTC, DEBIAN_LIBRARY].iter().all(|path| Path::new(path).exists())
}

fn install_debian() -> Result<(), String> {
    let packages = PACKAGES.join(" ");
    let by_hand = format!(
        "no compiler for {TARGET}: rustup did not deliver it in {} s. Either `rustup target add {TARGET}` where there is \
         a network, or, on Debian, `apt-get install {packages}` as root",
        RUSTUP_LIMIT.as_secs()
    );
    let root_user = output(Command::new("id").arg("-u")).is_some_and(|user| user == "0");
    if !root_user || output(Command::new("apt-get").arg("--version")).is_none() {
        return Err(by_hand);
    }
    println!("{TARGET}: installing Debian's {packages}");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new("apt-get");
        command.args(["-qq", "-o", "Dpkg::Use-Pty=0"]).args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    let mut install = apt(&["install", "-y", "--no-install-recommends"]);
    install.args(PACKAGES);
    run(apt(&["update"])).and_then(|()| run(install)).map_err(|error| format!("{error}; {by_hand}"))?;
    if debian_installed() {
        Ok(())
    } else {
        Err(format!("{packages} are installed, but {DEBIAN_LIBRARY} is missing; {by_hand}"))
    }
}

/// The folder with a program `rust-lld`: rustup's own, or Debian's, or a link to `ld.lld`.
fn linker_folder(root: &Path) -> Result<PathBuf, String> {
    let rustups = sysroot().into_iter().flat_map(|sysroot| subfolders(&sysroot.join("lib/rustlib")));
    let debians = subfolders(Path::new("/usr/lib/rustlib"));
    let bins = rustups.chain(debians).map(|folder| folder.join("bin"));
    let on_path = env::split_paths(&env::var_os("PATH").unwrap_or_default()).collect::<Vec<_>>();
    if let Some(found) = bins.chain(on_path.iter().cloned()).find(|folder| folder.join("rust-lld").is_file()) {
        return Ok(found);
    }
    let Some(lld) = on_path.iter().map(|folder| folder.join("ld.lld")).find(|lld| lld.is_file()) else {
        return Err("no linker for the image: neither `rust-lld` nor `ld.lld` found; `apt-get install lld`".to_owned());
    };
    let folder = root.join("target/xtask/bin");
    let link = folder.join("rust-lld");
    let linked = fs::create_dir_all(&folder).and_then(|()| {
        // A link that is there from before is as good.
        if link.exists() { Ok(()) } else { std::os::unix::fs::symlink(&lld, &link) }
    });
    linked.map(|()| folder).map_err(|error| format!("{}: {error}", link.display()))
}

fn subfolders(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
}

fn with_folder_first(folder: &Path) -> OsString {
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = std::iter::once(folder.to_path_buf()).chain(env::split_paths(&path));
    // A folder with a colon in its name cannot be on a PATH; then the PATH stays as it is.
    env::join_paths(folders).unwrap_or(path)
}

fn failure_marker(root: &Path) -> PathBuf {
    root.join("target/xtask/rustup-did-not-answer")
}

fn rustup_worth_trying(root: &Path) -> bool {
    let failed_lately = fs::metadata(failure_marker(root))
        .and_then(|marker| marker.modified())
        .is_ok_and(|at| at.elapsed().is_ok_and(|age| age < RUSTUP_RETRY));
    !failed_lately && output(Command::new("rustup").arg("--version")).is_some()
}

fn remember_rustup_failed(root: &Path) {
    let marker = failure_marker(root);
    // Without the marker the next build waits for rustup again, no more.
    if let Some(folder) = marker.parent() {
        let _ = fs::create_dir_all(folder);
    }
    let _ = fs::write(marker, "");
}
