//! Which groups of columns explain the residual: forward selection by an information criterion, and sequentially
//! thresholded least squares.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::columns::Table;

/// Torque, as the root mean square of a term, below which the sparse regression drops it, N m.
const THRESHOLD_NM: f64 = 0.05;
/// Ridge of the sparse regression, for columns of unit root mean square: that of PySINDy's optimiser.
const RIDGE: f64 = 0.05;
/// Rounds of the sparse regression; those of PySINDy's optimiser.
const ROUNDS: usize = 20;
/// Groups a forward selection takes at most.
const MOST: usize = 12;
/// Effects of which one is taken at most. With the torque, the acceleration and all drag free the balance of the torques
/// itself would be an exact fit, of anything.
const SCALES: [&str; 2] = ["inertia", "torque_gain"];

/// A script goes on for as long as a further group lowers the error on data it was not fitted to by this share.
const LOWER: f64 = 0.03;

/// What one more parameter costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Criterion {
    /// ln n.
    Bayes,
    /// 2.
    Akaike,
}

/// Products of all columns with each other and with the residual, columns scaled to unit root mean square.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    rows: f64,
    scale: Vec<f64>,
    products: DMatrix<f64>,
    onto: DVector<f64>,
    residual: f64,
}

impl Gram {
    pub(super) fn of(table: &Table) -> Self {
        let (rows, columns) = (table.rows.len(), table.rows.first().map_or(0, Vec::len));
        let flat = table.rows.iter().flatten().copied();
        let matrix = DMatrix::from_row_iterator(rows, columns, flat);
        let residual = DVector::from_column_slice(&table.residual);
        let count = rows.max(1) as f64;
        let norm = |column: usize| (matrix.column(column).norm_squared() / count).sqrt();
        let scale: Vec<f64> = (0..columns).map(|column| 1.0 / norm(column).max(1e-12)).collect();
        let scales = DMatrix::from_diagonal(&DVector::from_column_slice(&scale));
        let products = &scales * matrix.tr_mul(&matrix) * &scales / count;
        let onto = &scales * matrix.tr_mul(&residual) / count;
        Self { rows: count, scale, products, onto, residual: residual.norm_squared() / count }
    }

    /// Weights of scaled columns by least squares with a ridge; none where they depend on each other.
    fn solve(&self, columns: &[usize], ridge: f64) -> Option<DVector<f64>> {
        let mut products = self.products.select_columns(columns).select_rows(columns);
        for k in 0..columns.len() {
            products[(k, k)] += ridge + 1e-10;
        }
        Some(Cholesky::new(products)?.solve(&self.onto.select_rows(columns)))
    }

    /// Weights of the columns as they are.
    pub(super) fn fit(&self, columns: &[usize]) -> Option<Vec<f64>> {
        let weights = self.solve(columns, 0.0)?;
        Some(columns.iter().zip(&weights).map(|(&column, weight)| weight * self.scale[column]).collect())
    }

    /// Mean square that these columns leave.
    fn left(&self, columns: &[usize]) -> Option<f64> {
        let weights = self.solve(columns, 0.0)?;
        Some((self.residual - weights.dot(&self.onto.select_rows(columns))).max(1e-300))
    }

    /// Adds the group that lowers the criterion most, until none does. One group an effect.
    pub(super) fn forward(&self, table: &Table, groups: &[usize], criterion: Criterion) -> Vec<usize> {
        let each = match criterion {
            Criterion::Bayes => self.rows.ln(),
            Criterion::Akaike => 2.0,
        };
        let value = |chosen: &[usize]| {
            let columns = table.columns_of(chosen);
            self.left(&columns).map(|left| self.rows * left.ln() + each * columns.len() as f64)
        };
        let nothing = self.rows * self.residual.max(1e-300).ln();
        select(table, groups, nothing, value, |best| best)
    }

    /// Adds the group that lowers the error on unseen data most, until none lowers it by three hundredths.
    pub(super) fn by_prediction(&self, table: &Table, unseen: &Table, groups: &[usize]) -> Vec<usize> {
        let value = |chosen: &[usize]| {
            let columns = table.columns_of(chosen);
            self.fit(&columns).map(|weights| unseen.rms_after(&columns, &weights))
        };
        select(table, groups, unseen.rms(), value, |best| (1.0 - LOWER) * best)
    }

    /// Sequentially thresholded ridge regression on all columns (S. Brunton, J. Proctor, N. Kutz, 2016), largest term
    /// first; the torque is what is explained, as in every inverse dynamic model.
    pub(super) fn sparse(&self, table: &Table, groups: &[usize]) -> Vec<usize> {
        let inverse_dynamics: Vec<usize> =
            groups.iter().copied().filter(|&group| table.groups[group].id != SCALES[1]).collect();
        let mut columns = table.columns_of(&inverse_dynamics);
        let mut weights = Vec::new();
        for _ in 0..ROUNDS {
            let Some(solved) = self.solve(&columns, RIDGE) else { return Vec::new() };
            let kept: Vec<(usize, f64)> = columns.iter().copied().zip(solved.iter().copied()).collect();
            weights = kept.into_iter().filter(|(_, weight)| weight.abs() >= THRESHOLD_NM).collect::<Vec<_>>();
            if weights.len() == columns.len() || weights.is_empty() {
                break;
            }
            columns = weights.iter().map(|(column, _)| *column).collect();
        }
        weights.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        let of = |column: usize| groups.iter().copied().find(|&group| table.groups[group].columns.contains(&column));
        let mut chosen: Vec<usize> = Vec::new();
        for group in weights.iter().filter_map(|(column, _)| of(*column)) {
            if !chosen.contains(&group) {
                chosen.push(group);
            }
        }
        chosen
    }
}

/// Adds the group with the least value for as long as that is below what the value so far demands.
fn select(
    table: &Table,
    groups: &[usize],
    nothing: f64,
    value: impl Fn(&[usize]) -> Option<f64>,
    demanded: impl Fn(f64) -> f64,
) -> Vec<usize> {
    let mut chosen: Vec<usize> = Vec::new();
    let mut best = nothing;
    while chosen.len() < MOST {
        let excludes = |a: &str, b: &str| a == b || SCALES.contains(&a) && SCALES.contains(&b);
        let taken = |group: usize| chosen.iter().any(|&other| excludes(table.groups[other].id, table.groups[group].id));
        let with = |group: usize| {
            let more: Vec<usize> = chosen.iter().copied().chain([group]).collect();
            value(&more).map(|value| (group, value))
        };
        let open = groups.iter().copied().filter(|&group| !taken(group));
        match open.filter_map(with).min_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((group, value)) if value < demanded(best) => {
                chosen.push(group);
                best = value;
            }
            _ => break,
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prove::rivals::columns::Group;

    /// Three columns of which the second makes the residual, with a little noise.
    fn table() -> Table {
        let waves = |k: usize| [(0.7 * k as f64).sin(), (1.3 * k as f64).cos(), (2.9 * k as f64).sin()];
        let rows: Vec<Vec<f64>> = (0..400).map(|k| waves(k).to_vec()).collect();
        let noise = |k: usize| 0.01 * ((k * k) as f64 * 0.37).sin();
        let residual = rows.iter().enumerate().map(|(k, row)| 2.0 * row[1] + noise(k)).collect();
        let group = |(k, id)| Group { id, columns: k..k + 1 };
        Table { groups: ["a", "b", "c"].into_iter().enumerate().map(group).collect(), residual, rows }
    }

    #[test]
    fn the_column_that_made_the_residual_is_chosen_first_and_its_weight_found() {
        let table = table();
        let gram = Gram::of(&table);
        assert_eq!(gram.forward(&table, &[0, 1, 2], Criterion::Bayes), [1]);
        assert_eq!(gram.forward(&table, &[0, 1, 2], Criterion::Akaike)[0], 1);
        assert_eq!(gram.sparse(&table, &[0, 1, 2]), [1]);
        let weights = gram.fit(&[1]).unwrap_or_default();
        assert!((weights[0] - 2.0).abs() < 1e-2 && table.rms_after(&[1], &weights) < 0.02, "{weights:?}");
    }
}
