//! Broken lines: a path cut into the pieces that are drawn. The drawing library's own dashes begin anew nowhere and know no
//! dots between dashes.

use super::Stroke;

/// Lengths drawn and left out in turn, in units of the drawing; none for an unbroken line.
fn pattern(stroke: Stroke) -> &'static [f64] {
    match stroke {
        Stroke::Solid => &[],
        Stroke::Dashed => &[18.0, 10.0],
        Stroke::Dotted => &[4.0, 8.0],
        Stroke::DashDot => &[18.0, 8.0, 4.0, 8.0],
    }
}

/// The pieces of a path that are drawn; `scale` is the length of one unit of x and of y in units of the drawing.
pub(super) fn broken(path: &[(f64, f64)], stroke: Stroke, scale: (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let pattern = pattern(stroke);
    let (Some(first), false) = (path.first(), pattern.is_empty()) else { return vec![path.to_vec()] };
    let (mut pieces, mut piece) = (Vec::new(), vec![*first]);
    let (mut part, mut left) = (0, pattern[0]);
    for pair in path.windows(2) {
        let (mut from, to) = (pair[0], pair[1]);
        loop {
            let length = ((to.0 - from.0) * scale.0).hypot((to.1 - from.1) * scale.1);
            let drawn = part % 2 == 0;
            if length <= left {
                left -= length;
                if drawn {
                    piece.push(to);
                }
                break;
            }
            let share = left / length;
            from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            if drawn {
                piece.push(from);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![from];
            }
            part = (part + 1) % pattern.len();
            left = pattern[part];
        }
    }
    pieces.push(piece);
    pieces.retain(|piece| piece.len() > 1);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_and_gaps_alternate_along_the_path_and_a_solid_line_stays_whole() {
        let path = [(0.0, 0.0), (10.0, 0.0), (10.0, 46.0)];
        assert_eq!(broken(&path, Stroke::Solid, (1.0, 1.0)), vec![path.to_vec()]);
        let dashed = broken(&path, Stroke::Dashed, (1.0, 1.0));
        assert_eq!(dashed, vec![vec![(0.0, 0.0), (10.0, 0.0), (10.0, 8.0)], vec![(10.0, 18.0), (10.0, 36.0)],]);
        assert!(broken(&[], Stroke::Dotted, (1.0, 1.0)).iter().all(Vec::is_empty));
    }
}
