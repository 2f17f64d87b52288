//! Forward selection of terms with exchanges, each step judged by what it predicts.

use nalgebra::DVector;
use rayon::prelude::*;

use super::MIN_SQUARES;
use super::columns::{Columns, Held};
use super::terms::Term;
use crate::read::AxisKind;
use crate::screen::{MAX_P, MIN_GAIN, MIN_T, f_test, t_of_mean};

/// Terms at most.
const MAX_TERMS: usize = 4;
/// Halvings of the step when the parameter of a term is fitted.
const HALVINGS: usize = 7;
/// A term that takes less than this share of all that was missing is fine print, 1.
const FINE_PRINT: f64 = 0.005;
/// Terms that predict within this share of the best one's held-out squares are as good; the simplest is taken.
const AS_GOOD: f64 = 0.01;

/// A formula that passed every step.
#[derive(Debug)]
pub(super) struct Selection {
    pub terms: Vec<Term>,
    pub held: Held,
    /// Squares left over the recordings to fit.
    pub sse: f64,
}

/// A set of terms as columns.
#[derive(Clone)]
struct Set {
    terms: Vec<Term>,
    columns: Vec<DVector<f64>>,
    held: Held,
}

/// The sparse formula that predicts best; none where no term predicts.
pub(super) fn select(columns: &Columns<'_>, candidates: &[Term], axis: AxisKind) -> Option<Selection> {
    let mut best = Set { terms: Vec::new(), columns: Vec::new(), held: columns.nothing() };
    while best.terms.len() < MAX_TERMS {
        let Some(next) = best_with(columns, &best, candidates, axis) else { break };
        if !accepted(columns, &best, &next, candidates.len()) {
            break;
        }
        best = exchanged(columns, next, candidates, axis);
    }
    best = thinned(columns, best);
    let (_, sse) = columns.solve(&best.columns);
    (!best.terms.is_empty()).then_some(Selection { terms: best.terms, held: best.held, sse })
}

/// The set with the one term more that predicts best, its parameter fitted.
fn best_with(columns: &Columns<'_>, base: &Set, candidates: &[Term], axis: AxisKind) -> Option<Set> {
    let open = candidates.par_iter().filter(|term| !base.terms.contains(term));
    let mut tried: Vec<(f64, Term)> = open.map(|term| (with(columns, base, *term).held.total(), *term)).collect();
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (lowest, _) = *tried.first()?;
    // Every family at its own best parameter: a coarse grid must not decide between families.
    let mut finalists: Vec<Set> = Vec::new();
    for (_, term) in tried.iter().take_while(|(held, _)| *held < 1.3 * lowest) {
        let known = finalists.iter().filter_map(|set| set.terms.last());
        if finalists.len() < 4 && !known.clone().any(|other| (other.carrier, other.form) == (term.carrier, term.form)) {
            finalists.push(fitted(columns, base, *term, axis));
        }
    }
    let lowest = finalists.iter().map(|set| set.held.total()).min_by(f64::total_cmp)?;
    let freedom = |set: &Set| set.columns.len() + set.terms.iter().filter(|term| term.adjustable(axis)).count();
    finalists.into_iter().filter(|set| set.held.total() <= (1.0 + AS_GOOD) * lowest).min_by_key(freedom)
}

fn with(columns: &Columns<'_>, base: &Set, term: Term) -> Set {
    let mut set = base.clone();
    set.terms.push(term);
    set.columns.extend(columns.of(&term));
    set.held = columns.held(&set.columns);
    set
}

/// The same with the parameter of the last term where it leaves least, found by halving steps.
fn fitted(columns: &Columns<'_>, base: &Set, term: Term, axis: AxisKind) -> Set {
    if !term.adjustable(axis) {
        return with(columns, base, term);
    }
    let left = |term: &Term| columns.solve(&[base.columns.clone(), columns.of(term)].concat()).1;
    let mut best = (left(&term), term);
    let mut step = 0.35;
    for _ in 0..HALVINGS {
        for factor in [1.0 + step, 1.0 / (1.0 + step)] {
            let moved = Term { parameter: best.1.parameter * factor, ..best.1 };
            if !moved.resolved() {
                continue;
            }
            let squares = left(&moved);
            if squares < best.0 {
                best = (squares, moved);
                break;
            }
        }
        step *= 0.5;
    }
    with(columns, base, best.1)
}

/// Whether one term more is more than chance, by the rules of the screen: less held-out error in blocks and recordings,
/// significant under coloured residuals after correction for every term tried, and certain over blocks.
fn accepted(columns: &Columns<'_>, before: &Set, after: &Set, tried: usize) -> bool {
    let gain = 1.0 - (after.held.total() / before.held.total().max(1e-300)).sqrt();
    let (found, _) = columns.solve(&after.columns);
    let left = columns.left(&after.columns, &found, &(0..columns.residual.len()));
    let (_, squares) = columns.solve(&before.columns);
    let free = after.columns.len();
    let p = f_test(columns.problem, squares, &left, (free - before.columns.len(), free));
    gain >= MIN_GAIN && p * (tried as f64) < MAX_P && t_over_blocks(&before.held, &after.held) >= MIN_T
}

/// t of the fall of the held-out squares, paired over blocks, in squares or in shares of each block's own.
fn t_over_blocks(before: &Held, after: &Held) -> f64 {
    let pairs = before.blocks.iter().zip(&after.blocks).filter(|(a, b)| *a + *b > 0.0);
    let squares: Vec<f64> = pairs.clone().map(|(a, b)| a - b).collect();
    let shares: Vec<f64> = pairs.map(|(a, b)| (a - b) / (a + b)).collect();
    t_of_mean(&squares).max(t_of_mean(&shares))
}

/// Replaces a term by another where that predicts better.
fn exchanged(columns: &Columns<'_>, set: Set, candidates: &[Term], axis: AxisKind) -> Set {
    let mut best = set;
    if best.terms.len() < 2 {
        return best;
    }
    for index in 0..best.terms.len() {
        let rest = without(columns, &best, index);
        let replaced = best_with(columns, &rest, candidates, axis);
        // Squares fall twice as fast as their root.
        let gains = |set: &Set| 1.0 - set.held.total() / best.held.total() > 2.0 * MIN_GAIN;
        if let Some(replaced) = replaced.filter(gains) {
            best = replaced;
        }
    }
    best
}

fn without(columns: &Columns<'_>, set: &Set, index: usize) -> Set {
    let mut terms = set.terms.clone();
    terms.remove(index);
    let parts: Vec<DVector<f64>> = terms.iter().flat_map(|term| columns.of(term)).collect();
    Set { held: columns.held(&parts), terms, columns: parts }
}

/// Drops terms that the held-out blocks do not miss, and the fine print of a formula that predicts without it.
fn thinned(columns: &Columns<'_>, mut set: Set) -> Set {
    let nothing = columns.nothing();
    loop {
        let smaller = (0..set.terms.len()).map(|index| without(columns, &set, index));
        let Some(least) = smaller.min_by(|a, b| a.held.total().total_cmp(&b.held.total())) else { return set };
        let lost = least.held.total() - set.held.total();
        let not_missed = lost < 2.0 * MIN_GAIN * least.held.total();
        let fine_print = lost < FINE_PRINT * nothing.total() && least.held.squares_less(&nothing) >= MIN_SQUARES;
        if !(not_missed || fine_print) {
            return set;
        }
        set = least;
    }
}
