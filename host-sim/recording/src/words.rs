//! The words of which names of columns are made, and what they tell.

use crate::units;

/// Words of names, in small letters, by what they mean; the likeliest first. A stamp is of the machine, other times may be
/// when it was logged.
pub(crate) const TIME: &[&str] = &["stamp", "t", "time", "timestamp", "ts", "seconds", "sec", "clock", "zeit"];
pub(crate) const POSITION: &[&str] =
    &["position", "pos", "angle", "theta", "q", "x", "enc", "encoder", "phi", "winkel"];
pub(crate) const VELOCITY: &[&str] = &["velocity", "vel", "speed", "omega", "qd", "dq", "w", "v"];
pub(crate) const EFFORT: &[&str] = &[
    "torque", "force", "tau", "effort", "trq", "moment", "current", "curr", "cur", "iq", "i", "u", "f", "voltage",
    "strom",
];
/// Words that make a position the one that is wanted,
pub(crate) const WANTED: &[&str] =
    &["reference", "ref", "setpoint", "set", "target", "des", "desired", "demand", "goal", "sp", "cmd", "command"];
/// and an effort one that was measured, not commanded.
pub(crate) const MEASURED: &[&str] = &["meas", "measured", "act", "actual", "fb", "feedback", "est", "estimated"];
/// Which efforts are currents.
pub(crate) const CURRENT: &[&str] = &["current", "curr", "cur", "iq", "i", "strom"];
/// What tells a quantity.
const QUANTITIES: [&[&str]; 4] = [TIME, POSITION, VELOCITY, EFFORT];

/// The part of a name that tells what it is: what stands behind the last dot, where that tells anything. `/js.q1.effort` is an
/// effort, whatever the joint is called.
pub(crate) fn telling(name: &str) -> &str {
    let last = name.rsplit_once('.').map_or(name, |(_, last)| last);
    let known = |word: &String| QUANTITIES.iter().any(|list| is_one_of(word, list));
    if words(last).iter().any(known) { last } else { name }
}

/// Whether a word is one of a list, be it with the number of a joint behind it.
pub(crate) fn is_one_of(word: &str, list: &[&str]) -> bool {
    list.contains(&word) || list.contains(&word.trim_end_matches(|letter: char| letter.is_ascii_digit()))
}

/// The words of a name in small letters: parted by signs and by capitals, without its unit.
pub(crate) fn words(name: &str) -> Vec<String> {
    parts(units::before_brackets(name)).into_iter().map(|(_, part)| part.to_lowercase()).collect()
}

/// The parts of a text between signs, and before capitals behind small letters; each with the byte that it begins at.
fn parts(text: &str) -> Vec<(usize, &str)> {
    let mut parts = Vec::new();
    let (mut from, mut before) = (0, ' ');
    for (place, letter) in text.char_indices() {
        if !letter.is_alphanumeric() || (letter.is_uppercase() && before.is_lowercase()) {
            parts.push((from, &text[from..place]));
            from = if letter.is_alphanumeric() { place } else { place + letter.len_utf8() };
        }
        before = letter;
    }
    parts.push((from, &text[from..]));
    parts.retain(|(_, part)| !part.is_empty());
    parts
}

/// What a name says besides the quantity: of `arm_1_joint_position_rad` and of `cmd_effort_arm_1_joint` it is `arm_1_joint`. None
/// where no quantity stands at either end, or nothing else.
pub(crate) fn besides_quantity(name: &str) -> Option<&str> {
    let stem = units::stem(name);
    let parts = parts(stem);
    let parts = without_aside(&parts);
    let is_quantity = |part: &str| QUANTITIES.iter().any(|list| list.contains(&part));
    let (first, last) = (parts.first()?.1.to_lowercase(), parts.last()?.1.to_lowercase());
    // A letter alone is as often a direction: the `x` of `pos_x` and of `x_position`.
    let is_at_end = [2, 1].iter().find_map(|length| {
        let is = |part: &str| part.len() >= *length && is_quantity(part);
        if is(&last) { Some(true) } else { is(&first).then_some(false) }
    })?;
    let rest = without_aside(if is_at_end { &parts[..parts.len() - 1] } else { &parts[1..] });
    let ((from, _), (to, last)) = (rest.first()?, rest.last()?);
    stem.get(*from..to + last.len())
}

/// The parts without the words at both ends that tell a value to be wanted or measured.
fn without_aside<'a, 'b>(parts: &'a [(usize, &'b str)]) -> &'a [(usize, &'b str)] {
    let is_aside = |part: &str| {
        let part = part.to_lowercase();
        WANTED.contains(&part.as_str()) || MEASURED.contains(&part.as_str())
    };
    let inner = |(_, part): &(usize, &str)| !is_aside(part);
    match (parts.iter().position(inner), parts.iter().rposition(inner)) {
        (Some(from), Some(to)) => &parts[from..=to],
        _ => &[],
    }
}
