//! Dead times and lags of signals that are constant over each step.

/// Dead time as a ring of steps; between two steps the value is interpolated, which for a held signal is the exact mean
/// over the step.
#[derive(Debug, Clone)]
pub(crate) struct DeadTime {
    ring: Vec<f64>,
    at: usize,
    whole: usize,
    fraction: f64,
}

impl DeadTime {
    /// A dead time, s, at a step, s; before the start the signal was `initial`.
    pub(crate) fn new(dead_time_s: f64, step_s: f64, initial: f64) -> Self {
        let steps = dead_time_s / step_s;
        let whole = (steps + 1e-9).floor();
        let fraction = (steps - whole).max(0.0);
        Self { ring: vec![initial; whole as usize + 2], at: 0, whole: whole as usize, fraction }
    }

    /// Takes the value of this step, gives the delayed one.
    pub(crate) fn pass(&mut self, value: f64) -> f64 {
        let length = self.ring.len();
        self.ring[self.at] = value;
        let late = self.ring[(self.at + length - self.whole) % length];
        // whole + 1 steps back is the slot that is overwritten next.
        let later = self.ring[(self.at + 1) % length];
        self.at = (self.at + 1) % length;
        late + self.fraction * (later - late)
    }
}

/// First-order lag by its exact recursion for a held input.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lag {
    value: f64,
    /// Share of the way to the input done in half a step and in a step, rising and falling.
    rise: [f64; 2],
    fall: [f64; 2],
}

impl Lag {
    /// Time constants, s; 0 follows at once.
    pub(crate) fn new(rise_s: f64, fall_s: f64, step_s: f64, initial: f64) -> Self {
        let share = |lag_s: f64, time_s: f64| if lag_s > 0.0 { -(-time_s / lag_s).exp_m1() } else { 1.0 };
        let both = |lag_s: f64| [share(lag_s, 0.5 * step_s), share(lag_s, step_s)];
        Self { value: initial, rise: both(rise_s), fall: both(fall_s) }
    }

    /// Value in the middle of the step with this input; moves on by one step.
    pub(crate) fn pass(&mut self, input: f64) -> f64 {
        let [half, full] = if input > self.value { self.rise } else { self.fall };
        let middle = self.value + half * (input - self.value);
        self.value += full * (input - self.value);
        middle
    }
}

/// Play of a half-width: the output stays until the input drags it along. A memory without rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Play {
    output: f64,
    half_width: f64,
}

impl Play {
    pub(crate) fn new(half_width: f64, initial: f64) -> Self {
        Self { output: initial, half_width }
    }

    pub(crate) fn pass(&mut self, input: f64) -> f64 {
        self.output = self.output.max(input - self.half_width).min(input + self.half_width);
        self.output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_comes_out_after_the_dead_time_to_a_fraction_of_a_step() {
        let mut dead = DeadTime::new(2.25, 1.0, 0.0);
        let out: Vec<f64> = (0..5).map(|_| dead.pass(1.0)).collect();
        assert_eq!(out, [0.0, 0.0, 0.75, 1.0, 1.0]);
        assert_eq!(DeadTime::new(0.0, 1.0, 0.0).pass(3.0), 3.0);
    }

    #[test]
    fn a_lag_is_the_exponential_whatever_the_step() {
        for step_s in [0.1, 0.01] {
            let mut lag = Lag::new(0.5, 0.5, step_s, 0.0);
            let steps = (1.0 / step_s).round() as usize;
            for _ in 0..steps {
                lag.pass(1.0);
            }
            assert!((lag.value - (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
        }
    }
}
