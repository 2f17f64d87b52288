//! A first model of a machine nobody has described: inertia, friction, offset and gravity by robust least squares.
//!
//! The torque balance in short windows ([`crate::precheck`]): effort = J a + F sign v + D v - offset + G sin(position + phase).
//! Of several lengths of window the one that tells the inertia best is taken: short ones hold more noise, long ones are few.

use nalgebra::{DMatrix, DVector};

use crate::precheck::windows::{Window, median_period_s, windows};
use crate::read::{Axis, AxisKind, Machine, Mapping, PlantNominal, Recording};

/// Lengths of the windows that are tried, s: from the fastest motion of such axes to the noise of a coarse sensor.
const LENGTHS_S: [f64; 6] = [0.02, 0.04, 0.08, 0.16, 0.32, 0.64];
/// Fewer windows for each unknown tell nothing.
const WINDOWS_EACH: usize = 5;
/// Rounds of the robust fit; weights change little after.
const ROUNDS: usize = 10;
/// Residuals beyond this many standard deviations count less (Huber 1964: 95 % efficient where all is normal).
const HUBER: f64 = 1.345;
/// Standard deviation of a normal distribution over its median absolute deviation.
const SIGMA_PER_MAD: f64 = 1.4826;
/// Gravity is one where it takes away this share of what is left without it; less is as often cogging or noise,
const GRAVITY_EXPLAINS: f64 = 0.2;
/// where its amplitude is this many times the width of its interval: over a short way it is a constant in disguise,
const GRAVITY_SURE: f64 = 4.0;
/// and where the axis turns by this, rad: a constant is as good over less.
const GRAVITY_TRAVEL_RAD: f64 = 0.5;
/// Two standard errors of windows that overlap by half: 95 %.
const INTERVAL: f64 = 2.0 * std::f64::consts::SQRT_2;

/// A value and half the width of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// In the unit of the machine file.
    pub value: f64,
    /// Half the width, as long as the balance holds; infinite where nothing tells.
    pub within: f64,
}

impl Value {
    /// Whether the interval is narrower than the value.
    pub fn is_known(self) -> bool {
        self.within < self.value.abs()
    }
}

/// What least squares say of a machine; units of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstModel {
    /// kg m2 (kg).
    pub inertia: Value,
    /// N m (N).
    pub coulomb: Value,
    /// N m s/rad (N s/m).
    pub viscous: Value,
    /// N m (N).
    pub offset: Value,
    /// Amplitude, N m, and phase, rad; none on a linear axis and where it explains little.
    pub gravity: Option<(Value, f64)>,
    /// Share of the effort the balance explains, 0 to 1.
    pub explained: f64,
    /// Whether the effort has the opposite sign of the acceleration it makes.
    pub reversed: bool,
}

/// One solution of the balance.
struct Fit {
    values: Vec<Value>,
    /// Weighted mean square that is left.
    left: f64,
    explained: f64,
}

/// The first model of the machine of these recordings; none where nothing moves enough to tell anything.
pub fn first_model(axis: &Axis, recordings: &[Recording]) -> Option<FirstModel> {
    let machine = neutral(axis);
    let fits = LENGTHS_S.into_iter().filter_map(|length_s| {
        let of = |recording: &Recording| windows(&machine, recording, median_period_s(&recording.t_s), length_s);
        let windows: Vec<Window> = recordings.iter().flat_map(of).collect();
        balance(axis, recordings, &windows)
    });
    let doubt = |model: &FirstModel| model.inertia.within / model.inertia.value.abs();
    fits.min_by(|one, other| doubt(one).total_cmp(&doubt(other)))
}

/// A machine that does to the effort nothing.
fn neutral(axis: &Axis) -> Machine {
    let plant = PlantNominal {
        inertia: 1.0,
        coulomb: 0.0,
        viscous: 0.0,
        torque_gain: 1.0,
        torque_offset: 0.0,
        torque_limit: None,
        sample_to_output_s: 0.0,
        torque_delay_s: 0.0,
        er: None,
    };
    Machine {
        file: std::path::PathBuf::new(),
        name: String::new(),
        axis: axis.clone(),
        plant,
        controller: None,
        columns: Mapping::default(),
        effects: Vec::new(),
    }
}

/// The balance of these windows, with gravity where it belongs there.
fn balance(axis: &Axis, recordings: &[Recording], windows: &[Window]) -> Option<FirstModel> {
    // Of `others`: a constant, direction, speed, (position,) sine and cosine of the position.
    let plain = fit(windows, &[0, 1, 2])?;
    let turns = recordings.iter().any(|recording| {
        let (low, high) =
            recording.position.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), position| {
                (low.min(*position), high.max(*position))
            });
        high - low > GRAVITY_TRAVEL_RAD
    });
    let with_gravity = (axis.kind == AxisKind::Rotary && turns).then(|| fit(windows, &[0, 1, 2, 4, 5])).flatten();
    let sure = |fit: &Fit| {
        let (sine, cosine) = (fit.values[4], fit.values[5]);
        sine.value.hypot(cosine.value) > GRAVITY_SURE * sine.within.max(cosine.within)
    };
    let with_gravity = with_gravity.filter(|fit| fit.left < (1.0 - GRAVITY_EXPLAINS) * plain.left && sure(fit));
    let best = with_gravity.as_ref().unwrap_or(&plain);
    let reversed = best.values[0].value < 0.0 && best.values[0].is_known();
    let sign = if reversed { -1.0 } else { 1.0 };
    let value = |index: usize| Value { value: sign * best.values[index].value, ..best.values[index] };
    let gravity = with_gravity.as_ref().map(|_| {
        let (sine, cosine) = (value(4), value(5));
        let amplitude = Value { value: sine.value.hypot(cosine.value), within: sine.within.max(cosine.within) };
        (amplitude, cosine.value.atan2(sine.value))
    });
    let offset = Value { value: -value(1).value, ..value(1) };
    Some(FirstModel {
        inertia: value(0),
        coulomb: value(2),
        viscous: value(3),
        offset,
        gravity,
        explained: best.explained,
        reversed,
    })
}

/// Least squares of the effort over the acceleration and these of the other terms; windows that do not fit count less.
fn fit(windows: &[Window], others: &[usize]) -> Option<Fit> {
    let unknowns = 1 + others.len();
    if windows.len() < WINDOWS_EACH * unknowns {
        return None;
    }
    let matrix = DMatrix::from_fn(windows.len(), unknowns, |row, column| match column {
        0 => windows[row].acceleration,
        other => windows[row].others[others[other - 1]],
    });
    // Columns of very different size are brought to one.
    let sizes: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let effort = DVector::from_iterator(windows.len(), windows.iter().map(|window| window.effort));
    let mut weights = DVector::repeat(windows.len(), 1.0);
    let mut solved = None;
    for _ in 0..ROUNDS {
        let (factors, inverse) = weighted(&matrix, &sizes, &effort, &weights)?;
        let residuals = &effort - &matrix * &factors;
        weights = huber(&residuals);
        solved = Some((factors, inverse, residuals));
    }
    let (factors, inverse, residuals) = solved?;
    let total = weights.sum();
    let mean = effort.dot(&weights) / total;
    let spread = effort.iter().zip(&weights).map(|(effort, weight)| weight * (effort - mean).powi(2)).sum::<f64>();
    let left = residuals.iter().zip(&weights).map(|(residual, weight)| weight * residual * residual).sum::<f64>();
    let variance = left / (total - unknowns as f64).max(1.0);
    let values = factors.iter().enumerate().map(|(index, value)| {
        let within = INTERVAL * (variance * inverse[(index, index)]).max(0.0).sqrt() / sizes[index];
        Value { value: *value, within: if within.is_finite() { within } else { f64::INFINITY } }
    });
    let values: Vec<Value> = values.collect();
    let explained = if spread > 0.0 { (1.0 - left / spread).max(0.0) } else { 0.0 };
    values.iter().all(|value| value.value.is_finite()).then_some(Fit { values, left: left / total, explained })
}

/// The factors of the columns by weighted least squares, and the inverse of the normal matrix of the columns brought to one
/// size.
fn weighted(
    matrix: &DMatrix<f64>,
    sizes: &[f64],
    effort: &DVector<f64>,
    weights: &DVector<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let roots = weights.map(f64::sqrt);
    let mut scaled = matrix.clone();
    scaled.column_iter_mut().zip(sizes).for_each(|(mut column, size)| {
        column.component_mul_assign(&roots);
        column /= *size;
    });
    let inverse = (scaled.transpose() * &scaled).try_inverse()?;
    let factors = &inverse * scaled.transpose() * effort.component_mul(&roots);
    let factors = DVector::from_iterator(sizes.len(), factors.iter().zip(sizes).map(|(factor, size)| factor / size));
    Some((factors, inverse))
}

/// Weights of a robust fit from its residuals.
fn huber(residuals: &DVector<f64>) -> DVector<f64> {
    let mut sizes: Vec<f64> = residuals.iter().map(|residual| residual.abs()).collect();
    let middle = sizes.len() / 2;
    let limit = HUBER * SIGMA_PER_MAD * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    residuals.map(|residual| if limit <= 0.0 || residual.abs() <= limit { 1.0 } else { limit / residual.abs() })
}
