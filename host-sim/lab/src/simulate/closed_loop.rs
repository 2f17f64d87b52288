//! Law and plant, tick by tick.

use er_servo::{
    Config, Counts, InputFlags, Inputs, Mode as LawMode, MonitorCode, Outputs, Params, ResolverCode, ResolverSample,
    State, step,
};
use plant::{Command, Model, Plant};
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, Normal};

use crate::Error;
use crate::read::{AxisKind, Recording};
use crate::replay::mode_of;

/// An external torque for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disturbance {
    /// Start, s.
    pub start_s: f64,
    /// Duration, s.
    pub duration_s: f64,
    /// N m.
    pub torque_nm: f64,
}

/// What a simulation is made of.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The machine.
    pub model: Model,
    /// The control law.
    pub config: Config,
    /// Pushes from outside.
    pub disturbances: Vec<Disturbance>,
    /// Standard deviation of white noise on the measured angle before the converter, rad.
    pub sensor_noise_rad: f64,
    /// Standard deviation of a torque noise held over each tick, N m.
    pub torque_noise_nm: f64,
    /// Of both noises; the same seed gives the same recording.
    pub seed: u64,
}

/// The running loop. One [`Self::tick`] is one control period.
#[derive(Debug)]
pub struct ClosedLoop {
    plant: Plant,
    params: Params,
    state: State,
    period_s: f64,
    disturbances: Vec<Disturbance>,
    sensor_noise: Noise,
    torque_noise: Noise,
    /// Held by the high-voltage amplifier since the last tick.
    field_kv_mm: f32,
    tick: u32,
}

/// One tick as it is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// s.
    pub t_s: f64,
    /// Reference, counts.
    pub reference: Counts,
    /// True position and speed when the position was sampled.
    pub truth: plant::State,
    /// What the law decided.
    pub outputs: Outputs,
}

impl ClosedLoop {
    /// Running, at rest at 0.
    ///
    /// # Errors
    /// A model or a configuration with a value that is not allowed.
    pub fn new(setup: &Setup) -> Result<Self, Error> {
        let params = Params::new(&setup.config).map_err(|error| Error::Usage(format!("[controller] {error}")))?;
        let unusable = |error: plant::Error| Error::Usage(format!("the plant cannot be simulated: {error}"));
        Ok(Self {
            plant: Plant::new(&setup.model, plant::State::default(), 0.0).map_err(unusable)?,
            params,
            state: State::running_at(Counts(0)),
            period_s: f64::from(setup.config.period_s),
            disturbances: setup.disturbances.clone(),
            sensor_noise: Noise::new(setup.sensor_noise_rad, setup.seed)?,
            // A stream of its own, so that turning one noise off leaves the other as it was.
            torque_noise: Noise::new(setup.torque_noise_nm, !setup.seed)?,
            field_kv_mm: 0.0,
            tick: 0,
        })
    }

    /// One control period: sample, one step of the law, the plant to the next sample.
    ///
    /// # Errors
    /// A simulated quantity that left the finite numbers.
    pub fn tick(&mut self, reference: Counts) -> Result<Row, Error> {
        let t_s = f64::from(self.tick) * self.period_s;
        let truth = *self.plant.state();
        let measured = Counts::from_rad(truth.position + self.sensor_noise.draw());
        let inputs = Inputs {
            resolver: ResolverSample {
                code: ResolverCode((measured.0 & 0x0fff) as u16),
                fault_byte: 0,
                speed_rad_s: truth.velocity as f32,
            },
            flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE,
            reference,
            field_monitor: MonitorCode::from_kv_mm(self.field_kv_mm),
            ..Inputs::default()
        };
        let outputs = step(&self.params, &mut self.state, &inputs);
        let command = Command {
            torque: f64::from(outputs.torque_nm),
            field_kv_mm: f64::from(outputs.field_kv_mm),
            braking: outputs.mode == LawMode::Brake,
            speed_estimate: f64::from(outputs.speed_rad_s),
            external_torque: self.external_torque_nm(t_s),
        };
        self.field_kv_mm = outputs.field_kv_mm;
        self.tick += 1;
        self.plant
            .advance(&command, f64::from(self.tick) * self.period_s)
            .map_err(|error| Error::Usage(format!("the simulation stopped at {t_s} s: {error}")))?;
        Ok(Row { t_s, reference, truth, outputs })
    }

    fn external_torque_nm(&mut self, t_s: f64) -> f64 {
        let pushes = self.disturbances.iter();
        let pushes = pushes.filter(|push| t_s >= push.start_s && t_s < push.start_s + push.duration_s);
        pushes.map(|push| push.torque_nm).sum::<f64>() + self.torque_noise.draw()
    }
}

/// White normal noise from a seed.
#[derive(Debug, Clone)]
struct Noise {
    distribution: Normal<f64>,
    random: StdRng,
}

impl Noise {
    fn new(deviation: f64, seed: u64) -> Result<Self, Error> {
        let refuse = || Error::Usage(format!("a noise of {deviation} is not allowed, 0 or more is"));
        if !(deviation.is_finite() && deviation >= 0.0) {
            return Err(refuse());
        }
        let distribution = Normal::new(0.0, deviation).map_err(|_| refuse())?;
        Ok(Self { distribution, random: StdRng::seed_from_u64(seed) })
    }

    fn draw(&mut self) -> f64 {
        // Without noise nothing is drawn: the loop runs thousands of times real time.
        if self.distribution.std_dev() > 0.0 { self.distribution.sample(&mut self.random) } else { 0.0 }
    }
}

/// Runs the loop along a reference and keeps every row.
///
/// # Errors
/// See [`ClosedLoop`].
pub fn run(setup: &Setup, reference: impl IntoIterator<Item = Counts>) -> Result<Vec<Row>, Error> {
    let mut closed_loop = ClosedLoop::new(setup)?;
    reference.into_iter().map(|counts| closed_loop.tick(counts)).collect()
}

/// The rows as a recording: what the drive itself would have logged, not the truth.
pub fn record(name: &str, rows: &[Row]) -> Recording {
    let column = |value: fn(&Row) -> f64| rows.iter().map(value).collect::<Vec<f64>>();
    Recording {
        name: name.to_owned(),
        axis: AxisKind::Rotary,
        t_s: column(|row| row.t_s),
        position: column(|row| row.outputs.position.to_rad()),
        effort_cmd: column(|row| f64::from(row.outputs.torque_nm)),
        reference: Some(column(|row| row.reference.to_rad())),
        field_cmd_kv_mm: Some(column(|row| f64::from(row.outputs.field_kv_mm))),
        mode: Some(rows.iter().map(|row| mode_of(row.outputs.mode)).collect()),
        velocity: Some(column(|row| f64::from(row.outputs.speed_rad_s))),
        effort_meas: None,
        field_meas_kv_mm: None,
        temperature_c: None,
        seq: Some((0..rows.len() as u64).collect()),
        fault: Some(rows.iter().map(|row| u32::from(row.outputs.supervisor.faults().bits())).collect()),
        counts: Some(rows.iter().map(|row| i64::from(row.outputs.position.0)).collect()),
        gaps: Vec::new(),
        extra: Vec::new(),
    }
}
