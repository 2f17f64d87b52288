//! A load behind a shaft or a gap, run along the recorded motion of the rotor.
//!
//! Motor inertia J/(1+r) and load J r/(1+r) on a spring k = w^2 m and damper 2 z w m, with m their reduced mass and w the
//! resonance; the spring has a dead zone of the gap, and contact is the plant's law.
//!
//! A load that bounces in its gap forgets where it started, and errors grow from impact to impact: no simulation follows it
//! for long. So an extended Kalman filter keeps it on track by the force that the rotor's own balance shows. What the
//! filter moves the load by has no physical cause; it is given as a torque, and charged like any other error.

use super::motion::Motion;
use crate::effects::Load;

/// What a load does, as means over the cells, N m (N).
#[derive(Debug, Clone)]
pub(crate) struct Pull {
    /// Torque that the load takes from the rotor.
    pub torque: Vec<f64>,
    /// Torque that would be needed on the load for what the filter corrected; empty without a gap.
    pub corrected: Vec<f64>,
}

/// A contact so stiff that a cell would take more Runge-Kutta steps than this has settled by the end of the cell: it is
/// crossed as if it lasted.
const MOST_STEPS: f64 = 512.0;

/// The shaft in numbers, SI.
#[derive(Debug, Clone, Copy)]
struct Shaft {
    moved: f64,
    stiffness: f64,
    damping: f64,
    half_gap: f64,
}

/// Position and speed of the load.
#[derive(Debug, Clone, Copy)]
struct State {
    x: f64,
    v: f64,
}

/// Rotor over one cell: position and speed at its start, acceleration.
#[derive(Debug, Clone, Copy)]
struct Rotor {
    q: f64,
    w: f64,
    rate: f64,
}

impl Rotor {
    fn at(&self, s: f64) -> (f64, f64) {
        (self.q + self.w * s + 0.5 * self.rate * s * s, self.w + self.rate * s)
    }
}

impl Shaft {
    fn new(load: &Load, inertia: f64) -> Self {
        let ratio = load.inertia_ratio;
        let moved = inertia * ratio / (1.0 + ratio);
        let reduced = moved / (1.0 + ratio);
        let omega = std::f64::consts::TAU * load.resonance_hz;
        Self {
            moved,
            stiffness: omega * omega * reduced,
            damping: 2.0 * load.damping_ratio * omega * reduced,
            half_gap: 0.5 * load.gap,
        }
    }

    /// Force on the load in contact on the side of `towards`, N m; negative of its sign where the shaft holds back.
    fn contact(&self, stretch: f64, rate: f64, towards: f64) -> f64 {
        self.stiffness * (stretch - self.half_gap.copysign(towards)) + self.damping * rate
    }

    /// Force on the load: spring and damper in contact, which may hold back as the shaft parts; across the gap nothing.
    fn force(&self, stretch: f64, rate: f64) -> f64 {
        if self.half_gap > 0.0 && stretch.abs() <= self.half_gap { 0.0 } else { self.contact(stretch, rate, stretch) }
    }

    /// Runge-Kutta steps that a cell takes: a third of a radian of the fastest motion each.
    fn steps(&self, span: f64) -> f64 {
        let fastest = (self.stiffness / self.moved).sqrt().max(0.5 * self.damping / self.moved);
        (span * fastest / 0.3).ceil().max(1.0)
    }

    /// Moves the load over a cell by that many steps, into and out of contact; gives its change of speed.
    fn advance(&self, rotor: &Rotor, (span, steps): (f64, f64), state: &mut State) -> f64 {
        let h = span / steps;
        let before = state.v;
        for step in 0..steps as usize {
            let pull = |offset: f64, x: f64, v: f64| {
                let (q, w) = rotor.at((step as f64 + offset) * h);
                self.force(q - x, w - v) / self.moved
            };
            let State { x, v } = *state;
            let a1 = pull(0.0, x, v);
            let a2 = pull(0.5, x + 0.5 * h * v, v + 0.5 * h * a1);
            let a3 = pull(0.5, x + 0.5 * h * v + 0.25 * h * h * a1, v + 0.5 * h * a2);
            let a4 = pull(1.0, x + h * v + 0.5 * h * h * a2, v + h * a3);
            state.x += h * v + h * h / 6.0 * (a1 + a2 + a3);
            state.v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        state.v - before
    }
}

/// Spans that differ by no more than rounding, relative, are crossed by the same matrix.
const ROUNDING: f64 = 1e-11;

/// Exact motion of a load without a gap against its rotor while that accelerates evenly.
struct Swing {
    shaft: Shaft,
    /// The span last crossed, s, and what twist and its rate become of themselves over it.
    span: f64,
    matrix: [[f64; 2]; 2],
}

impl Swing {
    fn new(shaft: Shaft) -> Self {
        Self { shaft, span: 0.0, matrix: [[1.0, 0.0], [0.0, 1.0]] }
    }

    fn cross(&mut self, span: f64) {
        if (span - self.span).abs() <= ROUNDING * span {
            return;
        }
        let (square, half) = (self.shaft.stiffness / self.shaft.moved, 0.5 * self.shaft.damping / self.shaft.moved);
        let apart = square - half * half;
        let root = apart.abs().sqrt();
        let decay = (-half * span).exp();
        let (cosine, sine) = match apart {
            _ if root * span < 1e-9 => (decay, decay * span),
            apart if apart > 0.0 => (decay * (root * span).cos(), decay * (root * span).sin() / root),
            // Each exponential by itself: together they overflow where their product with the decay does not.
            _ => {
                let (slow, fast) = ((-(half - root) * span).exp(), (-(half + root) * span).exp());
                (0.5 * (slow + fast), 0.5 * (slow - fast) / root)
            }
        };
        self.matrix = [[cosine + half * sine, sine], [-square * sine, cosine - half * sine]];
        self.span = span;
    }

    /// What twist and its rate become of themselves over a span.
    fn over(&mut self, span: f64) -> [[f64; 2]; 2] {
        self.cross(span);
        self.matrix
    }

    /// Moves the load over a cell; gives its change of speed.
    fn advance(&mut self, rotor: &Rotor, span: f64, state: &mut State) -> f64 {
        self.cross(span);
        // Where the twist would stay under this acceleration.
        let resting = -rotor.rate * self.shaft.moved / self.shaft.stiffness;
        let (twist, rate) = (state.x - rotor.q - resting, state.v - rotor.w);
        let [[a, b], [c, d]] = self.matrix;
        let (q, w) = rotor.at(span);
        let before = state.v;
        *state = State { x: q + resting + a * twist + b * rate, v: w + c * twist + d * rate };
        state.v - before
    }
}

/// Motion of a load behind its rotor: exact without a gap, and through cells in which it only flies or only touches.
pub(crate) struct Bounce {
    shaft: Shaft,
    swing: Swing,
}

impl Bounce {
    /// Of a load on a machine of that inertia, kg m2 (kg).
    pub(crate) fn new(load: &Load, inertia: f64) -> Self {
        let shaft = Shaft::new(load, inertia);
        Self { shaft, swing: Swing::new(shaft) }
    }

    /// Position and speed of the load after a cell of `span` seconds, from those before it; the rotor begins the cell with a
    /// position and a speed and accelerates evenly.
    pub(crate) fn along(&mut self, (x, v): (f64, f64), (q, w): (f64, f64), rate: f64, span: f64) -> (f64, f64) {
        let (rotor, mut state) = (Rotor { q, w, rate }, State { x, v });
        self.advance(&rotor, span, &mut state);
        (state.x, state.v)
    }

    /// Moves the load over a cell; gives its change of speed.
    fn advance(&mut self, rotor: &Rotor, span: f64, state: &mut State) -> f64 {
        let half_gap = self.shaft.half_gap;
        if half_gap == 0.0 {
            return self.swing.advance(rotor, span, state);
        }
        let stretch = rotor.q - state.x;
        let end = rotor.at(span).0;
        let steps = self.shaft.steps(span);
        let whole = if stretch.abs() > half_gap {
            // In contact the load hangs on a rotor that is half the gap nearer.
            let shift = half_gap.copysign(stretch);
            let mut next = State { x: state.x + shift, v: state.v };
            let change = self.swing.advance(rotor, span, &mut next);
            next.x -= shift;
            let settles = steps > MOST_STEPS;
            (settles || (end - next.x) * stretch.signum() > half_gap).then_some((next, change))
        } else {
            let next = State { x: state.x + state.v * span, v: state.v };
            ((end - next.x).abs() <= half_gap).then_some((next, 0.0))
        };
        match whole {
            Some((next, change)) => {
                *state = next;
                change
            }
            None if steps > MOST_STEPS => {
                // A contact this stiff has settled before the cell is over.
                let (q, w) = rotor.at(span);
                let before = state.v;
                let behind = half_gap.copysign(end - (state.x + state.v * span));
                *state = State { x: q - behind, v: w };
                state.v - before
            }
            None => self.shaft.advance(rotor, (span, steps), state),
        }
    }
}

/// Errors of the force shown over what neighbouring cells do not share: the smoother's are slow, and impacts are smeared.
const SLOW_ERRORS: f64 = 10.0;
/// A force shown that is this much larger than what neighbouring cells do not share is a contact.
const TOUCHES: f64 = 20.0;

/// Extended Kalman filter of a load in its gap.
struct Filter {
    /// Covariance of x and v.
    xx: f64,
    xv: f64,
    vv: f64,
    /// Standard deviation of the force that the rotor shows, N m.
    seen: f64,
    /// Standard deviation of a torque on the load over one cell, N m.
    unrest: f64,
}

impl Filter {
    /// Anywhere in the gap; an unseen torque on the load is as large as the errors of the force.
    fn new(shaft: &Shaft, spread: f64) -> Self {
        let seen = SLOW_ERRORS * spread.max(1e-12);
        Self { xx: 0.25 * shaft.half_gap * shaft.half_gap, xv: 0.0, vv: 1e-6, seen, unrest: seen }
    }

    /// Spread of the state over a cell of `span` seconds, which `crossed` takes the load through. Exact, so that the spread is
    /// bounded however stiff the contact is against the cell.
    fn predict(&mut self, shaft: &Shaft, crossed: [[f64; 2]; 2], span: f64) {
        let [[a, b], [c, e]] = crossed;
        let (xx, xv, vv) = (self.xx, self.xv, self.vv);
        self.xx = a * a * xx + 2.0 * a * b * xv + b * b * vv;
        self.xv = a * c * xx + (a * e + b * c) * xv + b * e * vv;
        let impulse = self.unrest * span / shaft.moved;
        self.vv = c * c * xx + 2.0 * c * e * xv + e * e * vv + impulse * impulse;
        let most = 0.25 * shaft.half_gap * shaft.half_gap;
        if self.xx > most {
            // The gap bounds what may be unknown.
            let shrink = most / self.xx;
            self.xx = most;
            self.xv *= shrink.sqrt();
        }
    }

    /// Corrects the state by the force seen at the end of a cell; gives the changes of position and speed.
    fn correct(&mut self, shaft: &Shaft, expected: f64, seen: f64) -> (f64, f64) {
        let (hx, hv) = (-shaft.stiffness, -shaft.damping);
        let (px, pv) = (self.xx * hx + self.xv * hv, self.xv * hx + self.vv * hv);
        let variance = px * hx + pv * hv + self.seen * self.seen;
        let (gx, gv) = (px / variance, pv / variance);
        // Rounding may leave a hair below zero.
        self.xx = (self.xx - gx * px).max(0.0);
        self.xv -= gx * pv;
        self.vv = (self.vv - gv * pv).max(0.0);
        let surprise = seen - expected;
        (gx * surprise, gv * surprise)
    }
}

/// Standard deviation of what neighbouring cells do not share, by a median.
fn spread(shown: &[f64]) -> f64 {
    let mut changes: Vec<f64> = shown.windows(3).map(|y| (y[1] - 0.5 * (y[0] + y[2])).abs()).collect();
    if changes.is_empty() {
        return 0.0;
    }
    let middle = changes.len() / 2;
    1.4826 * *changes.select_nth_unstable_by(middle, f64::total_cmp).1 / 1.5f64.sqrt()
}

/// What a load takes from the rotor; `shown` is the force on the load as the rotor's own balance shows it in each cell.
pub(crate) fn pull(motion: &Motion, load: &Load, inertia: f64, shown: &[f64]) -> Pull {
    let shaft = Shaft::new(load, inertia);
    if shaft.half_gap > 0.0 { behind_a_gap(motion, &shaft, shown) } else { on_a_shaft(motion, shaft) }
}

fn on_a_shaft(motion: &Motion, shaft: Shaft) -> Pull {
    let mut swing = Swing::new(shaft);
    let mut state = State { x: motion.smooth[0], v: motion.speed[0] };
    let each = (0..motion.cells()).map(|cell| {
        let span = motion.t_s[cell + 1] - motion.t_s[cell];
        let (q, w) = (motion.smooth[cell], motion.speed[cell]);
        let rotor = Rotor { q, w, rate: (motion.speed[cell + 1] - w) / span };
        let change = swing.advance(&rotor, span, &mut state);
        if motion.broken[cell] {
            state = State { x: motion.smooth[cell + 1], v: motion.speed[cell + 1] };
        }
        shaft.moved * change / span
    });
    Pull { torque: each.collect(), corrected: Vec::new() }
}

// Over 40 lines: one cell of the filter, whose steps share its state.
fn behind_a_gap(motion: &Motion, shaft: &Shaft, shown: &[f64]) -> Pull {
    let cells = motion.cells();
    let mut state = State { x: motion.smooth[0], v: motion.speed[0] };
    let mut torque = Vec::with_capacity(cells);
    let mut corrected = vec![0.0; cells + 1];
    let spread = spread(shown);
    let mut filter = Filter::new(shaft, spread);
    let mut bounce = Bounce { shaft: *shaft, swing: Swing::new(*shaft) };
    for cell in 0..cells {
        let span = motion.t_s[cell + 1] - motion.t_s[cell];
        let (q, w) = (motion.smooth[cell], motion.speed[cell]);
        let rotor = Rotor { q, w, rate: (motion.speed[cell + 1] - w) / span };
        let change = bounce.advance(&rotor, span, &mut state);
        torque.push(shaft.moved * change / span);
        if motion.broken[cell] {
            state = State { x: motion.smooth[cell + 1], v: motion.speed[cell + 1] };
            continue;
        }
        if motion.at_rest[cell] {
            continue;
        }
        let stretch = rotor.at(span).0 - state.x;
        let touching = stretch.abs() > shaft.half_gap;
        let crossed = if touching { bounce.swing.over(span) } else { [[1.0, span], [0.0, 1.0]] };
        filter.predict(shaft, crossed, span);
        let seen = shown[cell];
        if touching || seen.abs() > TOUCHES * spread {
            let side = if touching { stretch } else { seen };
            // The force shown is the mean over the cell.
            let (middle, speed) = rotor.at(0.5 * span);
            let expected = shaft.contact(middle - (state.x - 0.5 * span * state.v), speed - state.v, side);
            let (moved, faster) = filter.correct(shaft, expected, seen);
            state.x += moved;
            state.v += faster;
            let (jump, kick) = (shaft.moved * moved / (span * span), shaft.moved * faster / span);
            corrected[cell] += jump + kick;
            corrected[cell + 1] -= jump;
        }
    }
    corrected.truncate(cells);
    Pull { torque, corrected }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_flies_touches_and_crosses_as_in_fine_steps() {
        let shaft = Shaft::new(&Load { resonance_hz: 90.0, damping_ratio: 0.1, inertia_ratio: 0.3, gap: 2e-3 }, 0.1);
        let mut bounce = Bounce { shaft, swing: Swing::new(shaft) };
        let rotor = Rotor { q: 0.1, w: 0.5, rate: 40.0 };
        // Flying and touching is exact; a cell with an edge in it is as good as its steps.
        let (exact, edge) = (1e-10, 1e-5);
        for (stretch, rate, allowed) in
            [(0.0, 0.3, exact), (4e-3, 0.1, exact), (-3e-3, -0.2, exact), (0.9e-3, 2.0, edge), (1.05e-3, -3.0, edge)]
        {
            let start = State { x: rotor.q - stretch, v: rotor.w - rate };
            let (mut coarse, mut fine) = (start, start);
            let change = bounce.advance(&rotor, 5e-4, &mut coarse);
            for step in 0..256 {
                let (q, w) = rotor.at(f64::from(step) * 5e-4 / 256.0);
                let _ = shaft.advance(&Rotor { q, w, ..rotor }, (5e-4 / 256.0, 1.0), &mut fine);
            }
            assert!((coarse.x - fine.x).abs() < allowed, "{stretch} {rate}: {coarse:?} {fine:?}");
            assert!((change - (coarse.v - start.v)).abs() < 1e-12);
        }
    }

    /// Cells of 8 ms under a contact of 500 Hz: the spread of the filter overflowed.
    #[test]
    fn a_contact_that_is_stiff_against_the_cell_stays_finite() {
        for (resonance_hz, damping_ratio) in [(500.0, 1e-3), (500.0, 1.0), (500.0, 50.0), (1e5, 0.05)] {
            let load = Load { resonance_hz, damping_ratio, inertia_ratio: 0.5, gap: 1e-4 };
            let shaft = Shaft::new(&load, 0.1);
            let mut bounce = Bounce::new(&load, 0.1);
            let mut filter = Filter::new(&shaft, 0.01);
            let (mut at, span) = ((0.0, 0.0), 8e-3);
            for cell in 0..2000 {
                let (t, turn) = (f64::from(cell) * span, 5.0);
                let (q, w, rate) = ((turn * t).sin(), turn * (turn * t).cos(), -turn * turn * (turn * t).sin());
                at = bounce.along(at, (q, w), rate, span);
                let crossed = bounce.swing.over(span);
                filter.predict(&shaft, crossed, span);
                let (moved, faster) = filter.correct(&shaft, 0.0, 0.3);
                assert!(moved.is_finite() && faster.is_finite(), "{resonance_hz} Hz: cell {cell}");
                assert!((at.0 - q).abs() < 0.5 && at.1.abs() < 50.0, "{resonance_hz} Hz: cell {cell}, {at:?}");
            }
        }
    }
}
