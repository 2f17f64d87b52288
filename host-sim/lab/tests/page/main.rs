//! The pages that commands write, read as a browser reads them, and where there is a Chromium, by one.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod browser;
mod others;
mod structure;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use assert_cmd::Command;

const MACHINE: &str = "schema = 1\nname = \"m\"\n[axis]\nkind = \"rotary\"\nsample_period_s = 5e-4\n\
                       resolution = 1.2783173e-5\n[plant]\ninertia = 0.075\ncoulomb = 0.763\nviscous = 0.25\n\
                       torque_limit = 30\ntorque_delay_s = 0.005\n[plant.er]\na = 0.0704\nb = 0.470\ndead_time_s = 0.002\n\
                       lag_s = 0.003\n";

/// A page, and the same answer as JSON.
struct Made {
    folder: PathBuf,
    page: String,
    answer: serde_json::Value,
}

/// Runs servo-lab in the folder; what it printed.
fn lab(folder: &Path, line: &str) -> String {
    let output =
        Command::cargo_bin("servo-lab").unwrap().current_dir(folder).args(line.split_whitespace()).output().unwrap();
    assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A diagnosis of a servo whose model lacks viscous friction and takes the field for prompt; made once for all tests.
fn made() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("truth.toml"), MACHINE).unwrap();
        let nominal = MACHINE.replace("viscous = 0.25\n", "").replace("lag_s = 0.003", "lag_s = 0.001");
        fs::write(folder.join("machine.toml"), nominal).unwrap();
        let noise = "--machine truth.toml --torque-noise-nm 0.05 --sensor-noise-rad 1e-5";
        lab(&folder, &format!("simulate steps {noise} --duration-s 3 --seed 1 --out steps.csv"));
        lab(&folder, &format!("simulate multisine {noise} --amplitude-deg 15 --duration-s 3 --seed 2 --out held.csv"));
        let outputs = "--html page.html --json answer.json";
        lab(&folder, &format!("diagnose --machine machine.toml steps.csv --holdout held.csv {outputs}"));
        let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
        let (page, answer) = (read("page.html"), serde_json::from_str(&read("answer.json")).unwrap());
        Made { folder, page, answer }
    })
}
