//! Effects with a state of their own, run along the recorded motion: bristles, and loads behind a shaft or a gap.

use super::motion::Motion;

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
