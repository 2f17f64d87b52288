//! One example for each command, for its `--help`.

pub(super) const INIT: &str = "\
Example:
  servo-lab init run1.csv --map position=pos:mm --map force=i:A*12.5 --map time=ts:us -o machine.toml
  servo-lab init arm.mcap --joint elbow
  servo-lab diagnose --machine machine.toml run1.csv";
pub(super) const CONVERT: &str = "\
Example:
  servo-lab init run.csv.gz -o machine.toml
  servo-lab convert run.csv.gz --machine machine.toml -o run.parquet";
pub(super) const DOCTOR: &str = "\
Example:
  servo-lab doctor
  servo-lab doctor run.csv --machine machine.toml";
pub(super) const SIMULATE: &str = "\
Example:
  servo-lab simulate steps --amplitude-deg 20 --out run.csv";
pub(super) const REPLAY: &str = "\
Example:
  servo-lab replay --machine machine.toml run.csv";
pub(super) const COMPARE: &str = "\
Example:
  servo-lab compare --machine machine.toml --plots out run1.csv run2.csv
  servo-lab compare --machine machine.toml --improved improved.toml --plots out --html compared.html run1.csv";
pub(super) const DELAYS: &str = "\
Example:
  servo-lab delays --machine machine.toml --plot delays.svg step30.csv step20.csv step10.csv --holdout step25.csv";
pub(super) const DECODE: &str = "\
Example:
  servo-lab decode --elf er-servo rtt.bin --out run.csv";
pub(super) const RECORD: &str = "\
Example:
  servo-lab record --port /dev/ttyUSB0 --duration-s 10 --out run.csv
  servo-lab record --elf er-servo --tcp localhost:9090 --duration-s 10 --out run.csv";
pub(super) const DIAGNOSE: &str = "\
Example:
  servo-lab diagnose --machine machine.toml --html answer.html run1.csv --holdout run2.csv
  servo-lab diagnose --machine machine.toml --json - --fail-on ambiguous,unknown run1.csv";
pub(super) const FLEET: &str = "\
Example:
  servo-lab fleet manifest.csv -o fleet.parquet --html fleet.html

The manifest has the columns machine, recordings, holdout, date, and rows such as axis7.toml,mon.csv;tue.csv,wed.csv,2026-03-31.";
pub(super) const LINK: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 enable
  servo-lab link --port /dev/ttyUSB0 run chirp --amplitude-deg 5 --to-hz 8 --duration-s 20 --enable --record run.csv
  servo-lab link --port /dev/ttyUSB0 identify --travel-deg 45 --max-torque-nm 15 --out out/identify";
pub(super) const COMMISSION: &str = "\
Example:
  servo-lab commission --port /dev/ttyUSB0 --travel-deg 45 --max-torque-nm 15 --out out/drive --save";
pub(super) const PROVE: &str = "\
Example:
  servo-lab prove --quick --out out/prove --html proof.html";
pub(super) const STABILITY: &str = "\
Example:
  servo-lab stability --drive-delay-ms 5 --html stability.html";
pub(super) const PAPER: &str = "\
Example:
  servo-lab paper --out out/paper --html paper.html";
pub(super) const TUNE: &str = "\
Example:
  servo-lab tune --machine machine.toml --phase-margin-deg 40 --out out/tune --html tune.html";
pub(super) const DEMO: &str = "\
Example:
  servo-lab demo";
pub(super) const HELP: &str = "\
Example:
  servo-lab help effects
  servo-lab help backlash
  servo-lab help diagnose
  servo-lab help link run";
pub(super) const COMPLETIONS: &str = "\
Example:
  servo-lab completions bash > ~/.local/share/bash-completion/completions/servo-lab";
pub(super) const MAN: &str = "\
Example:
  servo-lab man --out ~/.local/share/man/man1";

pub(super) const GUIDE: &str = "\
Example:
  servo-lab guide --only coulomb_friction,backlash --out out/guide";

/// For each action of `link`.
pub(super) mod link {
    pub(in crate::cli) const STATUS: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 status
  servo-lab link --tcp 127.0.0.1:4000 status --json";
    pub(in crate::cli) const EVENTS: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 events";
    pub(in crate::cli) const ENABLE: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 enable
  servo-lab link --port /dev/ttyUSB0 enable --duration-s 60";
    pub(in crate::cli) const DISABLE: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 disable";
    pub(in crate::cli) const CLEAR: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 clear";
    pub(in crate::cli) const HOME: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 home";
    pub(in crate::cli) const SET_POSITION: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 set-position --deg 90";
    pub(in crate::cli) const REFERENCE: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 reference --deg 30 --speed-rad-s 2 --max-torque-nm 10 --duration-s 5
  servo-lab link --port /dev/ttyUSB0 reference --deg=-5 --relative";
    pub(in crate::cli) const HOLD: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 hold";
    pub(in crate::cli) const RUN: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run step --amplitude-deg 20 --enable --max-torque-nm 10 --record step.csv";
    pub(in crate::cli) const STEP: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run step --amplitude-deg 20 --enable --record step.csv";
    pub(in crate::cli) const STEPS: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run steps --amplitude-deg 30 --dwell-s 0.5 --enable --record steps.csv";
    pub(in crate::cli) const MULTISINE: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run multisine --amplitude-deg 10 --high-hz 8 --enable --record multisine.csv";
    pub(in crate::cli) const CHIRP: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run chirp --amplitude-deg 5 --to-hz 8 --enable --record chirp.csv";
    pub(in crate::cli) const RAMP: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 run ramp --travel-deg 30 --speed-rad-s 1 --enable --record ramp.csv";
    pub(in crate::cli) const IDENTIFY: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 identify --travel-deg 45 --max-torque-nm 15 --out out/identify";
    pub(in crate::cli) const GET: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 get > before.toml
  servo-lab link --port /dev/ttyUSB0 get kp_nm_rad kd_nm_s_rad";
    pub(in crate::cli) const SET: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 set kp_nm_rad=240 kd_nm_s_rad=7
  servo-lab link --port /dev/ttyUSB0 set --from before.toml";
    pub(in crate::cli) const DEFAULTS: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 defaults";
    pub(in crate::cli) const LOAD: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 load";
    pub(in crate::cli) const SAVE: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 save";
    pub(in crate::cli) const START_RECORDING: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 start-recording 7";
    pub(in crate::cli) const STOP_RECORDING: &str = "\
Example:
  servo-lab link --port /dev/ttyUSB0 stop-recording";
}
