//! Child processes: run to the end, or for a limited time.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// `cargo` of the toolchain that built this program, in `directory`.
pub fn cargo(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(directory).args(arguments);
    command
}

/// Runs to the end, with the child's output where ours goes.
///
/// # Errors
///
/// The command line and its exit code, when it fails or cannot be started.
pub fn run(mut command: Command) -> Result<(), String> {
    let shown = shown(&command);
    match command.stdin(Stdio::null()).status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{shown}` failed ({status})")),
        Err(error) => Err(format!("`{shown}` could not be started: {error}")),
    }
}

/// Starts commands that run one after another beside what comes next, up to the first that fails. What is returned waits for their end
/// and shows their output.
///
/// # Errors
///
/// As [`run`].
pub fn beside(commands: Vec<Command>) -> impl FnOnce() -> Result<(), String> {
    let all = move || {
        let mut said = String::new();
        let ended = commands.into_iter().try_for_each(|command| kept(command, &mut said));
        (said, ended)
    };
    let running = std::thread::spawn(all);
    move || {
        let (said, ended) = running.join().map_err(|_| "what ran beside the other steps ended early".to_owned())?;
        print!("{said}");
        ended
    }
}

/// Runs to the end and adds the child's output to what was `said`.
fn kept(mut command: Command, said: &mut String) -> Result<(), String> {
    let shown = shown(&command);
    let output =
        command.stdin(Stdio::null()).output().map_err(|error| format!("`{shown}` could not be started: {error}"))?;
    for part in [&output.stderr, &output.stdout] {
        said.push_str(&String::from_utf8_lossy(part));
    }
    if output.status.success() { Ok(()) } else { Err(format!("`{shown}` failed ({})", output.status)) }
}

/// Standard output of a command that succeeds, without the line end; `None` otherwise.
pub fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim_end().to_owned())
}

/// Whether the command succeeds within `limit`; it is ended when the time is up.
pub fn succeeds_within(command: &mut Command, limit: Duration) -> bool {
    let Ok(mut child) = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn() else {
        return false;
    };
    let start = Instant::now();
    while start.elapsed() < limit {
        match child.try_wait() {
            Ok(Some(status)) => return status.success(),
            Ok(None) => std::thread::sleep(Duration::from_millis(50)),
            Err(_) => return false,
        }
    }
    // Whether it could be ended or not, it did not succeed in time.
    let _ = child.kill();
    let _ = child.wait();
    false
}

fn shown(command: &Command) -> String {
    let mut words = vec![command.get_program().to_string_lossy().into_owned()];
    words.extend(command.get_args().map(|argument| argument.to_string_lossy().into_owned()));
    words.join(" ")
}
