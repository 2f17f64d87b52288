//! Terms as columns of the torque balance, and what they predict of blocks left out.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::state::State;
use super::terms::Term;
use crate::screen::{Fit, Problem, solve_near};

/// The residual that is to be explained, with the state that may explain it.
pub(super) struct Columns<'a> {
    pub problem: &'a Problem,
    weights: &'a [f64],
    pub states: Vec<State>,
    /// Weighted residual of each equation.
    pub residual: &'a DVector<f64>,
    /// Equations of each block that has any.
    blocks: Vec<Range<usize>>,
    /// Equations to fit; the rest is only predicted.
    pub fitted: usize,
}

/// Held-out squares: of the blocks left out, then of the blocks of recordings held out.
#[derive(Debug, Clone)]
pub(super) struct Held {
    pub blocks: Vec<f64>,
    /// How many of them are of recordings to fit.
    pub fitted: usize,
}

impl Held {
    /// Over all blocks.
    pub fn total(&self) -> f64 {
        self.blocks.iter().sum()
    }

    /// Share of the squares that is gone: the lesser of blocks left out and recordings held out, 1.
    pub fn squares_less(&self, before: &Self) -> f64 {
        let less = |part: Range<usize>| {
            let (now, then): (f64, f64) = (self.blocks[part.clone()].iter().sum(), before.blocks[part].iter().sum());
            1.0 - now / then.max(1e-300)
        };
        let (all, fitted) = (self.blocks.len(), self.fitted);
        if fitted < all { less(0..fitted).min(less(fitted..all)) } else { less(0..all) }
    }
}

impl<'a> Columns<'a> {
    /// What `base` leaves.
    pub fn new(problem: &'a Problem, weights: &'a [f64], base: &'a Fit) -> Self {
        let physics = problem.machine(&base.active);
        let mut blocks: Vec<Range<usize>> = Vec::new();
        for run in problem.equations.chunk_by(|a, b| a.block == b.block) {
            let from = blocks.last().map_or(0, |last| last.end);
            blocks.push(from..from + run.len());
        }
        Self {
            problem,
            weights,
            states: problem.motions.iter().map(|motion| State::new(&physics, motion)).collect(),
            residual: &base.residual,
            blocks,
            fitted: problem.fitted_equations(),
        }
    }

    /// Weighted means of a term over the bumps: two columns for a wave, else one.
    pub fn of(&self, term: &Term) -> Vec<DVector<f64>> {
        let cells: Vec<Vec<Vec<f64>>> = self.states.iter().map(|state| term.cells(state)).collect();
        let column = |part: usize| {
            let each = self.problem.equations.iter().zip(self.weights);
            let values = each.map(|(equation, weight)| weight * equation.row.mean(&cells[equation.recording][part]));
            DVector::from_iterator(self.weights.len(), values)
        };
        (0..term.columns()).map(column).collect()
    }

    /// Normal matrix and gradient of a range of equations.
    fn normal(&self, columns: &[DVector<f64>], rows: &Range<usize>) -> (DMatrix<f64>, DVector<f64>) {
        let part: Vec<_> = columns.iter().map(|column| column.rows_range(rows.clone())).collect();
        let residual = self.residual.rows_range(rows.clone());
        let count = columns.len();
        let mut normal = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                normal[(i, j)] = part[i].dot(&part[j]);
                normal[(j, i)] = normal[(i, j)];
            }
        }
        (normal, DVector::from_fn(count, |i, _| -part[i].dot(&residual)))
    }

    /// Least squares over the recordings to fit: coefficients and sum of squares left.
    pub fn solve(&self, columns: &[DVector<f64>]) -> (DVector<f64>, f64) {
        let (normal, gradient) = self.normal(columns, &(0..self.fitted));
        let found = solve_near(&normal, &(&normal * 1e-7), &gradient);
        let left = self.left(columns, &found, &(0..self.fitted));
        (found, left.norm_squared())
    }

    /// What coefficients leave of a range of equations.
    pub fn left(&self, columns: &[DVector<f64>], found: &DVector<f64>, rows: &Range<usize>) -> DVector<f64> {
        let mut left = self.residual.rows_range(rows.clone()).into_owned();
        for (column, coefficient) in columns.iter().zip(found.iter()) {
            left.axpy(-coefficient, &column.rows_range(rows.clone()), 1.0);
        }
        left
    }

    /// Each block predicted by a fit without it; recordings held out by a fit of all others.
    pub fn held(&self, columns: &[DVector<f64>]) -> Held {
        let parts: Vec<_> = self.blocks.iter().map(|rows| self.normal(columns, rows)).collect();
        let fitted = self.blocks.partition_point(|rows| rows.start < self.fitted);
        let (mut normal, mut gradient) = (DMatrix::zeros(columns.len(), columns.len()), DVector::zeros(columns.len()));
        for (part, pull) in &parts[..fitted] {
            normal += part;
            gradient += pull;
        }
        let predicted = self.blocks.iter().enumerate().map(|(block, rows)| {
            let found = if block < fitted {
                solve_near(&(&normal - &parts[block].0), &normal, &(&gradient - &parts[block].1))
            } else {
                solve_near(&normal, &(&normal * 1e-7), &gradient)
            };
            self.left(columns, &found, rows).norm_squared()
        });
        Held { blocks: predicted.collect(), fitted }
    }

    /// Held-out squares without a formula.
    pub fn nothing(&self) -> Held {
        self.held(&[])
    }

    /// Blocks of the equations to fit.
    pub fn fitted_blocks(&self) -> impl Iterator<Item = &Range<usize>> {
        self.blocks.iter().filter(|rows| rows.start < self.fitted)
    }
}
