//! What single effects look like, and how small they may be: for the field guide.

use super::drive::{Motion, STRIDE};
use super::menu::Item;
use super::noise::Noise;
use super::power::power;
use super::separation::Contest;
use super::{Planner, Request, Rival};
use crate::read::{AxisKind, Recording};
use crate::refit::HORIZON_S;
use crate::residual::{Residual, Window, curvature};

/// Differences of the second model from the first along motions of the first, in short windows with the best start taken
/// out, rad (m), one window after the other; nothing is fitted. None where a motion cannot be run.
pub fn signature(request: &Request<'_>, right: &Rival, rival: &Rival, items: &[Item]) -> Option<Vec<f64>> {
    let planner = Planner::new(request);
    let mut all = Vec::new();
    for item in items {
        let motion = planner.drive.motion(right, item)?;
        all.extend(Contest::new(right, &motion)?.unfitted(rival)?);
    }
    Some(all)
}

/// Probability that the test over blocks tells the second model, fitted, from the first along the motions of the first.
pub fn power_of(request: &Request<'_>, right: &Rival, rival: &Rival, items: &[Item]) -> Option<f64> {
    let planner = Planner::new(request);
    let (mut blocks, mut noise) = (Vec::new(), None);
    for item in items {
        let motion = planner.drive.motion(right, item)?;
        let contest = Contest::new(right, &motion)?;
        let of_motion = planner.noise(&motion);
        blocks.extend(contest.blocks(&contest.left(rival)?, &of_motion, STRIDE));
        noise = Some(of_motion);
    }
    Some(power(&blocks, 1, &noise?))
}

/// Residual of the second model, unfitted, along a motion of the first, with that motion as a recording.
pub fn mismatch(request: &Request<'_>, right: &Rival, rival: &Rival, item: &Item) -> Option<(Residual, Recording)> {
    let motion = Planner::new(request).drive.motion(right, item)?;
    let contest = Contest::new(right, &motion)?;
    let left = contest.unfitted(rival)?;
    let recording = recording(&motion, contest.positions(), request.machine.axis.kind);
    let windows = motion.starts.iter().zip(left.chunks_exact(motion.rows)).map(|(start, left)| {
        let (from, to) = (start.row, start.row + motion.rows);
        let t_s = &motion.t_s[from..to];
        let speed = (recording.position[to - 1] - recording.position[from]) / (t_s[t_s.len() - 1] - t_s[0]);
        let torque = right.base.inertia * curvature(t_s, left);
        Window { start: from, end: to, state: start.state, residual: left.to_vec(), torque, speed }
    });
    Some((Residual { horizon_s: HORIZON_S, windows: windows.collect() }, recording))
}

/// The motion as a recording; rows outside the windows have no position of their own and hold the last one.
fn recording(motion: &Motion, positions: &[f64], axis: AxisKind) -> Recording {
    let mut position = vec![0.0; motion.t_s.len()];
    for (start, window) in motion.starts.iter().zip(positions.chunks_exact(motion.rows)) {
        position[start.row..start.row + motion.rows].copy_from_slice(window);
        let last = window[window.len() - 1];
        position[start.row + motion.rows..].iter_mut().for_each(|p| *p = last);
    }
    Recording {
        name: "simulated".to_owned(),
        t_s: motion.t_s.clone(),
        position,
        effort_cmd: motion.commands.iter().map(|command| command.torque).collect(),
        field_cmd_kv_mm: Some(motion.commands.iter().map(|command| command.field_kv_mm).collect()),
        velocity: Some(motion.commands.iter().map(|command| command.speed_estimate).collect()),
        ..Recording::empty(axis)
    }
}

/// What windows of 50 ms leave under white noise of the sensor, rad (m), and of the torque held over each sample, as an
/// acceleration, rad/s2 (m/s2); root mean square, rad (m).
pub fn floor_of(sensor: f64, acceleration: f64, period_s: f64) -> f64 {
    Noise::of_sources(sensor, acceleration, (HORIZON_S / period_s).round() as usize, period_s).rms()
}
