//! Effects with a state of their own, run along the recorded motion: bristles, and loads behind a shaft or a gap.

use super::motion::Motion;
use crate::effects::Load;

/// Force of a bristle of that stiffness, limited by the level of each cell; it stretches with the recorded motion.
pub(crate) fn bristle(motion: &Motion, stiffness: f64, level: &[f64]) -> Vec<f64> {
    let mut force: f64 = 0.0;
    let mut means = Vec::with_capacity(level.len());
    for (cell, &limit) in level.iter().enumerate() {
        // A level is a size; rounding of the means may leave a hair below zero.
        let limit = limit.max(0.0);
        let stretch = stiffness * (motion.smooth[cell + 1] - motion.smooth[cell]);
        let before = force.clamp(-limit, limit);
        force = (before + stretch).clamp(-limit, limit);
        let part = if stretch == 0.0 { 1.0 } else { ((force - before) / stretch).abs().min(1.0) };
        // Rises for a part of the cell, then yields.
        means.push(0.5 * (before + force) * part + force * (1.0 - part));
    }
    means
}

/// Dahl's friction: over a way x it approaches its level as exp(-stiffness x / level).
pub(crate) fn dahl(motion: &Motion, stiffness: f64, level: &[f64]) -> Vec<f64> {
    let mut force = 0.0;
    let mut means = Vec::with_capacity(level.len());
    for (cell, &level) in level.iter().enumerate() {
        let way = motion.smooth[cell + 1] - motion.smooth[cell];
        let target = level * way.signum();
        let rate = stiffness * way.abs() / level.max(1e-12);
        let away = force - target;
        let mean = if rate > 1e-9 { target + away * (1.0 - (-rate).exp()) / rate } else { force };
        force = if way == 0.0 { force } else { target + away * (-rate).exp() };
        means.push(mean);
    }
    means
}

/// What a load takes from the rotor, as means over the cells, N m (N), and the inertia that stays with the rotor.
///
/// Motor inertia J/(1+r) and load J r/(1+r) on a spring k = w^2 m and damper 2 z w m, with m their reduced mass and w the
/// resonance; the spring has a dead zone of the gap.
pub(crate) fn load(motion: &Motion, load: &Load, inertia: f64) -> (Vec<f64>, f64) {
    let motor = inertia / (1.0 + load.inertia_ratio);
    let moved = inertia - motor;
    let reduced = motor * moved / inertia;
    let omega = std::f64::consts::TAU * load.resonance_hz;
    let (stiffness, damping) = (omega * omega * reduced, 2.0 * load.damping_ratio * omega * reduced);
    let half = 0.5 * load.gap;
    let force = |q: f64, w: f64, x: f64, v: f64| {
        let stretch = q - x;
        if half == 0.0 {
            return stiffness * stretch + damping * (w - v);
        }
        if stretch.abs() <= half {
            return 0.0;
        }
        // Contact pushes only.
        let push = stiffness * (stretch - half.copysign(stretch)) + damping * (w - v);
        if push * stretch > 0.0 { push } else { 0.0 }
    };
    let fastest = (stiffness / moved).sqrt();
    let (mut x, mut v) = (motion.smooth[0], motion.speed[0]);
    let mut means = Vec::with_capacity(motion.cells());
    for cell in 0..motion.cells() {
        let span = motion.t_s[cell + 1] - motion.t_s[cell];
        let steps = (span * fastest / 0.3).ceil().clamp(1.0, 64.0);
        let h = span / steps;
        let (q0, w0) = (motion.smooth[cell], motion.speed[cell]);
        let rate = (motion.speed[cell + 1] - w0) / span;
        let mut impulse = 0.0;
        for step in 0..steps as usize {
            let at = |offset: f64| {
                let s = (step as f64 + offset) * h;
                (q0 + w0 * s + 0.5 * rate * s * s, w0 + rate * s)
            };
            let pull = |offset: f64, x: f64, v: f64| {
                let (q, w) = at(offset);
                force(q, w, x, v) / moved
            };
            let a1 = pull(0.0, x, v);
            let a2 = pull(0.5, x + 0.5 * h * v, v + 0.5 * h * a1);
            let a3 = pull(0.5, x + 0.5 * h * v + 0.25 * h * h * a1, v + 0.5 * h * a2);
            let a4 = pull(1.0, x + h * v + 0.5 * h * h * a2, v + h * a3);
            let change = h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
            x += h * v + h * h / 6.0 * (a1 + a2 + a3);
            v += change;
            impulse += change;
        }
        if motion.broken[cell] {
            (x, v) = (motion.smooth[cell + 1], motion.speed[cell + 1]);
        }
        means.push(moved * impulse / span);
    }
    (means, motor)
}
