//! A first model of a machine nobody has described: inertia, friction, offset, and gravity or a spring, by robust least squares.
//!
//! The torque balance in short windows ([`crate::precheck`]): effort = J a + F sign v + D v - offset + G sin(position + phase), or
//! k position in the place of gravity.
//! Of several lengths of window the one that tells the inertia best is taken: short ones hold more noise, long ones are few.

use nalgebra::{DMatrix, DVector};

use crate::precheck::travel;
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
/// Gravity or a spring is one where it takes away this share of what is left without it; less is as often cogging or noise,
const LOAD_EXPLAINS: f64 = 0.2;
/// and where its value is this many times the width of its interval: over a short way gravity is a constant in disguise, and a spring an
/// inertia of the wrong sign at one frequency.
const LOAD_SURE: f64 = 4.0;
/// Gravity also where the axis turns by this, rad: a constant is as good over less.
const GRAVITY_TRAVEL_RAD: f64 = 0.5;
/// Two standard errors of windows that overlap by half: 95 %.
const INTERVAL: f64 = 2.0 * std::f64::consts::SQRT_2;

/// Below this explained share of the effort half of it is something else.
const EXPLAINED_ENOUGH: f64 = 0.5;
/// A log moves in one direction only where fewer of its windows than this share go the other way.
const OTHER_WAY: f64 = 0.02;

/// A value and half the width of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// In the unit of the machine file; of what was left out, as the whole balance had it.
    pub value: f64,
    /// Half the width, as long as the balance holds; infinite where nothing tells.
    pub within: f64,
    /// Whether it stayed in the balance: it is told, is no friction that drives, and is no larger than the effort.
    pub kept: bool,
}

impl Value {
    /// Of what nothing tells.
    const NONE: Self = Self { value: 0.0, within: f64::INFINITY, kept: false };

    /// Whether the interval is narrower than the value.
    pub fn is_known(self) -> bool {
        self.within < self.value.abs()
    }
}

/// What holds the axis at a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Amplitude, N m, and phase, rad; of a rotary axis.
    Gravity(Value, f64),
    /// Stiffness of a spring to the position 0, N m/rad (N/m).
    Spring(Value),
}

impl Load {
    /// The effect of the vocabulary that it is, and its parameters.
    pub fn effect(self) -> (&'static str, Vec<f64>) {
        match self {
            Self::Gravity(amplitude, phase_rad) => ("gravity_load", vec![amplitude.value, phase_rad]),
            Self::Spring(stiffness) => ("spring_load", vec![stiffness.value]),
        }
    }
}

/// What least squares say of a machine; units of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstModel {
    /// kg m2 (kg).
    pub inertia: Value,
    /// N m (N). Where the motion is in one direction only, friction and offset together.
    pub coulomb: Value,
    /// N m s/rad (N s/m).
    pub viscous: Value,
    /// N m (N).
    pub offset: Value,
    /// None where it explains little.
    pub load: Option<Load>,
    /// Share of the effort the balance explains, 0 to 1.
    pub explained: f64,
    /// Mean square of what is left, (N m)^2 (N^2).
    pub left: f64,
    /// How many windows were fitted, and their length, s.
    pub windows: (usize, f64),
    /// Whether the effort has the opposite sign of the acceleration it makes.
    pub reversed: bool,
    /// Whether the motion is in one direction only: friction and offset cannot be told apart.
    pub one_way: bool,
}

impl FirstModel {
    /// Whether it explains enough of the effort to go by.
    pub fn is_trusted(&self) -> bool {
        self.explained >= EXPLAINED_ENOUGH
    }
}

/// Terms of the balance beside the inertia, as [`Window::others`] has them.
mod term {
    pub(super) const CONSTANT: usize = 0;
    pub(super) const DIRECTION: usize = 1;
    pub(super) const SPEED: usize = 2;
    pub(super) const POSITION: usize = 3;
    pub(super) const SINE: usize = 4;
    pub(super) const COSINE: usize = 5;
}

/// One solution of the balance.
struct Fit {
    /// Terms beside the inertia.
    others: Vec<usize>,
    /// Of the inertia, then of each term.
    values: Vec<Value>,
    /// Weighted mean square that is left.
    left: f64,
    explained: f64,
}

impl Fit {
    /// The value of a term; none where it is not in the balance.
    fn of(&self, term: usize) -> Option<Value> {
        self.others.iter().position(|other| *other == term).map(|place| self.values[place + 1])
    }

    /// Amplitude of gravity, where it is known well.
    fn gravity(&self) -> Option<Value> {
        let (sine, cosine) = (self.of(term::SINE)?, self.of(term::COSINE)?);
        let (value, within) = (sine.value.hypot(cosine.value), sine.within.max(cosine.within));
        (value > LOAD_SURE * within).then_some(Value { value, within, kept: true })
    }

    /// Stiffness of a spring that pulls back to about the position 0, where it is known well. `sign` is that of the effort, and its
    /// `largest` holds the spring there.
    fn spring(&self, sign: f64, largest: f64) -> Option<Value> {
        let fitted = self.of(term::POSITION)?;
        let value = sign * fitted.value;
        let holds = self.of(term::CONSTANT).is_none_or(|constant| constant.value.abs() <= largest);
        (holds && value > LOAD_SURE * fitted.within).then_some(Value { value, ..fitted })
    }
}

/// The first model of the machine of these recordings; none where nothing moves enough to tell anything, or no effort acts: of that
/// a machine of no inertia is the best.
pub fn first_model(axis: &Axis, recordings: &[Recording]) -> Option<FirstModel> {
    if recordings.iter().flat_map(|recording| &recording.effort_cmd).all(|effort| *effort == 0.0) {
        return None;
    }
    let fits = LENGTHS_S.into_iter().filter_map(|length_s| first_model_of(axis, recordings, length_s));
    let doubt = |model: &FirstModel| model.inertia.within / model.inertia.value.abs();
    fits.min_by(|one, other| doubt(one).total_cmp(&doubt(other)))
}

/// The first model by windows of one length, with the rows of the effort as samples or as commands held from row to row, whichever leaves
/// less: half a row between the two is taken for a viscous friction of half a row of the inertia's torque.
pub fn first_model_of(axis: &Axis, recordings: &[Recording], length_s: f64) -> Option<FirstModel> {
    let machine = neutral(axis);
    let of = |recording: &Recording| windows(&machine, recording, median_period_s(&recording.t_s), length_s);
    let samples: Vec<Window> = recordings.iter().flat_map(of).collect();
    let held: Vec<Window> = recordings.iter().flat_map(|recording| of(&around_rows(recording))).collect();
    let both = [samples, held].into_iter().filter_map(|windows| balance(axis, recordings, &windows, length_s));
    both.min_by(|one, other| one.left.total_cmp(&other.left))
}

/// The same with what a held effort is in the mean about each row: as long the one before it as its own.
fn around_rows(recording: &Recording) -> Recording {
    let efforts = &recording.effort_cmd;
    let before = efforts.first().into_iter().chain(efforts);
    let effort_cmd = before.zip(efforts).map(|(before, own)| 0.5 * (before + own)).collect();
    Recording { effort_cmd, ..recording.clone() }
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

/// The balance of these windows: of all terms, with gravity or a spring where it belongs there, without what nothing tells.
fn balance(axis: &Axis, recordings: &[Recording], windows: &[Window], length_s: f64) -> Option<FirstModel> {
    let one_way = is_one_way(windows);
    let of = |terms: &[usize]| -> Option<Fit> {
        let kept = terms.iter().copied().filter(|term| !(one_way && *term == term::DIRECTION));
        fit(windows, &kept.collect::<Vec<usize>>())
    };
    let turns =
        axis.kind == AxisKind::Rotary && recordings.iter().any(|recording| travel(recording) > GRAVITY_TRAVEL_RAD);
    use term::{CONSTANT, COSINE, DIRECTION, POSITION, SINE, SPEED};
    let plain = of(&[CONSTANT, DIRECTION, SPEED])?;
    // Gravity, a spring or another body may look like an inertia of the wrong sign: with all of them it must still be one, and no
    // machine gives back more work than it was given.
    let all: &[usize] = if turns {
        &[CONSTANT, DIRECTION, SPEED, POSITION, SINE, COSINE]
    } else {
        &[CONSTANT, DIRECTION, SPEED, POSITION]
    };
    let is_negative = |fit: &Fit| fit.values[0].value < 0.0 && fit.values[0].is_known();
    let may_be_reversed = of(all).is_some_and(|fit| is_negative(&fit)) && work(recordings) < 0.0;
    let sign = |fit: &Fit| if may_be_reversed && is_negative(fit) { -1.0 } else { 1.0 };
    let largest =
        recordings.iter().flat_map(|recording| &recording.effort_cmd).fold(0.0, |most: f64, e| most.max(e.abs()));
    let enough = |fit: &Fit| fit.left < (1.0 - LOAD_EXPLAINS) * plain.left;
    // Over a short way gravity and an offset look alike; then gravity is tried alone.
    let tried = [&[CONSTANT, DIRECTION, SPEED, SINE, COSINE][..], &[DIRECTION, SPEED, SINE, COSINE]];
    let mut with_gravity = tried.into_iter().filter(|_| turns).filter_map(of);
    let gravity = with_gravity.find(|fit| enough(fit) && fit.gravity().is_some());
    let is_spring = |fit: &Fit| enough(fit) && fit.spring(sign(fit), largest).is_some();
    let spring = || of(&[CONSTANT, DIRECTION, SPEED, POSITION]).filter(is_spring);
    let best = gravity.or_else(spring).unwrap_or(plain);
    let sign = sign(&best);
    let settled = settled(windows, best, sign, largest);
    Some(FirstModel { one_way, windows: (windows.len(), length_s), reversed: sign < 0.0, ..settled })
}

/// The balance without the terms that nothing tells, or that cannot be: each is left out by itself, the least known first, for it
/// may have spoilt the others.
fn settled(windows: &[Window], whole: Fit, sign: f64, largest: f64) -> FirstModel {
    let (best, dropped) = without_untold(windows, whole, sign, largest);
    let value = |term: usize| {
        let kept = best.of(term);
        let left_out = || dropped.iter().find(|(of, _)| *of == term).map(|(_, value)| Value { kept: false, ..*value });
        let value = kept.or_else(left_out).unwrap_or(Value::NONE);
        Value { value: sign * value.value, ..value }
    };
    let offset = value(term::CONSTANT);
    let phase_rad = || value(term::COSINE).value.atan2(value(term::SINE).value);
    let gravity = best.gravity().map(|amplitude| Load::Gravity(amplitude, phase_rad()));
    FirstModel {
        inertia: Value { value: sign * best.values[0].value, ..best.values[0] },
        coulomb: value(term::DIRECTION),
        viscous: value(term::SPEED),
        offset: Value { value: -offset.value, ..offset },
        load: gravity.or_else(|| best.spring(sign, largest).map(Load::Spring)),
        explained: best.explained,
        left: best.left,
        windows: (windows.len(), 0.0),
        reversed: false,
        one_way: false,
    }
}

/// The balance of the terms that remain, and those left out with the values that they had.
fn without_untold(windows: &[Window], whole: Fit, sign: f64, largest: f64) -> (Fit, Vec<(usize, Value)>) {
    let fastest = windows.iter().fold(0.0, |most: f64, window| most.max(window.speed.abs()));
    let droppable = [term::CONSTANT, term::DIRECTION, term::SPEED];
    let doubt = |term: usize, value: Value| {
        let drives = term != term::CONSTANT && sign * value.value < 0.0;
        let share = if term == term::SPEED { fastest } else { 1.0 };
        let beyond = value.value.abs() * share > largest;
        if drives || beyond { f64::INFINITY } else { value.within / value.value.abs() }
    };
    let mut dropped: Vec<(usize, Value)> = Vec::new();
    let mut best = whole;
    while let Some((_, term, value)) = droppable
        .into_iter()
        .filter_map(|term| best.of(term).map(|value| (doubt(term, value), term, value)))
        .filter(|(doubt, _, _)| *doubt >= 1.0 || doubt.is_nan())
        .max_by(|one, other| one.0.total_cmp(&other.0))
    {
        let others: Vec<usize> = best.others.iter().copied().filter(|other| *other != term).collect();
        let Some(next) = fit(windows, &others) else { break };
        dropped.push((term, value));
        best = next;
    }
    (best, dropped)
}

fn is_one_way(windows: &[Window]) -> bool {
    let forward = windows.iter().filter(|window| window.speed > 0.0).count();
    (forward.min(windows.len() - forward) as f64) < OTHER_WAY * windows.len() as f64
}

/// What the effort did to the motion, N m rad (N m).
fn work(recordings: &[Recording]) -> f64 {
    let of = |recording: &Recording| -> f64 {
        recording
            .position
            .windows(2)
            .zip(&recording.effort_cmd)
            .map(|(pair, effort)| effort * (pair[1] - pair[0]))
            .sum()
    };
    recordings.iter().map(of).sum()
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
        Value { value: *value, within: if within.is_finite() { within } else { f64::INFINITY }, kept: true }
    });
    let values: Vec<Value> = values.collect();
    let explained = if spread > 0.0 { (1.0 - left / spread).max(0.0) } else { 0.0 };
    values.iter().all(|value| value.value.is_finite()).then_some(Fit {
        others: others.to_vec(),
        values,
        left: left / total,
        explained,
    })
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
