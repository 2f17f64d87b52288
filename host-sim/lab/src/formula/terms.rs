//! The terms a formula may have: a carrier, which makes it friction, drive, fluid or inertia, times a function of state.

use std::f64::consts::TAU;

use super::columns::Columns;
use super::state::State;
use crate::read::AxisKind;
use crate::screen::orders_of;

/// What a term is a share of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Carrier {
    One,
    Sign,
    Speed,
    SpeedSquared,
    SpeedCubed,
    Acceleration,
    Torque,
    TorqueSquared,
    TorqueCubed,
    /// Friction by the torque of the drive.
    Load,
    /// Torque of the fluid as the model has it.
    Drag,
    Field,
    FieldSquared,
    FieldTimesSpeed,
    FieldTimesTorque,
    /// What a play of a half-width keeps back of the drive's torque.
    Play,
    /// Field behind a slow lag.
    SlowField,
    /// Torque of the fluid times a lag of the power it takes up.
    SlowPower,
}

/// The function of state that a carrier is multiplied with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    Constant,
    /// Sine and cosine of an order of the position.
    Wave,
    Position,
    PositionSquared,
    PositionCubed,
    Time,
    /// One from a time on.
    From,
    /// Falls with the square of the speed.
    Slow,
    /// Falls with the time since the motion began.
    Young,
    /// The same times the rest before.
    Rested,
}

/// One term without its coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Term {
    pub carrier: Carrier,
    pub form: Form,
    /// The one parameter of the carrier or form that is no factor: order, speed, time, half-width.
    pub parameter: f64,
}

/// Highest order of the position that is tried whether it stands out or not.
const LOW_ORDERS: u32 = 12;
/// Shares of the largest speed at which a function of speed has fallen.
const SPEEDS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];
/// Time constants of memory, s.
const TIMES_S: [f64; 5] = [0.01, 0.03, 0.1, 0.3, 1.0];
/// Half-widths of a play, as shares of the root mean square of the drive's torque.
const PLAYS: [f64; 5] = [0.03, 0.1, 0.2, 0.4, 0.8];
/// Times at which something may change, as shares of the longest recording.
const CHANGES: u32 = 12;

impl Term {
    /// Columns: a wave has two.
    pub fn columns(&self) -> usize {
        if self.form == Form::Wave { 2 } else { 1 }
    }

    /// Whether its parameter is fitted too. Orders per revolution are whole.
    pub fn adjustable(&self, axis: AxisKind) -> bool {
        match self.form {
            Form::Wave => axis == AxisKind::Linear,
            Form::From | Form::Slow | Form::Young | Form::Rested => true,
            _ => matches!(self.carrier, Carrier::Play | Carrier::SlowField | Carrier::SlowPower),
        }
    }

    /// Whether the bumps can show it: a memory shorter than the narrowest of them is a matter of the smoothing.
    pub fn resolved(&self) -> bool {
        let memory = matches!(self.form, Form::Young | Form::Rested)
            || matches!(self.carrier, Carrier::SlowField | Carrier::SlowPower);
        !memory || self.parameter >= TIMES_S[0]
    }

    /// Values in each cell of a recording, for each of its columns.
    pub fn cells(&self, state: &State) -> Vec<Vec<f64>> {
        let carrier = self.carrier_cells(state);
        let with = |form: &dyn Fn(usize) -> f64| -> Vec<f64> {
            carrier.iter().enumerate().map(|(cell, value)| value * form(cell)).collect()
        };
        let p = self.parameter;
        let q = &state.position;
        match self.form {
            Form::Constant => vec![carrier],
            Form::Wave => vec![with(&|cell| (p * q[cell]).sin()), with(&|cell| (p * q[cell]).cos())],
            Form::Position => vec![with(&|cell| q[cell])],
            Form::PositionSquared => vec![with(&|cell| q[cell].powi(2))],
            Form::PositionCubed => vec![with(&|cell| q[cell].powi(3))],
            Form::Time => vec![with(&|cell| state.t_s[cell])],
            Form::From => vec![with(&|cell| if state.t_s[cell] >= p { 1.0 } else { 0.0 })],
            Form::Slow => vec![with(&|cell| (-(state.speed[cell] / p).powi(2)).exp())],
            Form::Young => vec![with(&|cell| (-state.moving_s[cell] / p).exp())],
            Form::Rested => vec![with(&|cell| state.rested_s[cell] * (-state.moving_s[cell] / p).exp())],
        }
    }

    fn carrier_cells(&self, state: &State) -> Vec<f64> {
        let State { speed, sign, torque, field, drag, .. } = state;
        let each = |value: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..state.cells()).map(value).collect() };
        match self.carrier {
            Carrier::One => vec![1.0; state.cells()],
            Carrier::Sign => sign.clone(),
            Carrier::Speed => speed.clone(),
            Carrier::SpeedSquared => each(&|cell| speed[cell] * speed[cell].abs()),
            Carrier::SpeedCubed => each(&|cell| speed[cell].powi(3)),
            Carrier::Acceleration => state.acceleration.clone(),
            Carrier::Torque => torque.clone(),
            Carrier::TorqueSquared => each(&|cell| torque[cell] * torque[cell].abs()),
            Carrier::TorqueCubed => each(&|cell| torque[cell].powi(3)),
            Carrier::Load => each(&|cell| sign[cell] * torque[cell].abs()),
            Carrier::Drag => drag.clone(),
            Carrier::Field => each(&|cell| sign[cell] * field[cell]),
            Carrier::FieldSquared => each(&|cell| sign[cell] * field[cell].powi(2)),
            Carrier::FieldTimesSpeed => each(&|cell| field[cell] * speed[cell]),
            Carrier::FieldTimesTorque => each(&|cell| field[cell] * torque[cell]),
            Carrier::Play => play(torque, self.parameter),
            Carrier::SlowField => {
                let slow = lagged(&state.t_s, field, self.parameter);
                each(&|cell| sign[cell] * slow[cell])
            }
            Carrier::SlowPower => {
                let power: Vec<f64> = drag.iter().zip(speed).map(|(drag, speed)| drag * speed).collect();
                let slow = lagged(&state.t_s, &power, self.parameter);
                each(&|cell| drag[cell] * slow[cell])
            }
        }
    }
}

/// What a play of a half-width gives out less what goes in.
fn play(input: &[f64], half_width: f64) -> Vec<f64> {
    let mut out = input.first().copied().unwrap_or(0.0);
    let each = input.iter().map(|&value| {
        out = out.clamp(value - half_width, value + half_width);
        out - value
    });
    each.collect()
}

/// First-order lag, from rest.
fn lagged(t_s: &[f64], input: &[f64], time_s: f64) -> Vec<f64> {
    let (mut out, mut before_s) = (0.0, t_s.first().copied().unwrap_or(0.0));
    let each = t_s.iter().zip(input).map(|(&now_s, &value)| {
        out += (1.0 - (-(now_s - before_s) / time_s).exp()) * (value - out);
        before_s = now_s;
        out
    });
    each.collect()
}

/// Every term that these recordings may have.
pub(super) fn candidates(columns: &Columns<'_>, axis: AxisKind) -> Vec<Term> {
    use Carrier as C;
    use Form as F;
    let fitted = &columns.states[..columns.problem.fitted];
    let peak = |of: fn(&State) -> &Vec<f64>| fitted.iter().flat_map(of).fold(0.0_f64, |peak, v| peak.max(v.abs()));
    let speed = peak(|state| &state.speed);
    let duration_s = peak(|state| &state.t_s);
    let fluid = peak(|state| &state.field) > 0.0;
    let mut all = Vec::new();
    let mut add = |carriers: &[Carrier], form: Form, parameters: &[f64]| {
        let usable = carriers.iter().filter(|carrier| fluid || !needs_fluid(**carrier));
        all.extend(
            usable.flat_map(|&carrier| parameters.iter().map(move |&parameter| Term { carrier, form, parameter })),
        );
    };
    let plain = [C::One, C::Sign, C::Speed, C::SpeedSquared, C::SpeedCubed, C::Acceleration, C::Torque];
    add(&plain, F::Constant, &[0.0]);
    let more = [C::TorqueSquared, C::TorqueCubed, C::Load, C::Field, C::FieldSquared, C::FieldTimesSpeed];
    add(&more, F::Constant, &[0.0]);
    add(&[C::FieldTimesTorque, C::Drag], F::Constant, &[0.0]);
    add(&[C::One], F::Position, &[0.0]);
    add(&[C::One, C::Sign], F::PositionSquared, &[0.0]);
    add(&[C::One], F::PositionCubed, &[0.0]);
    add(&[C::Sign, C::Drag], F::Position, &[0.0]);
    let changing = [C::One, C::Sign, C::Speed, C::Acceleration, C::Torque, C::Drag];
    add(&changing, F::Time, &[0.0]);
    let times: Vec<f64> = (1..CHANGES).map(|k| duration_s * f64::from(k) / f64::from(CHANGES)).collect();
    add(&changing, F::From, &times);
    add(&[C::Sign, C::Drag], F::Slow, &SPEEDS.map(|share| share * speed));
    add(&[C::Sign], F::Young, &TIMES_S);
    add(&[C::Sign], F::Rested, &TIMES_S);
    let torques = || fitted.iter().flat_map(|state| &state.torque);
    let rms = (torques().map(|u| u * u).sum::<f64>() / torques().count().max(1) as f64).sqrt();
    add(&[C::Play], F::Constant, &PLAYS.map(|share| share * rms));
    add(&[C::SlowField, C::SlowPower], F::Constant, &TIMES_S);
    add(&[C::One, C::Sign, C::Drag, C::Torque], F::Wave, &orders(columns, axis));
    all
}

fn needs_fluid(carrier: Carrier) -> bool {
    use Carrier as C;
    matches!(
        carrier,
        C::Drag | C::Field | C::FieldSquared | C::FieldTimesSpeed | C::FieldTimesTorque | C::SlowField | C::SlowPower
    )
}

/// Low orders, and those that stand out of the residual or of the residual against the motion.
fn orders(columns: &Columns<'_>, axis: AxisKind) -> Vec<f64> {
    let problem = columns.problem;
    let narrow = problem.equations[..columns.fitted].iter().zip(columns.residual.iter());
    let narrow = || narrow.clone().filter(|(equation, _)| equation.width == 0);
    let at = |of: fn(&State) -> &Vec<f64>| -> Vec<f64> {
        narrow().map(|(equation, _)| equation.row.mean(of(&columns.states[equation.recording]))).collect()
    };
    let (position, sign) = (at(|state| &state.position), at(|state| &state.sign));
    let along: Vec<f64> = narrow().map(|(_, residual)| *residual).collect();
    let against: Vec<f64> = along.iter().zip(&sign).map(|(residual, sign)| residual * sign).collect();
    let linear = axis == AxisKind::Linear;
    let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(low, high), q| (low.min(*q), high.max(*q)));
    let mut all: Vec<f64> = [along, against].iter().flat_map(|values| orders_of(&position, values, linear)).collect();
    if !linear {
        // Less than a third of a period is a slope.
        all.extend((1..=LOW_ORDERS).map(f64::from).filter(|order| order * (high - low) > TAU / 3.0));
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_play_keeps_its_half_width_back_and_none_at_a_turn() {
        let out: Vec<f64> = play(&[0.0, 3.0, 2.0, -3.0], 1.0);
        assert_eq!(out, [0.0, -1.0, 0.0, 1.0]);
    }

    #[test]
    fn a_lag_has_risen_to_1_less_1_over_e_after_its_time() {
        let t_s: Vec<f64> = (0..101).map(|row| f64::from(row) * 1e-3).collect();
        let out = lagged(&t_s, &[1.0; 101], 0.1);
        assert!((out[100] - (1.0 - (-1.0_f64).exp())).abs() < 1e-9, "{}", out[100]);
    }
}
