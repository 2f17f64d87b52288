//! What a mode does: two steps and a push on one machine.

use er_servo::{Config, Counts};
use plant::{Er, FieldResponse, FluidResponse, Model};

use super::law::Mode;
use super::model::{DEAD_TIME_S, LAG_S};
use super::run;
use crate::paper::case::{A, B, COULOMB_NM, DELAY_S, PUSH, STEP_RAD};
use crate::simulate::{Disturbance, Row, Setup};
use recording::Error;

/// Small step, rad: slow all the way, so that the damper decides.
const SMALL_RAD: f64 = 0.05;
/// Length of each run, s.
const RUN_S: f64 = 0.8;
/// What counts as a run that does not settle, ms.
pub(super) const NEVER_MS: f64 = 1e3 * RUN_S;
/// Error that dry friction holds against the paper's gains, rad; the band of settling is the same for every mode.
const HELD_RAD: f64 = COULOMB_NM / 240.0;

/// Number of figures.
const COUNT: usize = 10;
/// The figures by name and unit; less is better in each.
pub const LINES: [&str; COUNT] = [
    "settling of 30 degrees (ms)",
    "settling of 50 mrad (ms)",
    "overshoot (mrad)",
    "swing left, limit cycle (mrad)",
    "residual (mrad)",
    "peak under 8 N m for 50 ms (mrad)",
    "back within 1.5 u after it (ms)",
    "motor, integral of u^2 (N^2 m^2 s)",
    "field, integral of E^2 ((kV/mm)^2 s)",
    "field, sum of changes (kV/mm)",
];

/// The figures in the order of [`LINES`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures(pub [f64; COUNT]);

impl Figures {
    /// The worse of each.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        let mut worst = self;
        for (one, other) in worst.0.iter_mut().zip(other.0) {
            *one = one.max(other);
        }
        worst
    }
}

/// Runs of a mode on a machine whose delays (motor, dead time, lag) are those it was told times `factors`.
pub(super) fn runs(mode: &Mode, factors: [f64; 3]) -> Result<[Vec<Row>; 3], Error> {
    let [motor, dead, lag] = factors;
    let response = FluidResponse::Field(FieldResponse::new(DEAD_TIME_S * dead, LAG_S * lag));
    let er = Er { response, ..Er::new(A, B, 0.0, 0.0) };
    let model = Model { er: Some(er), torque_delay_s: DELAY_S * motor, ..Model::paper() };
    let one = |step_rad: f64, disturbances: Vec<Disturbance>| {
        let setup = Setup {
            model: model.clone(),
            config: Config::default(),
            disturbances,
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.0,
            seed: 0,
        };
        let ticks = (RUN_S / f64::from(setup.config.period_s)) as usize;
        let reference = std::iter::repeat_n(Counts::from_rad(step_rad), ticks);
        run(mode, &setup, reference)
    };
    Ok([one(STEP_RAD, Vec::new())?, one(SMALL_RAD, Vec::new())?, one(0.0, vec![PUSH])?])
}

pub(super) fn figures(mode: &Mode, factors: [f64; 3]) -> Result<Figures, Error> {
    let runs = runs(mode, factors)?;
    let period_s = f64::from(Config::default().period_s);
    let error = |row: &Row| row.reference.to_rad() - row.truth.position;
    let settled_ms = |rows: &[Row], band_rad: f64| {
        let outside = rows.iter().rposition(|row| error(row).abs() > band_rad);
        outside.map_or(0.0, |last| if last + 1 == rows.len() { NEVER_MS } else { 1e3 * period_s * (last + 1) as f64 })
    };
    let [large, small, push] = &runs;
    let band_rad = |step_rad: f64| (0.02 * step_rad).max(1.5 * HELD_RAD);
    let beyond = |rows: &[Row]| rows.iter().map(|row| -error(row)).fold(0.0, f64::max);
    let swing = |rows: &[Row]| {
        let late = rows[rows.len() - rows.len() / 5..].iter().map(|row| row.truth.position);
        let (low, high) = late.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        0.5 * (high - low)
    };
    let most = |of: &dyn Fn(&[Row]) -> f64| runs.iter().map(|rows| of(rows)).fold(0.0, f64::max);
    let sum = |of: &dyn Fn(&Row) -> f64| period_s * runs.iter().flatten().map(of).sum::<f64>();
    let field = |row: &Row| f64::from(row.outputs.field_kv_mm);
    let changes = |rows: &Vec<Row>| rows.windows(2).map(|pair| (field(&pair[1]) - field(&pair[0])).abs()).sum::<f64>();
    let after_push_ms = 1e3 * (PUSH.start_s + PUSH.duration_s);
    Ok(Figures([
        settled_ms(large, band_rad(STEP_RAD)),
        settled_ms(small, band_rad(SMALL_RAD)),
        1e3 * beyond(large).max(beyond(small)),
        1e3 * most(&swing),
        1e3 * most(&|rows| rows.last().map_or(0.0, |row| error(row).abs())),
        1e3 * push.iter().map(|row| error(row).abs()).fold(0.0, f64::max),
        (settled_ms(push, 1.5 * HELD_RAD) - after_push_ms).max(0.0),
        sum(&|row| f64::from(row.outputs.torque_nm).powi(2)),
        sum(&|row| field(row).powi(2)),
        runs.iter().map(changes).sum(),
    ]))
}
