//! Points thinned to what the pixels can show.

use std::collections::HashSet;
use std::ops::Range;

use super::figure::is_shown;

/// Pieces of a curve between breaks, thinned over `columns` columns of the x range.
///
/// Where x rises, a column keeps its first, lowest, highest and last point: no peak is lost. A curve that turns back
/// keeps every n-th point instead.
pub(super) fn curve(points: &[(f64, f64)], x: &Range<f64>, columns: usize) -> Vec<Vec<(f64, f64)>> {
    let most = 4 * columns;
    let pieces: Vec<_> = points.split(|point| !is_shown(point)).filter(|piece| !piece.is_empty()).collect();
    let rising = pieces.iter().all(|piece| piece.is_sorted_by(|one, next| one.0 <= next.0));
    let stride = points.len().div_ceil(most).max(1);
    let thin = |piece: &&[(f64, f64)]| if rising { by_column(piece, x, columns) } else { every(piece, stride) };
    let thinned: Vec<_> = pieces.iter().map(thin).collect();
    // Breaks can outnumber pixels: each piece may add its four points to a column that has four already. Then pieces are
    // left out evenly.
    let kept: usize = thinned.iter().map(Vec::len).sum();
    thinned.into_iter().step_by(kept.div_ceil(2 * most).max(1)).collect()
}

fn every(points: &[(f64, f64)], stride: usize) -> Vec<(f64, f64)> {
    let mut kept: Vec<_> = points.iter().copied().step_by(stride).collect();
    if !(points.len() - 1).is_multiple_of(stride) {
        kept.extend(points.last());
    }
    kept
}

fn by_column(points: &[(f64, f64)], x: &Range<f64>, columns: usize) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| ((point.0 - x.start) / (x.end - x.start) * columns as f64).floor() as i64;
    let mut kept = Vec::new();
    for chunk in points.chunk_by(|one, next| column(one) == column(next)) {
        let by_y = |&a: &usize, &b: &usize| chunk[a].1.total_cmp(&chunk[b].1);
        let mut indices = [
            0,
            (0..chunk.len()).min_by(by_y).unwrap_or_default(),
            (0..chunk.len()).max_by(by_y).unwrap_or_default(),
            chunk.len() - 1,
        ];
        indices.sort_unstable();
        let mut before = None;
        for index in indices {
            if before != Some(index) {
                kept.push(chunk[index]);
            }
            before = Some(index);
        }
    }
    kept
}

/// At most `most` of the points: one for each cell of the finest square grid that leaves no more.
pub(super) fn cloud(points: &[(f64, f64)], x: &Range<f64>, y: &Range<f64>, most: usize) -> Vec<(f64, f64)> {
    let mut kept: Vec<_> = points.iter().copied().filter(is_shown).collect();
    let mut cells = 1024.0;
    while kept.len() > most {
        let mut taken = HashSet::new();
        kept.retain(|point| {
            let cell =
                |value: f64, range: &Range<f64>| ((value - range.start) / (range.end - range.start) * cells) as i64;
            taken.insert((cell(point.0, x), cell(point.1, y)))
        });
        cells /= 1.25;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_peak_among_a_million_points_stays() {
        let mut points: Vec<_> = (0..1_000_000).map(|k| (f64::from(k), 0.0)).collect();
        points[654_321].1 = 1.0;
        points[123_456].1 = -1.0;
        let kept = curve(&points, &(0.0..1e6), 800);
        assert_eq!(kept.len(), 1);
        assert!(kept[0].len() <= 3204, "{}", kept[0].len());
        assert!(kept[0].contains(&(654_321.0, 1.0)) && kept[0].contains(&(123_456.0, -1.0)));
        assert_eq!((kept[0].first(), kept[0].last()), (Some(&(0.0, 0.0)), Some(&(999_999.0, 0.0))));
    }

    #[test]
    fn breaks_stay_breaks() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0), (3.0, 4.0), (4.0, f64::INFINITY)];
        assert_eq!(curve(&points, &(0.0..4.0), 10), [vec![(0.0, 1.0)], vec![(2.0, 3.0), (3.0, 4.0)]]);
        let many: Vec<_> = (0..100_000).map(|k| (f64::from(k), if k % 2 == 0 { 0.0 } else { f64::NAN })).collect();
        assert!(curve(&many, &(0.0..1e5), 100).len() <= 800);
    }

    #[test]
    fn clouds_and_orbits_are_thinned() {
        let orbit: Vec<_> = (0..500_000).map(|k| f64::from(k) * 0.1).map(|angle| (angle.sin(), angle.cos())).collect();
        assert!(curve(&orbit, &(-1.0..1.0), 500)[0].len() <= 2001);
        let kept = cloud(&orbit, &(-1.0..1.0), &(-1.0..1.0), 1500);
        assert!(kept.len() <= 1500 && kept.len() > 700, "{}", kept.len());
    }
}
