//! Sensors that count the way and lose some of it for good. They are read once a control period.

use super::super::Hidden;

/// Range of speeds over the first at which pulses are missed until all are too fast, 1.
const WIDTH: f64 = 0.1;

/// A counter whose input filter is too slow for the pulses of an incremental encoder: beyond a speed it misses some (filters of quadrature
/// decoders, as that of the HCTL-2000, limit the rate).
pub(in crate::outside) struct CountsLost {
    share: f64,
    /// In a period, rad or m.
    most: f64,
    last: f64,
    lost: f64,
}

impl CountsLost {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { share: v[0], most: v[1] * v[2], last: 0.0, lost: 0.0 }
    }
}

impl Hidden for CountsLost {
    fn measured(&mut self, position: f64) -> f64 {
        let way = position - self.last;
        self.last = position;
        // All pulses are alike to the filter: beyond the speed a share of all is missed, not only of what is too much.
        let missed = ((way.abs() / self.most - 1.0) / WIDTH).clamp(0.0, 1.0);
        self.lost += self.share * missed * way;
        position - self.lost
    }
}

/// A measuring wheel that friction alone turns: where the axis gains or loses speed faster than its grip can turn it, it skids (wheels on
/// belts and webs, odometers).
pub(in crate::outside) struct WheelSkids {
    /// Change of the way in a period from one to the next, rad or m.
    most: f64,
    last: f64,
    way: f64,
    at: f64,
}

impl WheelSkids {
    pub(in crate::outside) fn new(v: &[f64]) -> Self {
        Self { most: v[0] * v[1] * v[1], last: 0.0, way: 0.0, at: 0.0 }
    }
}

impl Hidden for WheelSkids {
    fn measured(&mut self, position: f64) -> f64 {
        let change = position - self.last - self.way;
        self.last = position;
        self.way += change.clamp(-self.most, self.most);
        self.at += self.way;
        self.at
    }
}
