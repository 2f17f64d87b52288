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
  servo-lab record --port /dev/ttyUSB0 --for-s 10 --out run.csv
  servo-lab record --elf er-servo --tcp localhost:9090 --for-s 10 --out run.csv";
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
  servo-lab stability --delay-ms 5 --html stability.html";
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
  servo-lab help diagnose";
pub(super) const COMPLETIONS: &str = "\
Example:
  servo-lab completions bash > ~/.local/share/bash-completion/completions/servo-lab";
pub(super) const MAN: &str = "\
Example:
  servo-lab man --out ~/.local/share/man/man1";

pub(super) const GUIDE: &str = "\
Example:
  servo-lab guide --only coulomb_friction,backlash --out out/guide";
