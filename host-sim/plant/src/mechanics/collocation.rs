//! One step of Gauss collocation with four nodes: order eight, for second-order equations.
//!
//! The accelerations at the four Gauss-Legendre nodes are found by fixed-point iteration in which each node takes what the
//! ones before it have just found (Gauss-Seidel); positions and speeds follow from them by exact integration of their
//! interpolating polynomial. What acts on the rotor is a formula of time and is evaluated once a node, however many
//! iterations it takes. Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.7 (Kuntzmann and
//! Butcher).

/// Nodes of a step.
pub(crate) const NODES: usize = 4;

/// Iterations after which a step that is short enough has converged.
const MOST_ITERATIONS: u32 = 30;

/// Relative error of the accelerations at which the iteration stops. Speeds are then wrong by this times h.
const TOLERANCE: f64 = 1e-13;

/// Weights of the method.
#[derive(Debug, Clone)]
pub(crate) struct Collocation {
    /// Times of the nodes over the step.
    pub(crate) times: [f64; NODES],
    /// Speed at a node from accelerations.
    speed: [[f64; NODES]; NODES],
    /// Position at a node from accelerations.
    position: [[f64; NODES]; NODES],
    /// Speed at the end.
    last_speed: [f64; NODES],
    /// Position at the end.
    last_position: [f64; NODES],
}

impl Collocation {
    /// The weights, from the closed form of the nodes.
    pub(crate) fn new() -> Self {
        let inner = (3.0 / 7.0 - 2.0 / 7.0 * (6.0_f64 / 5.0).sqrt()).sqrt();
        let outer = (3.0 / 7.0 + 2.0 / 7.0 * (6.0_f64 / 5.0).sqrt()).sqrt();
        let times = [-outer, -inner, inner, outer].map(|x| 0.5 * (1.0 + x));
        let (large, small) = ((18.0 + 30.0_f64.sqrt()) / 72.0, (18.0 - 30.0_f64.sqrt()) / 72.0);
        let last_speed = [small, large, large, small];
        // Integral of the j-th Lagrange polynomial from 0 to the i-th node, by the same quadrature (exact to degree 7).
        let lagrange = |j: usize, u: f64| {
            (0..NODES).filter(|&m| m != j).map(|m| (u - times[m]) / (times[j] - times[m])).product::<f64>()
        };
        let integral = |i: usize, j: usize| {
            let at = |k: usize| last_speed[k] * lagrange(j, times[i] * times[k]);
            times[i] * (0..NODES).map(at).sum::<f64>()
        };
        let speed: [[f64; NODES]; NODES] = std::array::from_fn(|i| std::array::from_fn(|j| integral(i, j)));
        let twice = |i: usize, j: usize| (0..NODES).map(|k| speed[i][k] * speed[k][j]).sum();
        let position = std::array::from_fn(|i| std::array::from_fn(|j| twice(i, j)));
        let last_position = std::array::from_fn(|j| last_speed[j] * (1.0 - times[j]));
        Self { times, speed, position, last_speed, last_position }
    }

    /// Positions and speeds of `N` bodies a time `h` after `q`, `v`, and the iterations that took; `acceleration` takes a node
    /// and the positions and speeds there, `guess` are the first accelerations at the nodes.
    #[inline]
    pub(crate) fn step<const N: usize>(
        &self,
        (q, v): ([f64; N], [f64; N]),
        guess: [[f64; N]; NODES],
        h: f64,
        acceleration: impl Fn(usize, &[f64; N], &[f64; N]) -> [f64; N],
    ) -> ([f64; N], [f64; N], u32) {
        let mut found = guess;
        let mut change_before = 0.0;
        let mut iterations = 0;
        while iterations < MOST_ITERATIONS {
            iterations += 1;
            let mut change = 0.0_f64;
            let mut largest = 0.0_f64;
            let at: [([f64; N], [f64; N]); NODES] = std::array::from_fn(|node| {
                let at_node = std::array::from_fn(|body| {
                    q[body] + h * (self.times[node] * v[body] + h * dot(&self.position[node], &found, body))
                });
                (at_node, std::array::from_fn(|body| v[body] + h * dot(&self.speed[node], &found, body)))
            });
            for (node, (at_node, speed)) in at.iter().enumerate() {
                let next = acceleration(node, at_node, speed);
                for body in 0..N {
                    change = change.max((next[body] - found[node][body]).abs());
                    largest = largest.max(next[body].abs());
                }
                found[node] = next;
            }
            // The iteration contracts, so the next change would be this one times the ratio of the last two.
            let allowed = TOLERANCE * (1.0 + largest);
            if change <= allowed || change * change <= allowed * change_before {
                break;
            }
            change_before = change;
        }
        let speed = std::array::from_fn(|body| v[body] + h * dot(&self.last_speed, &found, body));
        let position = std::array::from_fn(|body| q[body] + h * (v[body] + h * dot(&self.last_position, &found, body)));
        (position, speed, iterations)
    }
}

#[inline]
fn dot<const N: usize>(weights: &[f64; NODES], values: &[[f64; N]; NODES], body: usize) -> f64 {
    weights[0] * values[0][body]
        + weights[1] * values[1][body]
        + weights[2] * values[2][body]
        + weights[3] * values[3][body]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pendulum_step_has_order_eight() {
        let method = Collocation::new();
        let run = |steps: u32| {
            let h = 2.0 / f64::from(steps);
            let step = |x: ([f64; 1], [f64; 1])| {
                let (q, v, _) = method.step(x, [[-x.0[0].sin()]; NODES], h, |_, q, _| [-q[0].sin()]);
                (q, v)
            };
            (0..steps).fold(([1.0], [0.0]), |x, _| step(x)).0[0]
        };
        let exact = run(256);
        let (coarse, fine) = ((run(4) - exact).abs(), (run(8) - exact).abs());
        println!("pendulum: {coarse:e} at 4 steps, {fine:e} at 8");
        assert!(coarse / fine > 150.0 && fine < 1e-10, "{coarse:e} {fine:e}");
    }

    #[test]
    fn weights_integrate_polynomials() {
        let method = Collocation::new();
        for node in 0..NODES {
            let total: f64 = method.speed[node].iter().sum();
            assert!((total - method.times[node]).abs() < 1e-15);
            let twice: f64 = method.position[node].iter().sum();
            assert!((twice - 0.5 * method.times[node].powi(2)).abs() < 1e-15);
        }
    }
}
