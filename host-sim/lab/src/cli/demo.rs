//! `servo-lab demo`: the main job on embedded data, in one go.

use std::path::{Path, PathBuf};

use er_servo::experiment::{Experiment, Shape};
use plant::{Er, Model};

use crate::plot::{Figure, Mark, Panel, Series};
use crate::read::{Axis, AxisKind};
use crate::report::compare::Comparison;
use crate::simulate::{Reference, Row, Setup, Summary, record, run as run_loop};
use crate::{Error, output};

/// Seed of every noise of the demo.
const SEED: u64 = 1;
/// Period of the law's defaults, s.
const PERIOD_S: f64 = 0.0005;
/// Resolution of the resolver, rad: 491,520 counts a revolution.
const RESOLUTION_RAD: f64 = std::f64::consts::TAU / er_servo::COUNTS_PER_REV as f64;

/// Flags of `demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for the recording and the pictures; made if it is not there.
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
}

/// Runs the loop with and without field delay, records a machine that has more than its model, and compares.
///
/// # Errors
/// Outputs that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    output::folder(&args.out)?;
    output::print("1. A 30 degree step, the very control law that is flashed, with and without the fluid's delay:\n")?;
    let step = Shape::Step { amplitude_rad: std::f32::consts::FRAC_PI_6 };
    let prompt = responses(damped(0.0, 0.0), step, 0.4)?;
    let delayed = responses(damped(0.002, 0.003), step, 0.4)?;
    for (name, rows) in [("no delay", &prompt), ("2 ms dead time, 3 ms lag", &delayed)] {
        output::print(&format!("\n   {name}\n"))?;
        output::print(&indented(&Summary::of(rows, PERIOD_S)))?;
    }
    let picture = args.out.join("step.svg");
    step_figure(&prompt, &delayed).write(&picture)?;
    output::print(&format!("   wrote {}\n", picture.display()))?;

    output::print(
        "\n2. A recording of a machine whose field really waits 2 ms and lags 3 ms, with cold, stiff oil:\n",
    )?;
    let machine = Model { viscous: 0.25, ..damped(0.002, 0.003) };
    let rows = responses(machine, Shape::Steps { amplitude_rad: 0.4, dwell_s: 0.25, seed: 1 }, 8.0)?;
    let recording = record("demo.csv", &rows);
    let file = args.out.join("demo.csv");
    recording.write(&file)?;
    output::print(&format!("   wrote {}: {} rows, seed {SEED}\n", file.display(), rows.len()))?;

    output::print("\n3. The same recording beside a nominal model that knows neither:\n\n")?;
    let axis = Axis { kind: AxisKind::Rotary, sample_period_s: PERIOD_S, resolution: RESOLUTION_RAD };
    let comparison = Comparison::new(&damped(0.0, 0.0), &axis, &recording)?;
    output::print(&indented(&comparison))?;
    let picture = args.out.join("compare.svg");
    comparison.figure("demo.csv against a model without viscous friction and without field delay").write(&picture)?;
    output::print(&format!("   wrote {}\n", picture.display()))?;
    show_next(&args.out)
}

fn show_next(out: &Path) -> Result<(), Error> {
    output::print(&format!(
        "\nNext: cargo lab replay {0}/demo.csv   cargo lab simulate --help   cargo lab --help\n",
        out.display()
    ))
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
    text.to_string().lines().map(|line| format!("   {line}\n")).collect()
}
