//! Law and plant, tick by tick.

use er_servo::{
    Config, Counts, InputFlags, Inputs, Mode as LawMode, MonitorCode, Outputs, Params, ResolverCode, ResolverSample,
    State, step,
};
use plant::effects::Pulse;
use plant::sensor::{LatencyLine, Sampler, SamplerConfig, SensorModel, TorqueNoise};
use plant::{Command, FluidResponse, Model, Plant};

use progress::Progress;
use recording::Error;
use recording::{AxisKind, Mode, Recording};

/// Ticks between two looks at the progress: a few milliseconds of work.
const PROGRESS_TICKS: usize = 10_000;

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

impl Disturbance {
    /// The plant's own, which need not begin or end with a tick.
    fn pulse(&self) -> Pulse {
        Pulse { start_s: self.start_s, duration_s: self.duration_s, amplitude: self.torque_nm }
    }
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
    ticks_per_s: f64,
    sensor: SensorModel,
    /// None is a sensor that reports at once.
    latency: Option<LatencyLine>,
    sampler: Sampler,
    /// Whether the fluid's delay is one of the viscosity; the others do not look at it, and it takes an exponential.
    viscosity_acts: bool,
    /// None is no noise, and draws nothing.
    torque_noise: Option<TorqueNoise>,
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
    /// Drag of the fluid that acts when the position is sampled, N m, not negative: late where the fluid is late. At rest
    /// it is the most that the fluid holds against.
    pub er_torque_nm: f64,
}

/// The control period in double precision, s: the decimal number that the configuration rounds to single precision.
pub fn period_s(config: &Config) -> f64 {
    let single = config.period_s;
    single.to_string().parse().unwrap_or(f64::from(single))
}

impl ClosedLoop {
    /// Running, at rest at 0.
    ///
    /// # Errors
    /// A model or a configuration with a value that is not allowed.
    pub fn new(setup: &Setup) -> Result<Self, Error> {
        let params = Params::new(&setup.config).map_err(|error| Error::Usage(format!("[controller] {error}")))?;
        let unusable = |error: plant::Error| Error::Usage(format!("the plant cannot be simulated: {error}"));
        let mut model = setup.model.clone();
        model.pulses.extend(setup.disturbances.iter().map(Disturbance::pulse));
        Ok(Self {
            plant: Plant::new(&model, plant::State::default(), 0.0).map_err(unusable)?,
            params,
            state: State::running_at(Counts(0)),
            ticks_per_s: period_s(&setup.config).recip(),
            viscosity_acts: model.er.as_ref().is_some_and(|er| !matches!(er.response, FluidResponse::Field(_))),
            latency: match model.sensor.latency_s {
                0.0 => None,
                latency_s => Some(LatencyLine::new(latency_s).map_err(unusable)?),
            },
            sensor: model.sensor,
            // The counts are the resolution.
            sampler: Sampler::new(
                SamplerConfig { noise_sd: setup.sensor_noise_rad, ..SamplerConfig::default() },
                setup.seed,
            )
            .map_err(unusable)?,
            // A stream of its own, so that turning one noise off leaves the other as it was.
            torque_noise: match setup.torque_noise_nm {
                0.0 => None,
                sd => Some(TorqueNoise::new(sd, !setup.seed).map_err(unusable)?),
            },
            field_kv_mm: 0.0,
            tick: 0,
        })
    }

    /// Moves the mechanics to `state`, as for a motor that is driven; the law sees it from the next tick on.
    pub fn start_from(&mut self, state: plant::State) {
        self.plant.set_state(state);
    }

    /// One control period: sample, one step of the law, the plant to the next sample.
    ///
    /// # Errors
    /// A simulated quantity that left the finite numbers.
    pub fn tick(&mut self, reference: Counts) -> Result<Row, Error> {
        self.tick_beside(reference, |_, _| {})
    }

    /// As [`Self::tick`], with something beside the flashed law that may replace the torque and the field it commands;
    /// position, speed, mode and faults stay the law's.
    ///
    /// # Errors
    /// As [`Self::tick`].
    pub fn tick_beside(
        &mut self,
        reference: Counts,
        mut beside: impl FnMut(Counts, &mut Outputs),
    ) -> Result<Row, Error> {
        let t_s = f64::from(self.tick) / self.ticks_per_s;
        let truth = *self.plant.state();
        // What the law sees is what is recorded: late where the sensor is.
        let reported = self.latency.as_mut().map_or(truth.position, |line| line.report(t_s, &truth));
        let measured = Counts::from_rad(self.sampler.measure(self.sensor.distorted(reported)));
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
        let mut outputs = step(&self.params, &mut self.state, &inputs);
        beside(reference, &mut outputs);
        let er_torque_nm = self.plant.er_torque();
        let command = Command {
            torque: f64::from(outputs.torque_nm),
            field_kv_mm: f64::from(outputs.field_kv_mm),
            braking: outputs.mode == LawMode::Brake,
            speed_estimate: f64::from(outputs.speed_rad_s),
            viscosity: if self.viscosity_acts { viscosity_nm_s_rad(&self.params, &outputs) } else { None },
            external_torque: self.torque_noise.as_mut().map_or(0.0, TorqueNoise::draw),
        };
        self.field_kv_mm = outputs.field_kv_mm;
        self.tick += 1;
        self.plant
            .advance(&command, f64::from(self.tick) / self.ticks_per_s)
            .map_err(|error| Error::Usage(format!("the simulation stopped at {t_s} s: {error}")))?;
        Ok(Row { t_s, reference, truth, outputs, er_torque_nm })
    }
}

/// The coefficient Q that the damper was asked for; none while it brakes, whose torque is not a viscosity.
fn viscosity_nm_s_rad(params: &Params, outputs: &Outputs) -> Option<f64> {
    match outputs.mode {
        LawMode::Off => Some(0.0),
        LawMode::Damper => Some(f64::from(params.viscosity_nm_s_rad(outputs.speed_rad_s))),
        LawMode::Brake => None,
    }
}

/// Runs the loop along a reference and keeps every row.
///
/// # Errors
/// See [`ClosedLoop`].
pub fn run(setup: &Setup, reference: impl IntoIterator<Item = Counts>) -> Result<Vec<Row>, Error> {
    run_beside(setup, reference, |_, _| {})
}

/// As [`run`], with something beside the flashed law ([`ClosedLoop::tick_beside`]).
///
/// # Errors
/// See [`ClosedLoop`].
pub fn run_beside(
    setup: &Setup,
    reference: impl IntoIterator<Item = Counts>,
    mut beside: impl FnMut(Counts, &mut Outputs),
) -> Result<Vec<Row>, Error> {
    let mut closed_loop = ClosedLoop::new(setup)?;
    let reference: Vec<Counts> = reference.into_iter().collect();
    let progress = Progress::new("simulating, ticks", reference.len() as u64);
    let mut rows = Vec::with_capacity(reference.len());
    for chunk in reference.chunks(PROGRESS_TICKS) {
        for counts in chunk {
            rows.push(closed_loop.tick_beside(*counts, &mut beside)?);
        }
        progress.advance(chunk.len() as u64);
    }
    Ok(rows)
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
        mode: Some(rows.iter().map(|row| Mode::from(row.outputs.mode)).collect()),
        velocity: Some(column(|row| f64::from(row.outputs.speed_rad_s))),
        effort_meas: None,
        field_meas_kv_mm: None,
        temperature_c: None,
        seq: Some((0..rows.len() as u64).collect()),
        fault: Some(rows.iter().map(|row| row.outputs.supervisor.faults().bits()).collect()),
        counts: Some(rows.iter().map(|row| i64::from(row.outputs.position.0)).collect()),
        gaps: Vec::new(),
        mended: Vec::new(),
        extra: Vec::new(),
    }
}
