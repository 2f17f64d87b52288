//! `servo-lab simulate`.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use er_servo::experiment::{Experiment, MAX_TONES, Shape};

use super::Overwrite;
use super::experiment_flags::refused;
use super::machine::MachineArgs;
use crate::beyond::{self, MODES};
use crate::read::{BESIDE_THE_LAW, Recording};
use crate::simulate::{
    Disturbance, Reference, Row, Scenario, Setup, Summary, figure, period_s, record, run as run_loop,
};
use crate::{Error, output};

/// Flags whose name is another than that of the value of an experiment, or that have a second one.
const FLAGS: &[(&str, &str)] = &[
    ("travel_rad", "amplitude-deg (or --travel-deg)"),
    ("from_hz", "low-hz (or --from-hz)"),
    ("to_hz", "high-hz (or --to-hz)"),
];

/// The built-in scenarios.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// One step of --amplitude-deg.
    Step,
    /// A new level within --amplitude-deg after each --dwell-s, drawn from --seed.
    Steps,
    /// So many --tones from --low-hz to --high-hz.
    Multisine,
    /// One sine from --low-hz to --high-hz.
    Chirp,
    /// To and fro over --amplitude-deg at --speed-rad-s.
    Ramp,
    /// At rest, pushed by --disturbance (8 N m for 50 ms unless given).
    Disturbance,
}

/// Flags of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// What the reference does.
    #[arg(value_enum, default_value = "step", conflicts_with = "reference")]
    scenario: Kind,
    /// Reference from a CSV file with the columns t_s and reference_rad, in place of a scenario.
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    machine: MachineArgs,
    /// Duration, s.
    #[arg(long, default_value_t = 2.0)]
    duration_s: f32,
    /// Amplitude, degrees.
    #[arg(long, visible_alias = "travel-deg", default_value_t = 30.0, allow_negative_numbers = true)]
    amplitude_deg: f32,
    /// Time at each level of steps, s.
    #[arg(long, default_value_t = 0.4)]
    dwell_s: f32,
    /// Lowest frequency, or that at the start of a chirp, Hz.
    #[arg(long, visible_alias = "from-hz", default_value_t = 0.2)]
    low_hz: f32,
    /// Highest frequency, or that at the end of a chirp, Hz.
    #[arg(long, visible_alias = "to-hz", default_value_t = 8.0)]
    high_hz: f32,
    /// Number of tones of a multisine.
    #[arg(long, default_value_t = MAX_TONES)]
    tones: u8,
    /// Speed of the ramp, rad/s.
    #[arg(long, default_value_t = 1.0)]
    speed_rad_s: f32,
    /// Push from outside: start s, duration s, torque N m; may be repeated.
    #[arg(long, value_name = "START,DURATION,TORQUE", value_parser = disturbance, allow_hyphen_values = true)]
    disturbance: Vec<Disturbance>,
    /// Standard deviation of noise on the measured angle, rad.
    #[arg(long, default_value_t = 0.0)]
    sensor_noise_rad: f64,
    /// Standard deviation of a torque noise held over each tick, N m.
    #[arg(long, default_value_t = 0.0)]
    torque_noise_nm: f64,
    /// Of the noises and of steps; the same seed gives the same recording.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// The law takes the true speed, and its brake has no dead-band, as the paper's equations assume.
    #[arg(long)]
    true_speed: bool,
    /// The brake also holds at rest.
    #[arg(long)]
    hold: bool,
    /// Control beside the flashed law, as `paper --beyond` compares it; it is told the delays, the friction and the damper of the
    /// paper's servo, and is not in the firmware.
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(MODES.map(|mode| mode.key)))]
    mode: Option<String>,
    /// Draw position, error, speed, torque and field, commanded and acting.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Recording to write, .csv, .parquet or .mcap; without one, only the summary is printed.
    #[arg(long, short, value_name = "FILE", value_parser = recording_name)]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Refused before the run, and not after it.
fn recording_name(text: &str) -> Result<PathBuf, String> {
    let file = PathBuf::from(text);
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("csv" | "parquet" | "mcap") => Ok(file),
        _ => Err("the name of a recording must end in .csv, .parquet or .mcap".to_owned()),
    }
}

fn disturbance(text: &str) -> Result<Disturbance, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [start_s, duration_s, torque_nm] if numbers.iter().all(|number| number.is_finite()) => {
            Ok(Disturbance { start_s, duration_s, torque_nm })
        }
        _ => Err("three finite numbers are expected: start s, duration s, torque N m".to_owned()),
    }
}

/// Runs the loop, writes the recording, prints the summary.
///
/// # Errors
/// Flags or files that cannot be followed, or an output that cannot be written.
pub fn run(args: &Args) -> Result<(), Error> {
    let mut files = args.overwrite.files();
    files.reads_all(args.machine.machine.iter().chain(&args.reference));
    let out = args.out.as_ref().map(|file| files.writes(file));
    let plot = args.plot.as_ref().map(|file| files.writes(file));
    let mut outputs = files.check()?;
    let run = args.simulate()?;
    let Simulated { rows, period_s, damper, .. } = &run;
    if let Some(out) = out {
        let file = outputs.file(out).to_path_buf();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        outputs.recording(out, &run.recording(&name))?;
    }
    if let Some(plot) = plot {
        output::figure(&mut outputs, plot, &figure(rows, *damper))?;
    }
    outputs.finish()?;
    if let Some(out) = out {
        let file = outputs.file(out).display();
        output::print(&format!("wrote {file}: {} rows, seed {}\n", rows.len(), args.seed))?;
    }
    if let Some(plot) = plot {
        output::print(&format!("wrote {}\n", outputs.file(plot).display()))?;
    }
    output::print(&Summary::of(rows, *period_s).to_string())?;
    Ok(())
}

/// A run of the closed loop.
#[derive(Debug)]
pub struct Simulated {
    /// One a control period.
    pub rows: Vec<Row>,
    /// s.
    pub period_s: f64,
    /// a and b of the damper's torque, for [`figure`]; none without one.
    pub damper: Option<(f64, f64)>,
    /// Mode that stood beside the flashed law.
    mode: Option<&'static beyond::Mode>,
}

impl Simulated {
    /// What the drive would have logged; a column names the mode that stood beside the law, for no law replays its commands.
    #[must_use]
    pub fn recording(&self, name: &str) -> Recording {
        let beside = self.mode.map(|mode| (BESIDE_THE_LAW.to_owned(), vec![mode.key.to_owned(); self.rows.len()]));
        Recording { extra: beside.into_iter().collect(), ..record(name, &self.rows) }
    }
}

impl Args {
    /// Runs the loop; writes nothing.
    ///
    /// # Errors
    /// Flags or files that cannot be followed.
    pub fn simulate(&self) -> Result<Simulated, Error> {
        let (model, config) = self.machine.build()?;
        let config = self.law(config);
        let scenario = self.scenario()?;
        let setup = Setup {
            model,
            config,
            disturbances: scenario.disturbances,
            sensor_noise_rad: self.sensor_noise_rad,
            torque_noise_nm: self.torque_noise_nm,
            seed: u64::from(self.seed),
        };
        let period_s = period_s(&config);
        let damper = setup.model.er.as_ref().map(plant::Er::acting);
        let mode = self.mode.as_deref().and_then(beyond::find);
        if let Reference::Experiment(experiment) = &scenario.reference {
            experiment.start(period_s as f32).map_err(|error| refused(&error, FLAGS))?;
        }
        let reference = scenario.reference.positions(period_s)?;
        let rows = match mode {
            None => run_loop(&setup, reference)?,
            Some(mode) => beyond::run(mode, &setup, reference)
                .map_err(|error| Error::Usage(format!("--mode {}: {error}", mode.key)))?,
        };
        if mode.is_some() && !beyond::is_told(&setup.model) {
            eprintln!(
                "warning: --mode knows the rotor, friction, damper and delays of the paper's machine, and this is another one"
            );
        }
        Ok(Simulated { rows, period_s, damper, mode })
    }

    /// The law of the machine with what the flags change.
    fn law(&self, config: er_servo::Config) -> er_servo::Config {
        let config = er_servo::Config { hold: config.hold || self.hold, ..config };
        if !self.true_speed {
            return config;
        }
        er_servo::Config { speed_from_converter: true, brake_deadband_rad_s: 0.0, ..config }
    }

    fn scenario(&self) -> Result<Scenario, Error> {
        let reference = match &self.reference {
            Some(file) => Reference::read(file)?,
            None => Reference::Experiment(Experiment { shape: self.shape(), duration_s: self.duration_s }),
        };
        let mut disturbances = self.disturbance.clone();
        if disturbances.is_empty() && self.scenario == Kind::Disturbance {
            // The push of control.md section 7.
            disturbances.push(Disturbance { start_s: 0.1, duration_s: 0.05, torque_nm: 8.0 });
        }
        Ok(Scenario { reference, disturbances })
    }

    fn shape(&self) -> Shape {
        let amplitude_rad = self.amplitude_deg.to_radians();
        let (low_hz, high_hz) = (self.low_hz, self.high_hz);
        match self.scenario {
            Kind::Step => Shape::Step { amplitude_rad },
            Kind::Steps => Shape::Steps { amplitude_rad, dwell_s: self.dwell_s, seed: self.seed },
            Kind::Multisine => Shape::Multisine { amplitude_rad, low_hz, high_hz, tones: self.tones },
            Kind::Chirp => Shape::Chirp { amplitude_rad, from_hz: low_hz, to_hz: high_hz },
            Kind::Ramp => Shape::Ramp { speed_rad_s: self.speed_rad_s, travel_rad: amplitude_rad },
            Kind::Disturbance => Shape::Step { amplitude_rad: 0.0 },
        }
    }
}
