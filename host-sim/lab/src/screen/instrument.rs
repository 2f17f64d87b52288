//! How the torque was recorded: a column that is no command but a measurement behind a first-order filter.
//!
//! It is no physics of the machine and in no vocabulary, but hides all of it: what acted leads what was recorded. Every
//! torque that the motion can tell (inertia, friction, the strongest orders over the angle) behind the same filter is regressed on the
//! recorded one, with each time constant of a grid.

use nalgebra::{DMatrix, DVector};

use super::candidates::orders_of;
use super::motion::Motion;

/// Time constants tried, s; zero is the column as it stands.
const GRID_S: [f64; 10] = [0.0, 0.005, 0.01, 0.02, 0.035, 0.06, 0.1, 0.15, 0.22, 0.35];
/// Orders over the angle.
const ORDERS: usize = 6;
/// Blocks that are left out in turn.
const BLOCKS: usize = 10;
/// The error on blocks left out must fall to this share of that of the column as it stands.
const FALLS_TO: f64 = 0.7;
/// Rows of a regression at most.
const MAX_ROWS: usize = 6000;

/// The time constant, s, of the filter that the torque was measured behind; none where the column is best as it stands.
pub(crate) fn effort_filter_s(motions: &[Motion], linear: bool) -> Option<f64> {
    let columns: Vec<Vec<Vec<f64>>> = motions.iter().map(|motion| columns(motion, linear)).collect();
    let error = |filter_s: f64| -> Option<f64> {
        motions.iter().zip(&columns).map(|(motion, columns)| heldout_error(motion, columns, filter_s)).sum()
    };
    let plain = error(0.0)?;
    let (mut best_s, mut least) = (0.0, plain);
    for filter_s in GRID_S {
        let here = error(filter_s)?;
        if here < least {
            (best_s, least) = (filter_s, here);
        }
    }
    if least > FALLS_TO * FALLS_TO * plain {
        return None;
    }
    // Refined between its neighbours on the grid.
    for ratio in [1.3, 1.15, 1.07, 1.03] {
        for filter_s in [best_s / ratio, best_s * ratio] {
            let here = error(filter_s)?;
            if here < least {
                (best_s, least) = (filter_s, here);
            }
        }
    }
    Some(best_s)
}

/// Mean square of what a regression without each block leaves of the recorded torque there; none for too short a recording.
fn heldout_error(motion: &Motion, columns: &[Vec<f64>], filter_s: f64) -> Option<f64> {
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| filtered(motion, column, filter_s)).collect();
    let cells = motion.cells();
    let stride = cells.div_ceil(MAX_ROWS);
    let used: Vec<usize> = (cells / 20..cells).step_by(stride).collect();
    if used.len() < 4 * columns.len().max(BLOCKS) {
        return None;
    }
    let whole = DMatrix::from_fn(used.len(), columns.len(), |row, column| columns[column][used[row]]);
    let effort = DVector::from_fn(used.len(), |row, _| motion.effort[used[row]]);
    let (normal, right) = (whole.tr_mul(&whole), whole.tr_mul(&effort));
    let ridge = DMatrix::from_diagonal(&(normal.diagonal() * 1e-6).add_scalar(1e-30));
    let mut squares = 0.0;
    for block in 0..BLOCKS {
        let (from, to) = (block * used.len() / BLOCKS, (block + 1) * used.len() / BLOCKS);
        let (part, here) = (whole.rows(from, to - from), effort.rows(from, to - from));
        let others = &normal - part.tr_mul(&part) + &ridge;
        let found = others.cholesky()?.solve(&(&right - part.tr_mul(&here)));
        squares += (here - part * found).norm_squared();
    }
    Some(squares / used.len() as f64)
}

/// What a torque may be made of, in each cell.
fn columns(motion: &Motion, linear: bool) -> Vec<Vec<f64>> {
    let acceleration = (0..motion.cells())
        .map(|cell| (motion.speed[cell + 1] - motion.speed[cell]) / (motion.t_s[cell + 1] - motion.t_s[cell]));
    let mut all = vec![acceleration.collect(), motion.cell_sign.clone(), motion.cell_speed.clone()];
    all.push(vec![1.0; motion.cells()]);
    for _ in 0..ORDERS {
        let left = left_over(motion, &all).map(|left| orders_of(&motion.cell_position, &left, linear));
        let Some(order) = left.and_then(|orders| orders.first().copied()) else { break };
        all.push(motion.cell_position.iter().map(|q| (order * q).sin()).collect());
        all.push(motion.cell_position.iter().map(|q| (order * q).cos()).collect());
    }
    all
}

/// What columns leave of the recorded torque.
fn left_over(motion: &Motion, columns: &[Vec<f64>]) -> Option<Vec<f64>> {
    let whole = DMatrix::from_fn(motion.cells(), columns.len(), |row, column| columns[column][row]);
    let effort = DVector::from_fn(motion.cells(), |row, _| motion.effort[row]);
    let mut normal = whole.tr_mul(&whole);
    normal += DMatrix::from_diagonal(&(normal.diagonal() * 1e-6).add_scalar(1e-30));
    let found = normal.cholesky()?.solve(&whole.tr_mul(&effort));
    Some((effort - whole * found).as_slice().to_vec())
}

/// A column behind a first-order filter that begins settled.
fn filtered(motion: &Motion, column: &[f64], filter_s: f64) -> Vec<f64> {
    if filter_s <= 0.0 {
        return column.to_vec();
    }
    let mut state = column.first().copied().unwrap_or(0.0);
    let follow = |(cell, value): (usize, &f64)| {
        let span_s = motion.t_s[cell + 1] - motion.t_s[cell];
        state += (1.0 - (-span_s / filter_s).exp()) * (value - state);
        state
    };
    column.iter().enumerate().map(follow).collect()
}
