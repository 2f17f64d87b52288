//! The way of a reference from the link: bounded in place, speed and acceleration (trapezoidal speed).

use crate::units::{Counts, RAD_PER_COUNT};
use crate::{Config, maths};

/// What bounds a reference, in counts and ticks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MotionLimits {
    /// Lowest position.
    pub low: Counts,
    /// Highest position.
    pub high: Counts,
    pub(crate) speed_counts: f32,
    pub(crate) acceleration_counts: f32,
    counts_per_rad_s: f32,
    counts_per_rad_s2: f32,
}

impl MotionLimits {
    pub(crate) fn of(config: &Config) -> Self {
        let counts_per_rad_s = config.period_s / RAD_PER_COUNT;
        let counts_per_rad_s2 = counts_per_rad_s * config.period_s;
        Self {
            low: Counts((config.position_min_rad / RAD_PER_COUNT) as i32),
            high: Counts((config.position_max_rad / RAD_PER_COUNT) as i32),
            speed_counts: config.speed_limit_rad_s * counts_per_rad_s,
            acceleration_counts: config.acceleration_limit_rad_s2 * counts_per_rad_s2,
            counts_per_rad_s,
            counts_per_rad_s2,
        }
    }

    /// Whether an absolute reference is between the soft limits.
    pub fn allow(&self, reference: Counts) -> bool {
        (self.low..=self.high).contains(&reference)
    }

    /// A reference held between the soft limits. One that is outside already, because the axis was enabled there, may only
    /// go back.
    pub(crate) fn hold(&self, reference: Counts, before: Counts) -> Counts {
        // Not `clamp`, which panics on limits that a flipped bit has reversed.
        Counts(reference.0.min(self.high.0.max(before.0)).max(self.low.0.min(before.0)))
    }
}

/// How fast to go there.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Pace {
    /// Highest speed, rad/s; 0 for `speed_limit_rad_s`, which bounds it.
    pub speed_rad_s: f32,
    /// Acceleration, rad/s2; 0 for `acceleration_limit_rad_s2`, which bounds it.
    pub acceleration_rad_s2: f32,
}

impl Pace {
    /// Whether both are numbers from 0 up.
    pub fn is_valid(&self) -> bool {
        self.speed_rad_s >= 0.0 && self.acceleration_rad_s2 >= 0.0
    }
}

/// Where a reference is on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Profile {
    whole: Counts,
    /// Of a count, beyond `whole`.
    fraction: f32,
    /// Counts a tick.
    speed: f32,
    top_speed: f32,
    acceleration: f32,
}

impl Profile {
    /// At rest at a reference.
    pub(crate) fn at(reference: Counts) -> Self {
        Self { whole: reference, fraction: 0.0, speed: 0.0, top_speed: 0.0, acceleration: 0.0 }
    }

    /// From here on with that pace; a speed it has already is kept.
    pub(crate) fn pace(&mut self, limits: &MotionLimits, pace: &Pace) {
        let bounded = |asked: f32, limit: f32| if asked > 0.0 && asked < limit { asked } else { limit };
        self.top_speed = bounded(pace.speed_rad_s * limits.counts_per_rad_s, limits.speed_counts);
        self.acceleration = bounded(pace.acceleration_rad_s2 * limits.counts_per_rad_s2, limits.acceleration_counts);
    }

    /// Where it comes to rest if it slows down from now on.
    pub(crate) fn nearest_rest(&self) -> Counts {
        if self.acceleration <= 0.0 {
            return self.whole;
        }
        let way = 0.5 * self.speed * self.speed.abs() / self.acceleration + 0.5 * self.speed;
        Counts(self.whole.0.saturating_add((way + self.fraction) as i32))
    }

    /// The reference a tick later on its way to `target`.
    pub(crate) fn next(&mut self, target: Counts) -> Counts {
        if self.whole == target && self.speed == 0.0 && self.fraction == 0.0 {
            return target;
        }
        let left = target.0.saturating_sub(self.whole.0) as f32 - self.fraction;
        let (acceleration, ahead) = (self.acceleration, left.abs());
        // The speed from which whole ticks of deceleration end at the target, and not beyond it; with a tenth in hand to make
        // good what the tick before the first of them was too fast.
        let slowing = 0.9 * acceleration;
        let stopping = maths::sqrt(2.0 * slowing * ahead + 0.25 * slowing * slowing) - 0.5 * slowing;
        let (wanted, _) = maths::limit(stopping, 0.0, self.top_speed);
        let change = if left < 0.0 { -wanted } else { wanted } - self.speed;
        self.speed += maths::limit(change, -acceleration, acceleration).0;
        // Two changes of speed are still within what a tick may change by rounding; a faster one passes and comes back. Where one
        // change of speed is more than the top speed, that is how far the last tick goes.
        if self.speed.abs() <= 2.0 * acceleration && ahead <= self.speed.abs().max(acceleration.min(self.top_speed)) {
            *self = Self { top_speed: self.top_speed, acceleration, ..Self::at(target) };
            return target;
        }
        let moved = self.fraction + self.speed;
        // Towards zero, so that the fraction keeps its sign and stays below one count.
        let whole = moved as i32;
        self.whole = Counts(self.whole.0.saturating_add(whole));
        self.fraction = moved - whole as f32;
        self.whole
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Params;
    use proptest::prelude::*;

    fn limits() -> MotionLimits {
        *Params::new(&Config::default()).unwrap().motion()
    }

    proptest! {
        #[test]
        fn it_arrives_within_its_speed_and_acceleration_and_does_not_pass(
            start in -2_000_000..2_000_000_i32, way in -1_500_000..1_500_000_i32,
            speed_rad_s in 0.05..30.0_f32, acceleration_rad_s2 in 5.0..400.0_f32,
        ) {
            let limits = limits();
            let mut profile = Profile::at(Counts(start));
            profile.pace(&limits, &Pace { speed_rad_s, acceleration_rad_s2 });
            let (speed, change) = (profile.top_speed, profile.acceleration);
            prop_assert!(speed <= limits.speed_counts && change <= limits.acceleration_counts);
            let target = Counts(start + way);
            let ticks = (way.abs() as f32 / speed + 2.0 * speed / change + 2.2 * (way.abs() as f32 / change).sqrt()) as u32 + 40;
            let (mut before, mut moved_before) = (start, 0);
            for _ in 0..ticks {
                let now = profile.next(target).0;
                let moved = now - before;
                prop_assert!((moved.abs() as f32) <= speed + 1.0, "{moved} of {speed}");
                prop_assert!((moved - moved_before).abs() as f32 <= 2.0 * change + 2.0, "{moved} after {moved_before}");
                prop_assert!((now - start) * way.signum() <= way.abs() && moved * way.signum() >= 0);
                (before, moved_before) = (now, moved);
            }
            prop_assert_eq!(profile.next(target), target);
        }
    }

    #[test]
    fn soft_limits_hold_and_let_an_axis_outside_come_back() {
        let config = Config { position_min_rad: -1.0, position_max_rad: 1.0, ..Config::default() };
        let limits = *Params::new(&config).unwrap().motion();
        let high = limits.high.0;
        assert_eq!(limits.hold(Counts(high + 1), Counts(0)), Counts(high));
        assert_eq!(limits.hold(Counts(i32::MIN), Counts(0)), limits.low);
        let outside = Counts(high + 500);
        assert_eq!(limits.hold(Counts(high + 900), outside), outside);
        assert_eq!(limits.hold(Counts(high + 100), outside), Counts(high + 100));
        assert!(limits.allow(Counts(high)) && !limits.allow(Counts(high + 1)));
    }
}
