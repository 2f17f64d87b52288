//! The state in each cell of a recording, as the terms of a formula read it.

use crate::effects::Physics;
use crate::screen::{Chain, Motion, chain_means, damper, drive};

/// One recording, cell by cell.
pub(super) struct State {
    /// Middle of the cell, s.
    pub t_s: Vec<f64>,
    /// rad (m).
    pub position: Vec<f64>,
    /// rad/s (m/s).
    pub speed: Vec<f64>,
    /// Sign of the speed, 0 at rest.
    pub sign: Vec<f64>,
    /// rad/s2 (m/s2).
    pub acceleration: Vec<f64>,
    /// Torque (force) of the drive behind its delay, N m (N).
    pub torque: Vec<f64>,
    /// Field in the fluid behind its delay, kV/mm; zero without a fluid.
    pub field: Vec<f64>,
    /// Torque of the fluid against the motion, N m (N), signed like the motion.
    pub drag: Vec<f64>,
    /// Time since the present motion began, by a break-away or a reversal, s.
    pub moving_s: Vec<f64>,
    /// How long the rotor rested before the present motion, s.
    pub rested_s: Vec<f64>,
}

impl State {
    /// Of a recording under a model.
    pub fn new(physics: &Physics, motion: &Motion) -> Self {
        let spans: Vec<f64> = motion.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let changes = motion.speed.windows(2).zip(&spans);
        let (moving_s, rested_s) = history(&motion.cell_sign, &spans);
        Self {
            t_s: motion.t_s.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect(),
            position: motion.cell_position.clone(),
            speed: motion.cell_speed.clone(),
            sign: motion.cell_sign.clone(),
            acceleration: changes.map(|(speed, span_s)| (speed[1] - speed[0]) / span_s).collect(),
            torque: drive(physics, motion),
            field: field(physics, motion),
            drag: damper(physics, motion),
            moving_s,
            rested_s,
        }
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.t_s.len()
    }
}

fn field(physics: &Physics, motion: &Motion) -> Vec<f64> {
    let Some(field) = &motion.field else { return vec![0.0; motion.cells()] };
    let chain = physics.damper.as_ref().map_or(
        Chain { delay_s: 0.0, slew_per_s: f64::INFINITY, rise_s: 0.0, fall_s: 0.0 },
        |damper| Chain {
            delay_s: damper.dead_time_s,
            slew_per_s: damper.slew_kv_mm_s,
            rise_s: damper.rise_s,
            fall_s: damper.fall_s,
        },
    );
    chain_means(&motion.t_s, field, chain).iter().map(|moments| moments.first).collect()
}

/// Since when each cell moves one way, and the rest before that, s.
fn history(sign: &[f64], spans: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut moving_s, mut rested_s, mut resting_s, mut direction) = (0.0, 0.0, 0.0, 0.0);
    let each = sign.iter().zip(spans).map(|(&sign, &span_s)| {
        if sign == 0.0 {
            resting_s += span_s;
            moving_s = 0.0;
            direction = 0.0;
        } else {
            if sign.signum() != direction {
                (moving_s, rested_s, resting_s) = (0.0, resting_s, 0.0);
                direction = sign.signum();
            }
            moving_s += span_s;
        }
        (moving_s, if sign == 0.0 { resting_s } else { rested_s })
    });
    each.unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motion_and_the_rest_before_it_are_timed() {
        let (moving, rested) = history(&[1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 1.0], &[0.5; 7]);
        assert_eq!(moving, [0.5, 1.0, 0.0, 0.0, 0.5, 1.0, 0.5]);
        assert_eq!(rested, [0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 0.0]);
    }
}
