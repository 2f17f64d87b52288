//! The stable region in the plane of the normalised gains, as closed outlines.
//!
//! The boundary curve, the axis K_p* = 0 and the edge of a window cut the plane into faces, in each of which the number
//! of unstable roots is constant. The pieces between cuts that have a stable face on exactly one side are the outline
//! of the region; joined end to end with the region on the left they are closed.

use super::case::{Gains, Loop, LoopError, NormalisedGains, Plant};
use super::{curves, zeros::Scan};

/// A point (K_p*, K_d*).
pub type Point = [f64; 2];

/// Part of the first quadrant that is looked at: 0..`kp` by 0..`kd`. The first quadrant is the paper's convention.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Window {
    /// Largest K_p*.
    pub kp: f64,
    /// Largest K_d*.
    pub kd: f64,
}

impl Window {
    /// The window of section 6 of the specification.
    pub const SPECIFIED: Self = Self { kp: 1.6, kd: 2.2 };
}

/// The stable region within a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Closed outlines, the region on the left; an outline around a hole runs the other way.
    pub outlines: Vec<Vec<Point>>,
    /// Where it was looked for.
    pub window: Window,
}

impl Region {
    /// Area, in units of K_p* K_d*.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.outlines.iter().flat_map(|outline| edges(outline)).fold(0.0, |area, (a, b)| area + 0.5 * cross(a, b))
    }

    /// Whether a point is inside: how often the outlines wind around it.
    #[must_use]
    pub fn contains(&self, gains: NormalisedGains) -> bool {
        let from = |p: Point| [p[0] - gains.kp, p[1] - gains.kd];
        let mut winding = 0;
        for (a, b) in self.outlines.iter().flat_map(|outline| edges(outline)) {
            let (a, b) = (from(a), from(b));
            if (a[1] <= 0.0) != (b[1] <= 0.0) && (cross(a, b) > 0.0) == (b[1] > 0.0) {
                winding += if b[1] > 0.0 { 1 } else { -1 };
            }
        }
        winding != 0
    }

    /// Whether the region goes on beyond the window.
    #[must_use]
    pub fn leaves_window(&self) -> bool {
        let Window { kp, kd } = self.window;
        self.outlines.iter().flatten().any(|p| p[0] > kp * (1.0 - 1e-9) || p[1] > kd * (1.0 - 1e-9))
    }
}

/// A piece of boundary between two cuts.
#[derive(Debug, Clone)]
struct Piece {
    points: Vec<Point>,
    /// On the edge of the window, which runs around it with the inside on the left.
    edge: bool,
}

/// Phase of the fastest term from one point of the drawn curve to the next, rad.
const PHASE_STEP_RAD: f64 = 0.004;
/// Points of the longest curve that is cut into a region; three hundred turns or so.
const MAX_POINTS: f64 = 5e5;
/// Most crossings of the curve with itself that are looked into.
const MAX_CROSSINGS: usize = 1000;
/// Distance at which the faces beside a piece are asked for their roots, as a share of the window; a chord of the curve
/// is within a tenth of it.
const ASIDE: f64 = 5e-5;

/// The stable region of a plant within a window.
///
/// # Errors
/// As [`Loop::new`] for the gains of the window.
pub fn stable_region(plant: &Plant, window: Window) -> Result<Region, LoopError> {
    let mut kept = Vec::new();
    for piece in pieces(plant, window)? {
        let (left, right) = beside(plant, window, &piece)?;
        if left && (piece.edge || !right) {
            kept.push(piece.points);
        } else if right && !left && !piece.edge {
            kept.push(piece.points.into_iter().rev().collect());
        }
    }
    Ok(Region { outlines: join(kept), window })
}

/// The part of the boundary curve that crosses the window, for a plot: one line for each time it comes in.
///
/// # Errors
/// As [`Loop::new`] for the gains of the window.
pub fn boundary_lines(plant: &Plant, window: Window) -> Result<Vec<Vec<Point>>, LoopError> {
    Ok(clip(&curve(plant, window)?, window))
}

/// The whole curve up to the frequency beyond which it stays outside the window.
fn curve(plant: &Plant, window: Window) -> Result<Vec<Point>, LoopError> {
    let corner = normalised(window.kp, window.kd).physical(plant.inertia_kg_m2, plant.torque_delay_s);
    let to_rad_s = Loop::new(*plant, corner)?.frequency_bound_rad_s();
    let step_rad_s = PHASE_STEP_RAD / (plant.torque_delay_s + plant.fluid.delay_s());
    if to_rad_s / step_rad_s > MAX_POINTS {
        let turns = to_rad_s / step_rad_s * PHASE_STEP_RAD / std::f64::consts::TAU;
        return Err(LoopError::TooStiff(format!("the boundary curve turns {turns:.0} times within the window")));
    }
    let scan = Scan { from_rad_s: 1e-3 * step_rad_s, to_rad_s, step_rad_s };
    Ok(scan.frequencies().map(|w| point(plant, curves::boundary(plant, w))).collect())
}

/// Pieces of the curve and of the window's edge between all cuts.
fn pieces(plant: &Plant, window: Window) -> Result<Vec<Piece>, LoopError> {
    let Window { kp, kd } = window;
    let mut lines: Vec<Piece> =
        clip(&curve(plant, window)?, window).into_iter().map(|points| Piece { points, edge: false }).collect();
    let corners = [[0.0, 0.0], [kp, 0.0], [kp, kd], [0.0, kd]];
    // The ends of the clipped curve are cuts of the edge.
    let ends: Vec<Point> = lines.iter().flat_map(|line| [line.points[0], line.points[line.points.len() - 1]]).collect();
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let along = |p: &Point| (p[0] - a[0]).hypot(p[1] - a[1]);
        let mut cuts: Vec<Point> = ends.iter().copied().filter(|p| on_edge(*p, a, b)).collect();
        cuts.sort_by(|p, q| along(p).total_cmp(&along(q)));
        let mut from = a;
        for to in cuts.into_iter().chain([b]) {
            lines.push(Piece { points: vec![from, to], edge: true });
            from = to;
        }
    }
    let (edge, curve): (Vec<_>, Vec<_>) = lines.into_iter().partition(|line| line.edge);
    let mut pieces = cut_at_crossings(curve.into_iter().map(|line| line.points).collect())?;
    pieces.extend(edge);
    pieces.retain(|piece| piece.points.len() > 1 && piece.points.first() != piece.points.last());
    Ok(pieces)
}

/// Whether a point that clipping has put on the edge is on this side of it.
fn on_edge(p: Point, a: Point, b: Point) -> bool {
    if a[0] == b[0] { p[0] == a[0] } else { p[1] == a[1] }
}

/// Cuts lines wherever two of their segments cross, themselves included.
fn cut_at_crossings(lines: Vec<Vec<Point>>) -> Result<Vec<Piece>, LoopError> {
    let mut segments: Vec<(usize, usize)> =
        lines.iter().enumerate().flat_map(|(line, points)| (1..points.len()).map(move |k| (line, k))).collect();
    let ends = |(line, k): (usize, usize)| (lines[line][k - 1], lines[line][k]);
    let left = |at: (usize, usize)| ends(at).0[0].min(ends(at).1[0]);
    let right = |at: (usize, usize)| ends(at).0[0].max(ends(at).1[0]);
    // By their left ends, so that only segments side by side are compared.
    segments.sort_by(|&p, &q| left(p).total_cmp(&left(q)));
    let mut cuts: Vec<Vec<(usize, f64, Point)>> = vec![Vec::new(); lines.len()];
    let mut crossings = 0;
    for (n, &one) in segments.iter().enumerate() {
        if crossings > MAX_CROSSINGS {
            let message = format!("the boundary curve crosses itself more than {MAX_CROSSINGS} times in the window");
            return Err(LoopError::TooStiff(message));
        }
        for &other in segments[n + 1..].iter().take_while(|&&other| left(other) <= right(one)) {
            if one.0 == other.0 && one.1.abs_diff(other.1) == 1 {
                continue;
            }
            if let Some((s, t, at)) = crossing(ends(one), ends(other)) {
                cuts[one.0].push((one.1, s, at));
                cuts[other.0].push((other.1, t, at));
                crossings += 1;
            }
        }
    }
    let mut pieces = Vec::new();
    for (points, mut cuts) in lines.into_iter().zip(cuts) {
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut from = 0;
        let mut piece: Vec<Point> = Vec::new();
        for (segment, _, at) in cuts {
            piece.extend_from_slice(&points[from..segment.max(from)]);
            piece.push(at);
            pieces.push(Piece { points: std::mem::replace(&mut piece, vec![at]), edge: false });
            from = segment.max(from);
        }
        piece.extend_from_slice(&points[from..]);
        pieces.push(Piece { points: piece, edge: false });
    }
    Ok(pieces)
}

/// Where two segments cross: the share of each, and the point.
fn crossing((a, b): (Point, Point), (c, d): (Point, Point)) -> Option<(f64, f64, Point)> {
    for axis in 0..2 {
        if a[axis].max(b[axis]) < c[axis].min(d[axis]) || c[axis].max(d[axis]) < a[axis].min(b[axis]) {
            return None;
        }
    }
    let (ab, cd, ac) = (minus(b, a), minus(d, c), minus(c, a));
    let area = cross(ab, cd);
    let (s, t) = (cross(ac, cd) / area, cross(ac, ab) / area);
    ((0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)).then(|| (s, t, [a[0] + s * ab[0], a[1] + s * ab[1]]))
}

/// Whether the faces left and right of a piece are stable, seen from half way along it, clear of the cuts at its ends.
fn beside(plant: &Plant, window: Window, piece: &Piece) -> Result<(bool, bool), LoopError> {
    let segments = || piece.points.windows(2).map(|p| (p[0], p[1]));
    let half = 0.5 * segments().map(|(a, b)| length(a, b)).sum::<f64>();
    let mut walked = 0.0;
    let reaches_half = |&(a, b): &(Point, Point)| {
        walked += length(a, b);
        walked >= half && a != b
    };
    let Some((a, b)) = segments().find(reaches_half) else { return Ok((false, false)) };
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    // Measured in windows, or a wide one would see nothing of its other direction.
    let along = [(b[0] - a[0]) / window.kp, (b[1] - a[1]) / window.kd];
    let scale = ASIDE / along[0].hypot(along[1]);
    let stable = |sign: f64| {
        let kp = middle[0] - sign * scale * along[1] * window.kp;
        let kd = middle[1] + sign * scale * along[0] * window.kd;
        let gains = normalised(kp, kd).physical(plant.inertia_kg_m2, plant.torque_delay_s);
        Loop::new(*plant, gains).map(|closed| curves::is_inside(&closed))
    };
    Ok((stable(1.0)?, stable(-1.0)?))
}

/// Joins directed pieces end to end into closed outlines.
fn join(mut pieces: Vec<Vec<Point>>) -> Vec<Vec<Point>> {
    let mut outlines = Vec::new();
    while let Some(mut outline) = pieces.pop() {
        // The nearest start continues; a piece's two ends are the very same numbers as its neighbours'.
        while let Some(&end) = outline.last() {
            let next =
                (0..pieces.len()).min_by(|&p, &q| length(pieces[p][0], end).total_cmp(&length(pieces[q][0], end)));
            match next {
                Some(next) if length(pieces[next][0], end) < length(outline[0], end) => {
                    outline.extend_from_slice(&pieces.swap_remove(next)[1..]);
                }
                _ => break,
            }
        }
        outlines.push(outline);
    }
    outlines
}

/// The parts of a line inside a window, cut exactly at its edge.
fn clip(points: &[Point], window: Window) -> Vec<Vec<Point>> {
    let mut lines: Vec<Vec<Point>> = Vec::new();
    let mut open = false;
    for pair in points.windows(2) {
        let Some((a, b)) = clip_segment(pair[0], pair[1], window) else {
            open = false;
            continue;
        };
        match lines.last_mut() {
            Some(line) if open => line.push(b),
            _ => lines.push(vec![a, b]),
        }
        open = b == pair[1];
    }
    lines
}

/// The part of a segment inside a window (Liang and Barsky).
fn clip_segment(a: Point, b: Point, window: Window) -> Option<(Point, Point)> {
    let size = [window.kp, window.kd];
    let (mut enter, mut leave) = ((0.0, None), (1.0, None));
    for axis in 0..2 {
        let step = b[axis] - a[axis];
        for (edge, inward) in [(0.0, step), (size[axis], -step)] {
            let share = (edge - a[axis]) / step;
            if inward > 0.0 && share > enter.0 {
                enter = (share, Some((axis, edge)));
            } else if inward < 0.0 && share < leave.0 {
                leave = (share, Some((axis, edge)));
            } else if inward == 0.0 && !(0.0..=size[axis]).contains(&a[axis]) {
                return None;
            }
        }
    }
    let at = |(share, on): (f64, Option<(usize, f64)>), whole: Point| {
        let Some((axis, edge)) = on else { return whole };
        let mut p = [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])];
        // To the bit, so that the edge's own pieces end at the very same point.
        p[axis] = edge;
        p
    };
    (enter.0 < leave.0).then(|| (at(enter, a), at(leave, b)))
}

fn point(plant: &Plant, gains: Gains) -> Point {
    let NormalisedGains { kp, kd } = gains.normalised(plant.inertia_kg_m2, plant.torque_delay_s);
    [kp, kd]
}

fn normalised(kp: f64, kd: f64) -> NormalisedGains {
    NormalisedGains { kp, kd }
}

fn edges(outline: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    outline.iter().copied().zip(outline.iter().copied().cycle().skip(1))
}

fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length(a: Point, b: Point) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
    use super::*;
    use crate::stability::argument;
    use crate::stability::case::Fluid;
    use crate::stability::testing::plant;

    const FLUIDS: [Fluid; 3] = [Fluid::None, Fluid::DeadTime { l_q_s: 0.005 }, Fluid::Lag { t_q_s: 0.005 }];

    #[test]
    fn areas_are_those_of_the_specification() {
        for (fluid, stated) in FLUIDS.into_iter().zip([2.11, 0.40, 0.80]) {
            let region = stable_region(&Plant { fluid, ..plant(0.005, 0.2, 10.0) }, Window::SPECIFIED).unwrap();
            println!("{fluid:?}: area {:.4}, {} outlines", region.area(), region.outlines.len());
            assert!((region.area() / stated - 1.0).abs() < 0.02, "{fluid:?}: {}", region.area());
            assert!(!region.leaves_window() && region.contains(NormalisedGains::PAPER));
        }
    }

    #[test]
    fn a_slow_lag_beside_a_short_delay_keeps_its_region() {
        let plant = Plant { fluid: Fluid::Lag { t_q_s: 0.05 }, ..plant(1e-4, 0.2, 10.0) };
        let area = stable_region(&plant, Window::SPECIFIED).unwrap().area();
        assert!((area - 0.578).abs() < 1e-3, "{area}");
    }

    #[test]
    fn the_outlines_hold_what_root_counting_says() {
        let window = Window { kp: 2.0, kd: 2.5 };
        let strong = [(0.001, 0.0, 25.0), (0.005, 0.2, 30.0), (0.002, 0.2, 10.0), (0.008, 0.5, 16.0)];
        for (l, q0, q1) in strong {
            for fluid in FLUIDS {
                let plant = Plant { fluid, ..plant(l, q0, q1) };
                let region = stable_region(&plant, window).unwrap();
                let mut inside = 0_u32;
                for (i, k) in (0..80).flat_map(|i| (0..80).map(move |k| (i, k))) {
                    let gains = normalised(0.025 * (f64::from(i) + 0.37), 0.03125 * (f64::from(k) + 0.41));
                    let closed = Loop::new(plant, gains.physical(plant.inertia_kg_m2, l)).unwrap();
                    let counted = argument::unstable_roots(&closed) == Some(0);
                    assert_eq!(region.contains(gains), counted, "{plant:?} {gains:?}");
                    inside += u32::from(counted);
                }
                let counted_area = f64::from(inside) * 0.025 * 0.03125;
                assert!((region.area() - counted_area).abs() < 0.01 + 0.02 * counted_area);
            }
        }
    }
}
