//! `servo-lab demo`: the main job on embedded data, in one go.

use std::path::PathBuf;

use diagnosis::effects::VOCABULARY;
use er_servo::experiment::{Experiment, Shape};
use plant::{Er, Model};

use super::Overwrite;
use crate::conclude::{Request, diagnose_on};
use crate::output::{self, Output, Outputs, Provenance, formats};
use crate::plot::{Figure, Mark, Panel, Series};
use crate::progress::Course;
use crate::read::{Machine, Recording};
use crate::report::compare::Comparison;
use crate::report::html::{PlotData, page};
use crate::simulate::{Reference, Row, Setup, Summary, record, run as run_loop};
use crate::{Error, report};

/// Seed of every noise of the demo.
const SEED: u64 = 1;
/// Period of the law's defaults, s.
const PERIOD_S: f64 = 0.0005;
/// The nominal model: the file is what `diagnose` and `compare` read.
const MACHINE: &str = include_str!("machine.toml");

/// Flags of `demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the recording and the pictures; made if it is not there.
    #[arg(long, short, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// The files of the demo.
struct Written {
    outputs: Outputs,
    step: Output,
    machine: Output,
    compare: Output,
    page: Output,
    recordings: [Output; 3],
}

impl Written {
    fn new(args: &Args) -> Result<Self, Error> {
        let mut files = args.overwrite.files();
        let mut writes = |name: &str| files.writes(&args.out.join(name));
        let [step, machine, compare, page] =
            ["step.svg", "machine.toml", "compare.svg", "diagnosis.html"].map(&mut writes);
        let recordings = RECORDINGS.map(writes);
        Ok(Self { step, machine, compare, page, recordings, outputs: files.check()? })
    }

    /// Lets what was written appear, and tells the name of the last.
    fn tell(&mut self, output: Output, more: &str) -> Result<(), Error> {
        self.outputs.finish()?;
        output::print(&format!("   wrote {}{more}\n", self.outputs.file(output).display()))
    }
}

/// The recordings; the last is held out.
const RECORDINGS: [&str; 3] = ["steps.csv", "multisine.csv", "chirp.csv"];

/// Runs the loop with and without field delay, records a machine that has more than its model, compares, and names what
/// the model leaves out.
///
/// # Errors
/// Outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut written = Written::new(args)?;
    steps(&mut written)?;
    let file = args.out.join("machine.toml");
    let machine = Machine::from_bytes(&file, MACHINE.as_bytes())?;
    let output = written.machine;
    output::text(&mut written.outputs, output, &formats::toml(MACHINE))?;
    output::print(
        "\n2. Recordings of a machine whose field really waits 2 ms and lags 3 ms, with cold, stiff oil:\n\n",
    )?;
    let recorded = recordings(&mut written)?;
    output::print("\n3. The first beside a nominal model that knows neither:\n\n")?;
    let comparison = Comparison::new(&damped(0.0, 0.0), &machine.axis, &recorded[0])?;
    output::print(&indented(&comparison))?;
    output::print("\n4. What the model leaves out, fitted to the first two and judged on the third:\n\n")?;
    diagnosed(&mut written, &machine, &recorded, &comparison)?;
    output::print(&format!(
        "\nNext: cargo lab diagnose --machine {0}/machine.toml --holdout {0}/chirp.csv {0}/steps.csv {0}/multisine.csv\n      \
         cargo lab replay {0}/steps.csv   cargo lab --help\n",
        args.out.display()
    ))
}

/// The step response with and without the fluid's delay.
fn steps(written: &mut Written) -> Result<(), Error> {
    output::print("1. A 30 degree step, the very control law that is flashed, with and without the fluid's delay:\n")?;
    let step = Shape::Step { amplitude_rad: std::f32::consts::FRAC_PI_6 };
    let prompt = responses(damped(0.0, 0.0), step, 0.4)?;
    let delayed = responses(damped(0.002, 0.003), step, 0.4)?;
    for (name, rows) in [("no delay", &prompt), ("2 ms dead time, 3 ms lag", &delayed)] {
        output::print(&format!("\n   {name}\n"))?;
        output::print(&indented(&Summary::of(rows, PERIOD_S)))?;
    }
    let output = written.step;
    output::figure(&mut written.outputs, output, &step_figure(&prompt, &delayed))?;
    written.tell(output, "")
}

/// Three experiments on the machine with more than its model, written and given.
fn recordings(written: &mut Written) -> Result<Vec<Recording>, Error> {
    let machine = Model { viscous: 0.25, ..damped(0.002, 0.003) };
    let shapes = [
        Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.25, seed: 1 },
        Shape::Multisine { amplitude_rad: 0.3, low_hz: 0.2, high_hz: 6.0, tones: 12 },
        Shape::Chirp { amplitude_rad: 0.2, from_hz: 0.2, to_hz: 6.0 },
    ];
    let recorded = RECORDINGS.into_iter().zip(shapes).zip(written.recordings).map(|((name, shape), output)| {
        let rows = responses(machine.clone(), shape, 5.0)?;
        let recording = record(name, &rows);
        written.outputs.recording(output, &recording)?;
        written.tell(output, &format!(": {} rows, seed {SEED}", rows.len()))?;
        Ok(recording)
    });
    recorded.collect()
}

/// Diagnoses the recordings, the last one held out, writes the answer as a page, and draws what it makes of the first.
fn diagnosed(
    written: &mut Written,
    machine: &Machine,
    recorded: &[Recording],
    nominal: &Comparison<'_>,
) -> Result<(), Error> {
    let (recordings, holdout) = recorded.split_at(2);
    let request = Request { machine, recordings, holdout, vocabulary: &VOCABULARY };
    let diagnosis = diagnose_on(&request, &Course::begin("diagnosis"))?;
    output::print(&indented(&report::summary(&diagnosis.answer)))?;
    let plot = PlotData::new(&diagnosis, recordings, holdout)?;
    let made = Provenance::of(&written.outputs, Some(SEED))?;
    let (output, page) = (written.page, page(&machine.name, &diagnosis.answer, &plot, &made)?);
    output::text(&mut written.outputs, output, &formats::markup(&page))?;
    written.tell(output, ", opens in a browser")?;
    let improved = Comparison::new(&diagnosis.improved.model_of(0), &machine.axis, &recorded[0])?;
    let title = "steps.csv beside a model without viscous friction and field delay, and with what was found";
    let output = written.compare;
    output::figure(&mut written.outputs, output, &nominal.figure(title, Some(&improved)))?;
    written.tell(output, ", before and after")
}

/// The paper's servo with a delay of the field, s.
fn damped(dead_time_s: f64, lag_s: f64) -> Model {
    Model { er: Some(Er::new(0.0704, 0.470, dead_time_s, lag_s)), ..Model::paper() }
}

fn responses(model: Model, shape: Shape, duration_s: f32) -> Result<Vec<Row>, Error> {
    let config = er_servo::Config::default();
    let setup =
        Setup { model, config, disturbances: Vec::new(), sensor_noise_rad: 0.0, torque_noise_nm: 0.0, seed: SEED };
    run_loop(&setup, Reference::Experiment(Experiment { shape, duration_s }).positions(PERIOD_S)?)
}

fn step_figure(prompt: &[Row], delayed: &[Row]) -> Figure {
    let series = |value: fn(&Row) -> f64| {
        [("no delay", prompt), ("2 ms + 3 ms", delayed)]
            .map(|(name, rows)| Series::new(name, Mark::Line, rows.iter().map(|row| (row.t_s, value(row)))))
            .to_vec()
    };
    let panel = |label, value| Panel::new("time (s)", label, series(value));
    Figure {
        title: "30 degree step of the closed loop".to_owned(),
        panels: vec![
            panel("position (rad)", |row| row.truth.position),
            panel("speed (rad/s)", |row| row.truth.velocity),
            panel("field command (kV/mm)", |row| f64::from(row.outputs.field_kv_mm)),
        ],
    }
}

fn indented(text: &impl std::fmt::Display) -> String {
    text.to_string().lines().map(|line| format!("   {line}").trim_end().to_owned() + "\n").collect()
}
