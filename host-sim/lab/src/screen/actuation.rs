//! What held commands become behind dead times, lags and limits, as exact means over the cells between samples.
//!
//! A command holds from its row's time to the next. Before the first row the first command is taken to have held.

/// Mean over each cell `[t_i, t_{i+1}]` of a held command that acts `delay_s` later (earlier where negative).
pub(crate) fn held_means(t_s: &[f64], value: &[f64], delay_s: f64) -> Vec<f64> {
    let mut integral = Vec::with_capacity(t_s.len());
    let mut sum = 0.0;
    for index in 0..t_s.len() {
        integral.push(sum);
        if index + 1 < t_s.len() {
            sum += value[index] * (t_s[index + 1] - t_s[index]);
        }
    }
    let mut row = 0;
    let mut at = |time: f64| {
        while row + 1 < t_s.len() && t_s[row + 1] <= time {
            row += 1;
        }
        integral[row] + value[row] * (time - t_s[row])
    };
    let mut means = Vec::with_capacity(t_s.len().saturating_sub(1));
    let mut before = t_s.first().map_or(0.0, |&first| at(first - delay_s));
    for pair in t_s.windows(2) {
        let after = at(pair[1] - delay_s);
        means.push((after - before) / (pair[1] - pair[0]));
        before = after;
    }
    means
}

/// A first-order lag whose time constant may differ upwards and downwards, behind a dead time and a slew limit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chain {
    /// s; may be negative.
    pub delay_s: f64,
    /// Largest rate of change, 1/s times the unit of the value; infinite for none.
    pub slew_per_s: f64,
    /// s.
    pub rise_s: f64,
    /// s.
    pub fall_s: f64,
}

/// Means of a signal and of its square over one cell.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Moments {
    /// Mean.
    pub first: f64,
    /// Mean of the square.
    pub second: f64,
}

/// Spans that differ by no more than rounding, of the time constant, have the same decay.
const ROUNDING: f64 = 1e-11;

/// State of a [`Chain`].
struct Follower {
    chain: Chain,
    slewed: f64,
    lagged: f64,
    /// The last decays, by span and time constant: a delay cuts each of equal cells in the same two.
    decays: [(f64, f64, f64); 2],
}

impl Follower {
    fn new(chain: Chain, value: f64) -> Self {
        Self { chain, slewed: value, lagged: value, decays: [(0.0, 0.0, 1.0); 2] }
    }

    /// exp(-span/tau).
    fn decay(&mut self, span_s: f64, tau_s: f64) -> f64 {
        let same = |known: &&(f64, f64, f64)| known.1 == tau_s && (known.0 - span_s).abs() <= ROUNDING * tau_s;
        if let Some(known) = self.decays.iter().find(same) {
            return known.2;
        }
        let decay = (-span_s / tau_s).exp();
        self.decays = [(span_s, tau_s, decay), self.decays[0]];
        decay
    }

    /// Integrals of the output and its square over `span_s` under a constant target; advances the state.
    fn advance(&mut self, target: f64, span_s: f64) -> (f64, f64) {
        if self.chain.slew_per_s.is_infinite() || self.slewed == target {
            self.slewed = target;
            return self.lag(target, span_s);
        }
        // While the limiter ramps, the lag follows the mean of short steps of the ramp.
        let reach_s = (target - self.slewed).abs() / self.chain.slew_per_s;
        let ramp_s = reach_s.min(span_s);
        let steps = 4;
        let step_s = ramp_s / f64::from(steps);
        let rate = self.chain.slew_per_s.copysign(target - self.slewed);
        let (mut first, mut second) = (0.0, 0.0);
        for _ in 0..steps {
            let (a, b) = self.lag(self.slewed + 0.5 * rate * step_s, step_s);
            self.slewed += rate * step_s;
            (first, second) = (first + a, second + b);
        }
        if reach_s < span_s {
            self.slewed = target;
            let (a, b) = self.lag(target, span_s - reach_s);
            (first, second) = (first + a, second + b);
        }
        (first, second)
    }

    fn lag(&mut self, target: f64, span_s: f64) -> (f64, f64) {
        let tau_s = if target > self.lagged { self.chain.rise_s } else { self.chain.fall_s };
        let away = self.lagged - target;
        if tau_s <= 1e-9 || away == 0.0 {
            self.lagged = target;
            return (target * span_s, target * target * span_s);
        }
        let decay = self.decay(span_s, tau_s);
        let (once, twice) = (tau_s * (1.0 - decay), 0.5 * tau_s * (1.0 - decay * decay));
        self.lagged = target + away * decay;
        let first = target * span_s + away * once;
        (first, target * target * span_s + 2.0 * target * away * once + away * away * twice)
    }
}

/// Means over each cell of a held command and of its square behind a [`Chain`].
pub(crate) fn chain_means(t_s: &[f64], value: &[f64], chain: Chain) -> Vec<Moments> {
    let Some(&first_s) = t_s.first() else { return Vec::new() };
    let mut row = 0;
    while row + 1 < t_s.len() && t_s[row + 1] + chain.delay_s <= first_s {
        row += 1;
    }
    let mut follower = Follower::new(chain, value[row]);
    let mut means = Vec::with_capacity(t_s.len() - 1);
    for pair in t_s.windows(2) {
        let (mut from_s, mut first, mut second) = (pair[0], 0.0, 0.0);
        while from_s < pair[1] {
            let change_s = if row + 1 < t_s.len() { t_s[row + 1] + chain.delay_s } else { f64::INFINITY };
            let to_s = change_s.min(pair[1]);
            if to_s > from_s {
                let (a, b) = follower.advance(value[row], to_s - from_s);
                (first, second) = (first + a, second + b);
                from_s = to_s;
            }
            if change_s <= pair[1] {
                row += 1;
            }
            if to_s >= pair[1] {
                break;
            }
        }
        let span_s = pair[1] - pair[0];
        means.push(Moments { first: first / span_s, second: second / span_s });
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(count: usize) -> Vec<f64> {
        (0..count).map(|row| row as f64 * 1e-3).collect()
    }

    #[test]
    fn a_fraction_of_a_sample_is_exact() {
        let means = held_means(&times(5), &[0.0, 1.0, 1.0, 1.0, 1.0], 0.3e-3);
        for (mean, expected) in means.iter().zip([0.0, 0.7, 1.0, 1.0]) {
            assert!((mean - expected).abs() < 1e-12, "{means:?}");
        }
        let early = held_means(&times(5), &[0.0, 0.0, 1.0, 1.0, 1.0], -0.3e-3);
        assert!((early[1] - 0.3).abs() < 1e-12, "{early:?}");
    }

    #[test]
    fn a_chain_without_lag_is_the_held_command_and_its_square() {
        let value = [0.0, 2.0, -1.0, 3.0, 3.0, 1.0];
        let chain = Chain { delay_s: 1.4e-3, slew_per_s: f64::INFINITY, rise_s: 0.0, fall_s: 0.0 };
        let held = held_means(&times(6), &value, 1.4e-3);
        let squares = held_means(&times(6), &value.map(|v| v * v), 1.4e-3);
        for (index, moments) in chain_means(&times(6), &value, chain).iter().enumerate() {
            assert!((moments.first - held[index]).abs() < 1e-12);
            assert!((moments.second - squares[index]).abs() < 1e-12);
        }
    }

    #[test]
    fn a_lag_reaches_63_percent_and_a_slew_limit_ramps() {
        let value: Vec<f64> = (0..200).map(|row| if row == 0 { 0.0 } else { 1.0 }).collect();
        let lag = Chain { delay_s: 0.0, slew_per_s: f64::INFINITY, rise_s: 0.010, fall_s: 0.0 };
        let means = chain_means(&times(200), &value, lag);
        let exact = |from: f64| 1.0 - 10.0 * ((-from / 10.0).exp() - (-(from + 1.0) / 10.0).exp());
        assert!((means[11].first - exact(10.0)).abs() < 1e-12);
        let slew = Chain { delay_s: 0.0, slew_per_s: 100.0, rise_s: 0.0, fall_s: 0.0 };
        let means = chain_means(&times(200), &value, slew);
        assert!((means[4].first - 0.35).abs() < 1e-9, "{}", means[4].first);
        assert!((means[40].first - 1.0).abs() < 1e-12);
    }
}
