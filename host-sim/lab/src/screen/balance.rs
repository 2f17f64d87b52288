//! The torque balance along a recorded motion: what acts on the rotor, as means over the cells between samples.

use std::sync::Arc;

use super::actuation::{Chain, chain_means, held_means};
use super::internal;
use super::motion::Motion;
use super::waves::Wave;
use crate::effects::{Damper, Physics, Viscosity};

/// Torque of the drive in each cell, N m (N).
pub(crate) fn drive(physics: &Physics, motion: &Motion) -> Vec<f64> {
    let banded: Vec<f64>;
    let command = if physics.torque_deadband > 0.0 {
        let band = physics.torque_deadband;
        banded = motion.effort.iter().map(|&u| u.signum() * (u.abs() - band).max(0.0)).collect();
        &banded
    } else {
        &motion.effort
    };
    let delay_s = physics.torque_delay_s + physics.latency_s;
    let limit = physics.torque_limit;
    let acting: Vec<f64> =
        command.iter().map(|u| (physics.torque_gain * u + physics.torque_offset).clamp(-limit, limit)).collect();
    if physics.torque_lag_s > 0.0 {
        let (rise_s, fall_s) = (physics.torque_lag_s, physics.torque_lag_s);
        let chain = Chain { delay_s, slew_per_s: f64::INFINITY, rise_s, fall_s };
        chain_means(&motion.t_s, &acting, chain).iter().map(|moments| moments.first).collect()
    } else {
        held_means(&motion.t_s, &acting, delay_s)
    }
}

/// Drag of the damper in each cell, N m (N), signed with the motion.
pub(crate) fn damper(physics: &Physics, motion: &Motion) -> Vec<f64> {
    let Some((damper, level)) = yield_level(physics, motion) else { return vec![0.0; motion.cells()] };
    if damper.preyield.is_finite() {
        return internal::bristle(motion, damper.preyield, &level);
    }
    level.iter().zip(&motion.cell_sign).map(|(level, sign)| level * sign).collect()
}

/// The damper, and the drag in each cell at which its fluid yields, N m (N), without direction; none without a fluid.
pub(crate) fn yield_level<'a>(physics: &'a Physics, motion: &Motion) -> Option<(&'a Damper, Vec<f64>)> {
    let (damper, field) = (physics.damper.as_ref()?, motion.field.as_ref()?);
    let mut level = match damper.viscosity {
        None => field_level(damper, motion, field, physics.latency_s),
        Some(viscosity) => viscosity_level(damper, viscosity, motion, field, physics.latency_s),
    };
    for (level, t_s) in level.iter_mut().zip(&motion.t_s) {
        *level *= damper.scale * (1.0 + damper.drift_per_s * t_s).max(0.0);
    }
    Some((damper, level))
}

fn field_level(damper: &Damper, motion: &Motion, field: &[f64], latency_s: f64) -> Vec<f64> {
    let chain = Chain {
        delay_s: damper.dead_time_s + latency_s,
        slew_per_s: damper.slew_kv_mm_s / damper.gain.max(1e-9),
        rise_s: damper.rise_s,
        fall_s: damper.fall_s,
    };
    let (a, b) = (damper.a * damper.gain * damper.gain, damper.b * damper.gain);
    chain_means(&motion.t_s, field, chain).iter().map(|moments| a * moments.second + b * moments.first).collect()
}

/// The paper's Q models: Q of command and speed estimate is delayed, times the speed; a braking field is a torque.
fn viscosity_level(damper: &Damper, viscosity: Viscosity, motion: &Motion, field: &[f64], latency_s: f64) -> Vec<f64> {
    let torque = |e: f64| damper.a * e * e + damper.b * e;
    let braking = |row: usize| motion.braking.as_ref().is_some_and(|braking| braking[row]);
    let rows = 0..field.len();
    let gain = damper.gain;
    let coefficient: Vec<f64> =
        rows.clone()
            .map(|row| {
                if braking(row) { 0.0 } else { torque(gain * field[row]) / motion.speed_estimate[row].abs().max(0.002) }
            })
            .collect();
    let brake: Vec<f64> = rows.map(|row| if braking(row) { torque(gain * field[row]) } else { 0.0 }).collect();
    let (delay_s, lag_s) = match viscosity {
        Viscosity::DeadTime(dead_time_s) => (dead_time_s, 0.0),
        Viscosity::Lag(lag_s) => (0.0, lag_s),
    };
    let chain = Chain { delay_s: delay_s + latency_s, slew_per_s: f64::INFINITY, rise_s: lag_s, fall_s: lag_s };
    let ceiling = torque(3.5);
    let delayed = chain_means(&motion.t_s, &coefficient, chain);
    let braked = chain_means(&motion.t_s, &brake, chain);
    let cells = delayed.iter().zip(&braked).zip(&motion.cell_speed);
    cells.map(|((q, brake), w)| (q.first * w.abs()).min(ceiling) + brake.first).collect()
}

/// Friction of the bearing in each cell, N m (N), signed with the motion.
pub(crate) fn friction(physics: &Physics, motion: &Motion) -> Vec<f64> {
    let excess = |w: f64| {
        if physics.stribeck_excess == 0.0 {
            0.0
        } else {
            physics.stribeck_excess * (-(w / physics.stribeck_velocity).powi(2)).exp()
        }
    };
    let cells = motion.cell_speed.iter().zip(&motion.cell_sign);
    let level: Vec<f64> =
        cells.clone().map(|(w, s)| physics.coulomb + excess(*w) + 0.5 * physics.asymmetry * s).collect();
    let dry = if physics.presliding.is_finite() {
        internal::dahl(motion, physics.presliding, &level)
    } else {
        level.iter().zip(&motion.cell_sign).map(|(level, sign)| level * sign).collect()
    };
    let slope =
        |w: f64| physics.viscous * w + 0.5 * physics.asymmetry_viscous * w.abs() + physics.quadratic * w * w.abs();
    dry.iter().zip(cells).map(|(dry, (w, _))| dry + slope(*w)).collect()
}

/// Torque over position and time in each cell, N m (N), as it acts on the rotor; `waves` are those of this recording.
pub(crate) fn external(physics: &Physics, motion: &Motion, recording: usize, waves: &[Arc<Wave>]) -> Vec<f64> {
    let mut torque: Vec<f64> = motion.cell_position.iter().map(|q| -physics.spring * q).collect();
    let harmonics = physics.cogging.iter().chain(&physics.gravity).map(|harmonic| (harmonic.sine, harmonic.cosine));
    let phasors = physics.vibration.iter().map(|v| v.phasors.get(recording).copied().unwrap_or_default());
    for ((sine, cosine), wave) in harmonics.chain(phasors).zip(waves) {
        torque.iter_mut().zip(wave.iter()).for_each(|(torque, (s, c))| *torque += sine * s + cosine * c);
    }
    for pulse in physics.pulses.iter().filter(|pulse| pulse.recording == recording) {
        for (cell, torque) in torque.iter_mut().enumerate() {
            let (from, to) = (motion.t_s[cell], motion.t_s[cell + 1]);
            let overlap = (to.min(pulse.start_s + pulse.duration_s) - from.max(pulse.start_s)).max(0.0);
            *torque += pulse.amplitude * overlap / (to - from);
        }
    }
    torque
}
