//! The noise that the likelihood whitens with.

/// Sensor and torque noise of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of a position sample beside its rounding, rad (m).
    pub sensor_sd: f64,
    /// Spectral density of the torque noise without a memory, (N m)^2 s.
    pub torque_density: f64,
    /// Torque noise with a memory; none where it has none.
    pub colour: Option<Colour>,
}

/// Torque noise that decays at random: an Ornstein-Uhlenbeck process.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Colour {
    /// Standard deviation, N m (N).
    pub sd: f64,
    /// Time constant, s.
    pub memory_s: f64,
}

impl Colour {
    /// Share that is left behind some time.
    #[inline]
    pub(crate) fn kept(&self, dt_s: f64) -> f64 {
        (-dt_s / self.memory_s).exp()
    }

    /// Variance that is new behind some time, (N m)^2.
    #[inline]
    pub(crate) fn stirred(&self, dt_s: f64) -> f64 {
        -(-2.0 * dt_s / self.memory_s).exp_m1() * self.sd * self.sd
    }
}

impl Noise {
    /// Without memory, beside a sensor's noise of that standard deviation, rad (m): a spectral density, (N m)^2 s.
    pub fn white(sensor_sd: f64, torque_density: f64) -> Self {
        Self { sensor_sd, torque_density, colour: None }
    }

    /// Halfway to another on the scale of the logarithm; the same for one of the same.
    pub(crate) fn halfway_to(&self, other: &Self) -> Self {
        let mean = |own: f64, other: f64| if own == other { own } else { (own * other).sqrt() };
        let colours = self.colour.zip(other.colour);
        let colour = colours
            .map(|(own, other)| Colour { sd: mean(own.sd, other.sd), memory_s: mean(own.memory_s, other.memory_s) });
        Self {
            sensor_sd: mean(self.sensor_sd, other.sensor_sd),
            torque_density: mean(self.torque_density, other.torque_density),
            colour,
        }
    }

    /// With a share of the variance of its torque noise, whether that has a memory or not.
    #[must_use]
    pub(crate) fn with_torque_share(&self, share: f64) -> Self {
        let colour = self.colour.map(|colour| Colour { sd: share.sqrt() * colour.sd, ..colour });
        Self { torque_density: share * self.torque_density, colour, ..*self }
    }

    /// Spectral density of all torque noise at low frequencies, (N m)^2 s.
    pub(crate) fn slow_density(&self) -> f64 {
        self.torque_density + self.colour.map_or(0.0, |colour| 2.0 * colour.sd * colour.sd * colour.memory_s)
    }

    /// Variance of the mean torque noise of a substep, (N m)^2.
    pub(crate) fn torque_variance(&self, dt_s: f64) -> f64 {
        self.torque_density / dt_s
    }
}

/// The rounding of a sensor: a function of position, so constant at rest and white where the rotor passes a step a sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Rounding {
    /// Variance of the part that the position keeps, rad^2 (m^2).
    pub(crate) variance: f64,
    /// One over the travel in which that part is forgotten, 1/rad (1/m).
    pub(crate) per_travel: f64,
}

/// Share of the rounding's variance that counts as white sensor noise: without any, a sample at rest would tell infinitely much
/// that a rounded one cannot; with a quarter its density is at most twice that of an even distribution over a step.
const WHITE_SHARE: f64 = 0.25;

/// Behind this many times the travel that forgets, a share of 1e-16 is left.
const FORGOTTEN: f64 = 37.0;

impl Rounding {
    /// Of a sensor with steps of that size, rad (m); none for a continuous one.
    pub(crate) fn new(step: f64) -> Self {
        if step <= 0.0 {
            return Self::default();
        }
        // The autocorrelation of a sawtooth of that period over the travel begins as 1 - 6 d / step.
        Self { variance: (1.0 - WHITE_SHARE) * step * step / 12.0, per_travel: 6.0 / step }
    }

    /// The least white noise of a sensor with steps of that size, rad (m).
    pub(crate) fn white_sd(step: f64) -> f64 {
        (WHITE_SHARE / 12.0).sqrt() * step
    }

    /// Share of the kept part that is left behind some travel.
    #[inline]
    pub(crate) fn kept(&self, travel: f64) -> f64 {
        let travels = self.per_travel * travel.abs();
        if travels < FORGOTTEN { (-travels).exp() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halfway_is_a_geometric_mean_and_the_same_stays() {
        let coloured = |sd| Some(Colour { sd, memory_s: 0.01 });
        let one = Noise { sensor_sd: 1e-6, torque_density: 1e-2, colour: coloured(1.0) };
        let other = Noise { sensor_sd: 1e-4, torque_density: 1e-6, colour: coloured(4.0) };
        let halfway = one.halfway_to(&other);
        assert!((halfway.sensor_sd - 1e-5).abs() < 1e-12 && (halfway.torque_density - 1e-4).abs() < 1e-12);
        assert_eq!(halfway.colour, coloured(2.0));
        assert_eq!(one.halfway_to(&one), one);
    }
}
