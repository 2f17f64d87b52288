//! Whether a model leaves something that state predicts: means over the bins of a channel, each block from the others.

use super::state::{Channel, bins, channels};
use crate::read::AxisKind;
use crate::screen::{Fit, Problem};

/// What is left.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Channel that predicts the residual best.
    pub channel: String,
    /// Relative fall of the held-out root mean square of the residual by the means over its bins, 1.
    pub gain: f64,
    /// Mean square of the residual over that of its noise, 1.
    pub excess: f64,
}

/// The channel whose bins, learnt on the other blocks, predict the residual best.
pub fn leftover(problem: &Problem, fit: &Fit, axis: AxisKind) -> Leftover {
    let excess = fit.sse / fit.residual_count().max(1.0);
    let mut best = Leftover { channel: String::new(), gain: 0.0, excess };
    for channel in channels(problem, axis) {
        let gain = 1.0 - (1.0 - predicted(problem, fit, &channel)).sqrt();
        if gain > best.gain {
            best = Leftover { channel: channel.name, gain, excess };
        }
    }
    best
}

/// Share of the residual's squares that the means over a channel's bins predict in the blocks they were not taken from, 1;
/// negative where they mislead.
pub(super) fn predicted(problem: &Problem, fit: &Fit, channel: &Channel) -> f64 {
    let (mut before, mut after) = (0.0, 0.0);
    for bin in bins(channel) {
        let sum: f64 = bin.iter().map(|(index, _)| fit.residual[*index]).sum();
        let mut own = vec![(0.0, 0.0); problem.blocks];
        for (index, _) in &bin {
            let entry = &mut own[problem.equations[*index].block];
            *entry = (entry.0 + fit.residual[*index], entry.1 + 1.0);
        }
        for (index, _) in &bin {
            let (block_sum, block_count) = own[problem.equations[*index].block];
            let others = bin.len() as f64 - block_count;
            let predicted = if others > 0.0 { (sum - block_sum) / others } else { 0.0 };
            before += fit.residual[*index].powi(2);
            after += (fit.residual[*index] - predicted).powi(2);
        }
    }
    if before > 0.0 { 1.0 - after / before } else { 0.0 }
}
