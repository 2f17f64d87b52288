//! What a machine does in a span, in words of use to an engineer.

use super::state::{FieldStep, field_steps};
use crate::read::AxisKind;
use crate::report::Region;
use crate::screen::Motion;

/// A span begins with an event that is at most this long before it, s,
const JUST_AFTER_S: f64 = 0.040;
/// or this long within it.
const JUST_WITHIN_S: f64 = 0.020;
/// Longer spans are no events, s.
pub(super) const EVENT_S: f64 = 0.4;
/// Rest shorter than this is a passage through zero, s.
const REST_S: f64 = 0.015;
/// A region that holds this share is said for spans that are no events.
const TELLING: f64 = 0.6;

/// One phrase, without a full stop.
pub(super) fn what_happens(motion: &Motion, start_s: f64, end_s: f64, axis: AxisKind, regions: &[Region]) -> String {
    let event = (end_s - start_s <= EVENT_S).then(|| event(motion, start_s, end_s)).flatten();
    let moving = moving(motion, start_s, end_s, axis);
    match (event, regions.first().filter(|region| region.share >= TELLING)) {
        (Some(event), _) => format!("{event}, {moving}"),
        (None, Some(region)) => format!("{moving}; most {}", condition(region)),
        (None, None) => moving,
    }
}

/// What a span begins or ends with.
fn event(motion: &Motion, start_s: f64, end_s: f64) -> Option<String> {
    let near = |at_s: f64| at_s > start_s - JUST_AFTER_S && at_s < start_s + JUST_WITHIN_S;
    let steps = field_steps(motion.field.as_deref(), &motion.t_s);
    if let Some(FieldStep { rises, .. }) = steps.iter().rev().find(|step| near(step.t_s)) {
        return Some(format!("just after the field {}", if *rises { "rises" } else { "falls" }));
    }
    let row = |at_s: f64| motion.t_s.partition_point(|t| *t < at_s).min(motion.cells());
    let from = row(start_s - JUST_AFTER_S);
    let to = row(end_s + JUST_WITHIN_S);
    let slow = &motion.at_rest[from..to];
    let rest_s = slow.iter().filter(|slow| **slow).count() as f64 * motion.period_s;
    let sign = |range: std::ops::Range<usize>| motion.speed.get(range).map_or(0.0, |part| part.iter().sum::<f64>());
    let reverses = sign(from..row(start_s).max(from + 1)) * sign(row(end_s).min(to.saturating_sub(1))..to) < 0.0;
    if rest_s >= REST_S && motion.at_rest[from..row(start_s + JUST_WITHIN_S).max(from)].contains(&true) {
        Some(if reverses { "at a reversal that rests" } else { "when it breaks away from rest" }.to_owned())
    } else if rest_s >= REST_S {
        Some("while it comes to rest".to_owned())
    } else if reverses || crosses_zero(&motion.speed[from..to]) {
        Some("at a reversal".to_owned())
    } else {
        None
    }
}

fn crosses_zero(speed: &[f64]) -> bool {
    speed.windows(2).any(|pair| pair[0] * pair[1] < 0.0)
}

/// Direction and speeds.
fn moving(motion: &Motion, start_s: f64, end_s: f64, axis: AxisKind) -> String {
    let unit = match axis {
        AxisKind::Rotary => "rad/s",
        AxisKind::Linear => "m/s",
    };
    let row = |at_s: f64| motion.t_s.partition_point(|t| *t < at_s);
    let part = &motion.speed[row(start_s).min(motion.speed.len() - 1)..row(end_s).min(motion.speed.len())];
    let (low, high) = part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), w| (l.min(*w), h.max(*w)));
    let peak = low.abs().max(high.abs());
    if part.is_empty() || peak == 0.0 {
        "at rest".to_owned()
    } else if low < -0.1 * peak && high > 0.1 * peak {
        format!("moving to and fro, up to {peak:.2} {unit}")
    } else if high > 0.1 * peak {
        format!("moving forwards at {:.2} to {high:.2} {unit}", low.max(0.0))
    } else {
        format!("moving backwards at {:.2} to {:.2} {unit}", (-high).max(0.0), -low)
    }
}

/// A range of state.
pub(super) fn condition(region: &Region) -> String {
    let Region { channel, low, high, .. } = region;
    match channel.as_str() {
        "direction" => if *high > 0.0 { "while moving forwards" } else { "while moving backwards" }.to_owned(),
        "speed_rad_s" => format!("at speeds of {low:.2} to {high:.2} rad/s"),
        "speed_m_s" => format!("at speeds of {low:.3} to {high:.3} m/s"),
        "position_rad" => format!("between {low:.2} and {high:.2} rad"),
        "position_m" => format!("between {low:.3} and {high:.3} m"),
        "field_kv_mm" if *high <= 0.0 => "without a field".to_owned(),
        "field_kv_mm" => format!("under fields of {low:.2} to {high:.2} kV/mm"),
        "since_field_step_s" => format!("{:.0} to {:.0} ms after the field steps", 1e3 * low, 1e3 * high),
        "torque_cmd_nm" => format!("at torques of {low:.2} to {high:.2} N m"),
        "force_cmd_n" => format!("at forces of {low:.1} to {high:.1} N"),
        "t_s" => format!("from {low:.2} to {high:.2} s"),
        other => match other.strip_prefix("phase_of_order_").and_then(|rest| rest.strip_suffix("_rad")) {
            Some(order) => format!("at phases of {low:.2} to {high:.2} rad within order {order}"),
            None => format!("at {low:.3} to {high:.3} of {other}"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(channel: &str, low: f64, high: f64) -> Region {
        Region { channel: channel.to_owned(), low, high, share: 0.9, share_low: 0.8, share_high: 1.0 }
    }

    #[test]
    fn regions_read_as_an_engineer_would_say_them() {
        assert_eq!(condition(&region("direction", 1.0, 1.0)), "while moving forwards");
        assert_eq!(condition(&region("field_kv_mm", 0.0, 0.0)), "without a field");
        assert_eq!(condition(&region("since_field_step_s", 0.0, 0.012)), "0 to 12 ms after the field steps");
        assert_eq!(condition(&region("speed_rad_s", 2.0, 5.5)), "at speeds of 2.00 to 5.50 rad/s");
        assert_eq!(
            condition(&region("phase_of_order_14_rad", 0.5, 1.0)),
            "at phases of 0.50 to 1.00 rad within order 14"
        );
    }
}
