//! How far one quantity may move alone before the loop is lost, and the margins that follow.
//!
//! A stable loop is lost where a root first reaches the imaginary axis. For each quantity that condition, D(jw) = 0,
//! splits into an equation in w without the quantity and a formula for the quantity, so every value at which a root
//! is on the axis is found and the nearest on either side is the limit. The gains stay as they are in N m while L or
//! J move: what they were scaled with is not what the plant has.

use nalgebra::Complex;
use std::f64::consts::TAU;

use super::case::{Fluid, Gains, Loop, LoopError, Plant};
use super::{curves, zeros::zeros};

/// Largest factor up or down that is looked at.
const LARGEST: f64 = 1000.0;

/// A quantity that moves while the others stay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// L of the plant, s.
    TorqueDelay,
    /// L_Q or T_Q, s.
    FluidDelay,
    /// K_P, N m/rad.
    Kp,
    /// K_D, N m s/rad.
    Kd,
    /// K_P and K_D by the same factor, 1 as they are.
    BothGains,
    /// J of the plant, kg m2.
    Inertia,
    /// Q1, N m s/rad.
    Q1,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::TorqueDelay, Self::FluidDelay, Self::Kp, Self::Kd, Self::BothGains, Self::Inertia, Self::Q1];

    /// Its value in `closed`, in the unit of the variant.
    #[must_use]
    pub fn of(self, closed: &Loop) -> f64 {
        let (plant, gains) = (closed.plant(), closed.gains());
        match self {
            Self::TorqueDelay => plant.torque_delay_s,
            Self::FluidDelay => plant.fluid.delay_s(),
            Self::Kp => gains.k_p_nm_rad,
            Self::Kd => gains.k_d_nm_s_rad,
            Self::BothGains => 1.0,
            Self::Inertia => plant.inertia_kg_m2,
            Self::Q1 => plant.q1_nm_s_rad,
        }
    }

    /// The loop with this quantity at `value` and everything else as it is.
    ///
    /// # Errors
    /// As [`Loop::new`].
    pub fn set(self, closed: &Loop, value: f64) -> Result<Loop, LoopError> {
        let (mut plant, Gains { k_p_nm_rad, k_d_nm_s_rad }) = (*closed.plant(), closed.gains());
        let mut gains = closed.gains();
        match self {
            Self::TorqueDelay => plant.torque_delay_s = value,
            Self::FluidDelay => plant.fluid = plant.fluid.with_delay_s(value),
            Self::Kp => gains.k_p_nm_rad = value,
            Self::Kd => gains.k_d_nm_s_rad = value,
            Self::BothGains => {
                gains = Gains { k_p_nm_rad: k_p_nm_rad * value, k_d_nm_s_rad: k_d_nm_s_rad * value };
            }
            Self::Inertia => plant.inertia_kg_m2 = value,
            Self::Q1 => plant.q1_nm_s_rad = value,
        }
        Loop::new(plant, gains)
    }
}

/// Where a root reaches the imaginary axis.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Limit {
    /// The quantity there, in its unit.
    pub value: f64,
    /// That over its value now; infinite (null in JSON) if that is zero.
    pub factor: f64,
    /// Frequency of the oscillation there, rad/s.
    pub omega_rad_s: f64,
}

/// How far a quantity may move alone.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Tolerance {
    /// Which one.
    pub quantity: Quantity,
    /// As it is, in its unit.
    pub nominal: f64,
    /// Nearest loss below; none if there is none down to a thousandth, or, for a delay, to zero. At K_P = 0 itself the
    /// rotor has no rest position; that is not counted. Very fast loops are searched less far ([`LoopError::TooStiff`]).
    pub lower: Option<Limit>,
    /// Nearest loss above; none if there is none up to a thousand times the nominal value (of a fluid without delay,
    /// of the torque's delay).
    pub upper: Option<Limit>,
}

/// Margins of the loop opened at the control torque: L(s) = (K_P + K_D s) e^(-Ls) / (J s^2 + Q(s) s), the damper's own
/// feedback staying closed. They are what the motor's torque may be changed by, on its way to the rotor.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Margins {
    /// Factor on the control torque at which the loop is lost, above 1; none if there is none up to 1000.
    pub gain: Option<f64>,
    /// That in dB.
    pub gain_db: Option<f64>,
    /// Factor below 1 at which the loop is lost; none if any smaller torque keeps it.
    pub gain_lower: Option<f64>,
    /// Smallest extra lag of the control torque that loses the loop, degrees; of several crossovers, the binding one.
    /// None if |L| never is 1.
    pub phase_deg: Option<f64>,
    /// Smallest lead of the control torque that loses the loop, degrees.
    pub phase_lead_deg: Option<f64>,
    /// Crossover of `phase_deg`, rad/s.
    pub crossover_rad_s: Option<f64>,
    /// Smallest delay on top of L that loses the loop, s; none if no delay does.
    pub delay_s: Option<f64>,
    /// L with that delay, over L: the factor by which L may grow.
    pub delay_factor: Option<f64>,
    /// Its crossover, rad/s; with several crossovers not always that of the phase margin.
    pub delay_crossover_rad_s: Option<f64>,
}

/// Tolerances of every quantity the loop has; empty for an unstable loop, which has none to lose.
#[must_use]
pub fn tolerances(closed: &Loop) -> Vec<Tolerance> {
    if !curves::is_inside(closed) {
        return Vec::new();
    }
    let present = |quantity: &Quantity| match quantity {
        Quantity::FluidDelay => closed.plant().fluid != Fluid::None && closed.plant().q1_nm_s_rad > 0.0,
        Quantity::Kd | Quantity::Q1 => quantity.of(closed) > 0.0,
        _ => true,
    };
    Quantity::ALL.into_iter().filter(present).map(|quantity| tolerance(closed, quantity)).collect()
}

/// Tolerance of one quantity of a stable loop.
#[must_use]
pub fn tolerance(closed: &Loop, quantity: Quantity) -> Tolerance {
    let nominal = quantity.of(closed);
    let limit = |(value, omega_rad_s): (f64, f64)| Limit { value, factor: value / nominal, omega_rad_s };
    let whole = matches!(quantity, Quantity::TorqueDelay | Quantity::FluidDelay);
    let (mut lower, mut upper) = (None, None);
    // The band in which a root can be on the axis grows with the range searched, so a near limit is cheap.
    for range in [1.5, 8.0, 60.0, LARGEST] {
        // Delays do not count in it: all their values are found at once.
        let ends = if whole { vec![nominal] } else { vec![nominal / range, nominal * range] };
        let moved: Result<Vec<Loop>, LoopError> = ends.into_iter().map(|v| quantity.set(closed, v)).collect();
        // Further out the loop is beyond what is analysed.
        let Ok(moved) = moved else { break };
        let to_rad_s = moved.iter().map(Loop::frequency_bound_rad_s).fold(closed.frequency_bound_rad_s(), f64::max);
        let (least, most) = match (whole, nominal > 0.0) {
            (false, _) => (nominal / range, nominal * range),
            (true, true) => (0.0, nominal * LARGEST),
            (true, false) => (0.0, closed.plant().torque_delay_s * LARGEST),
        };
        let within = |v: f64| least <= v && v <= most;
        let values: Vec<_> =
            values_on_axis(closed, quantity, to_rad_s).into_iter().filter(|&(v, _)| v > 0.0 && within(v)).collect();
        let nearest = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
        lower = values.iter().copied().filter(|&(v, _)| v < nominal).max_by(nearest).map(limit);
        upper = values.iter().copied().filter(|&(v, _)| v > nominal).min_by(nearest).map(limit);
        if whole || (lower.is_some() && upper.is_some()) {
            break;
        }
    }
    Tolerance { quantity, nominal, lower, upper }
}

/// Values of a quantity with a root at +-jw, each with its w, for w up to `to_rad_s`.
fn values_on_axis(closed: &Loop, quantity: Quantity, to_rad_s: f64) -> Vec<(f64, f64)> {
    let plant = *closed.plant();
    let gains = closed.gains();
    let torque_delay = |w: f64| Complex::new(0.0, -w * plant.torque_delay_s).exp();
    match quantity {
        Quantity::TorqueDelay => delays_on_axis(
            closed,
            to_rad_s,
            |s| s * gains.k_d_nm_s_rad + gains.k_p_nm_rad,
            |s| closed.open_denominator(s),
        ),
        Quantity::FluidDelay => {
            let delayed = |s: Complex<f64>| s * plant.q1_nm_s_rad;
            let rest = |s: Complex<f64>| (s * plant.inertia_kg_m2 + plant.q0_nm_s_rad) * s + closed.control(s);
            match plant.fluid {
                Fluid::None => Vec::new(),
                Fluid::DeadTime { .. } => delays_on_axis(closed, to_rad_s, delayed, rest),
                Fluid::Lag { .. } => lags_on_axis(closed, to_rad_s, delayed, rest),
            }
        }
        Quantity::Kp => factors_on_axis(closed, quantity, to_rad_s, torque_delay),
        Quantity::Kd => factors_on_axis(closed, quantity, to_rad_s, |w| Complex::new(0.0, w) * torque_delay(w)),
        Quantity::BothGains => factors_on_axis(closed, quantity, to_rad_s, |w| closed.control(Complex::new(0.0, w))),
        Quantity::Inertia => factors_on_axis(closed, quantity, to_rad_s, |w| Complex::from(-w * w)),
        Quantity::Q1 => factors_on_axis(closed, quantity, to_rad_s, |w| {
            let s = Complex::new(0.0, w);
            s * plant.fluid.transfer(s)
        }),
    }
}

/// A quantity m in which D = A + m B is linear: Im(A conj B) = 0 and m = -Re(A conj B) / |B|^2.
fn factors_on_axis(
    closed: &Loop,
    quantity: Quantity,
    to_rad_s: f64,
    slope: impl Fn(f64) -> Complex<f64>,
) -> Vec<(f64, f64)> {
    let nominal = quantity.of(closed);
    let product = |w: f64| {
        let b = slope(w);
        ((closed.characteristic(Complex::new(0.0, w)) - b * nominal) * b.conj(), b.norm_sqr())
    };
    let found = zeros(|w| product(w).0.im, curves::scan(closed.plant(), to_rad_s));
    let value = |w: f64| {
        let (product, norm) = product(w);
        (-product.re / norm, w)
    };
    found.iter().map(|zero| value(zero.omega_rad_s)).collect()
}

/// A dead time t with D = X e^(-ts) + Y: |X| = |Y|, then every t that turns X onto -Y; of those the nearest two.
fn delays_on_axis(
    closed: &Loop,
    to_rad_s: f64,
    delayed: impl Fn(Complex<f64>) -> Complex<f64>,
    rest: impl Fn(Complex<f64>) -> Complex<f64>,
) -> Vec<(f64, f64)> {
    let at = |w: f64| (delayed(Complex::new(0.0, w)), rest(Complex::new(0.0, w)));
    let crossovers = zeros(|w| at(w).0.norm_sqr() - at(w).1.norm_sqr(), curves::scan(closed.plant(), to_rad_s));
    let mut found = Vec::new();
    for zero in crossovers {
        let w = zero.omega_rad_s;
        let (x, y) = at(w);
        // Delays at this crossover are a turn apart; the longest below and the shortest above any given one are
        // among the first turns, up to the phase of the nominal delays.
        let first = (x / -y).arg().rem_euclid(TAU);
        let last = w * (closed.plant().torque_delay_s + closed.plant().fluid.delay_s()) + 2.0 * TAU;
        let turns = std::iter::successors(Some(first), |phase| Some(phase + TAU)).take_while(|&phase| phase <= last);
        found.extend(turns.map(|phase| (phase / w, w)));
    }
    found
}

/// A time constant T with D = X / (Ts + 1) + Y: -X conj(Y) / |Y|^2 = 1 + jwT.
fn lags_on_axis(
    closed: &Loop,
    to_rad_s: f64,
    lagged: impl Fn(Complex<f64>) -> Complex<f64>,
    rest: impl Fn(Complex<f64>) -> Complex<f64>,
) -> Vec<(f64, f64)> {
    let product = |w: f64| {
        let (x, y) = (lagged(Complex::new(0.0, w)), rest(Complex::new(0.0, w)));
        (-x * y.conj(), y.norm_sqr())
    };
    let found = zeros(|w| product(w).0.re - product(w).1, curves::scan(closed.plant(), to_rad_s));
    let value = |w: f64| (product(w).0.im / (w * product(w).1), w);
    found.iter().map(|zero| value(zero.omega_rad_s)).collect()
}

/// Margins of a stable loop; none for an unstable one.
#[must_use]
pub fn margins(closed: &Loop) -> Option<Margins> {
    if !curves::is_inside(closed) {
        return None;
    }
    let gains = tolerance(closed, Quantity::BothGains);
    let to_rad_s = closed.frequency_bound_rad_s();
    let size = |w: f64| {
        let s = Complex::new(0.0, w);
        closed.control(s).norm_sqr() - closed.open_denominator(s).norm_sqr()
    };
    let crossovers: Vec<f64> =
        zeros(size, curves::scan(closed.plant(), to_rad_s)).iter().map(|zero| zero.omega_rad_s).collect();
    // The lag that turns L(jw) onto -1, in (0, 2 pi).
    let lag = |w: f64| {
        let s = Complex::new(0.0, w);
        (closed.control(s) / -closed.open_denominator(s)).arg().rem_euclid(TAU)
    };
    let least = |of: &dyn Fn(f64) -> f64| crossovers.iter().map(|&w| (of(w), w)).min_by(|a, b| a.0.total_cmp(&b.0));
    let (phase, delay) = (least(&lag), least(&|w| lag(w) / w));
    let Plant { torque_delay_s, .. } = *closed.plant();
    Some(Margins {
        gain: gains.upper.map(|limit| limit.factor),
        gain_db: gains.upper.map(|limit| 20.0 * limit.factor.log10()),
        gain_lower: gains.lower.map(|limit| limit.factor),
        phase_deg: phase.map(|(lag, _)| lag.to_degrees()),
        phase_lead_deg: least(&|w| TAU - lag(w)).map(|(lead, _)| lead.to_degrees()),
        crossover_rad_s: phase.map(|(_, w)| w),
        delay_s: delay.map(|(delay_s, _)| delay_s),
        delay_factor: delay.map(|(delay_s, _)| 1.0 + delay_s / torque_delay_s),
        delay_crossover_rad_s: delay.map(|(_, w)| w),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::testing::closed;

    fn near(value: f64, stated: f64) -> bool {
        (value / stated - 1.0).abs() < 0.02
    }

    #[test]
    fn margins_without_viscosity_are_those_of_the_specification() {
        let margins = margins(&closed(0.005, 0.0, 0.0, Fluid::None)).unwrap();
        assert!(near(margins.phase_deg.unwrap(), 42.5), "{margins:?}");
        assert!(near(margins.gain.unwrap(), 3.11), "{margins:?}");
        assert!(near(margins.delay_factor.unwrap(), 2.51), "{margins:?}");
        assert!(margins.gain_lower.is_none());
    }

    #[test]
    fn q1_may_grow_as_far_as_the_specification_says() {
        for (ms, stated) in [(1, 27.3), (2, 18.3), (3, 16.4), (5, 16.1), (8, 18.1), (10, 20.4)] {
            let at = |fluid| {
                let closed = closed(f64::from(ms) * 1e-3, 0.0, 1.0, fluid);
                tolerance(&closed, Quantity::Q1).upper
            };
            let limit = at(Fluid::DeadTime { l_q_s: 0.005 }).unwrap().value;
            assert!(near(limit, stated), "{ms} ms: {limit}");
            assert!(at(Fluid::Lag { t_q_s: 0.005 }).is_none_or(|limit| limit.value > 400.0), "{ms} ms, lag");
        }
    }

    #[test]
    fn the_delay_margin_is_the_tolerance_of_the_delay() {
        for fluid in [Fluid::None, Fluid::DeadTime { l_q_s: 0.005 }, Fluid::Lag { t_q_s: 0.005 }] {
            let closed = closed(0.005, 0.2, 10.0, fluid);
            let factor = margins(&closed).unwrap().delay_factor.unwrap();
            let tolerance = tolerance(&closed, Quantity::TorqueDelay).upper.unwrap();
            assert!((factor / tolerance.factor - 1.0).abs() < 1e-9);
        }
    }
}
