//! What the names of columns tell.

use crate::units;
use crate::{AxisKind, Column, Table};

/// Words of names, in small letters, by what they mean; the likeliest first. A stamp is of the machine, other times may be
/// when it was logged.
const TIME: &[&str] = &["stamp", "t", "time", "timestamp", "ts", "seconds", "sec", "clock", "zeit"];
const POSITION: &[&str] = &["position", "pos", "angle", "theta", "q", "x", "enc", "encoder", "phi", "winkel"];
const VELOCITY: &[&str] = &["velocity", "vel", "speed", "omega", "qd", "dq", "w", "v"];
const EFFORT: &[&str] = &[
    "torque", "force", "tau", "effort", "trq", "moment", "current", "curr", "cur", "iq", "i", "u", "f", "voltage",
    "strom",
];
/// Words that make a position the one that is wanted,
const WANTED: &[&str] =
    &["reference", "ref", "setpoint", "set", "target", "des", "desired", "demand", "goal", "sp", "cmd", "command"];
/// and an effort one that was measured, not commanded.
const MEASURED: &[&str] = &["meas", "measured", "act", "actual", "fb", "feedback", "est", "estimated"];

/// How well a column of a log fits one of a recording by its name and unit; none where it does not.
pub(super) fn fit(table: &Table, name: &str, column: Column, axis: AxisKind) -> Option<u32> {
    let words = words(telling(name));
    let whole = self::words(name);
    // That a value is wanted or measured is told by a topic as well.
    let any = |list: &[&str]| words.iter().chain(&whole).any(|word| is_one_of(word, list));
    let is = |list: &[&str]| words.iter().any(|word| is_one_of(word, list));
    let rank = |list: &[&str]| {
        list.iter()
            .position(|known| words.iter().any(|word| is_one_of(word, &[*known])))
            .map(|place| (list.len() - place) as u32)
    };
    let quantity = table.unit(name).and_then(|unit| units::measure(&unit)).map(|measure| measure.quantity);
    let by_word = match column {
        Column::Time => rank(TIME).filter(|_| !is(POSITION) && !is(EFFORT)),
        Column::Position => rank(POSITION).filter(|_| !any(WANTED) && !is(VELOCITY)),
        Column::Reference => rank(POSITION).filter(|_| any(WANTED)).or_else(|| {
            // `reference_rad`, `setpoint [mm]`: of which quantity the unit tells, and nothing else does.
            rank(WANTED)
                .filter(|_| quantity.is_some_and(|quantity| column.quantities(axis)[0] == quantity) && !is(EFFORT))
        }),
        Column::Velocity => rank(VELOCITY).filter(|_| !any(WANTED)),
        Column::EffortCmd => rank(EFFORT).filter(|_| !any(MEASURED)),
        Column::EffortMeas => rank(EFFORT).filter(|_| any(MEASURED)),
        _ => None,
    }?;
    match quantity {
        // A unit of another kind says more than the name.
        Some(quantity) => column.quantities(axis).contains(&quantity).then_some(by_word + 100),
        None => Some(by_word),
    }
}

/// The part of a name that tells what it is: what stands behind the last dot, where that tells anything. `/js.q1.effort` is an
/// effort, whatever the joint is called.
pub(super) fn telling(name: &str) -> &str {
    let last = name.rsplit_once('.').map_or(name, |(_, last)| last);
    let known = |word: &String| [TIME, POSITION, VELOCITY, EFFORT].iter().any(|list| is_one_of(word, list));
    if words(last).iter().any(known) { last } else { name }
}

/// Whether a word is one of a list, be it with the number of a joint behind it.
pub(super) fn is_one_of(word: &str, list: &[&str]) -> bool {
    list.contains(&word) || list.contains(&word.trim_end_matches(|letter: char| letter.is_ascii_digit()))
}

/// The words of a name in small letters: parted by signs and by capitals, without its unit.
pub(super) fn words(name: &str) -> Vec<String> {
    let name = name.split(['[', '(']).next().unwrap_or(name);
    parts(name).into_iter().map(|(_, part)| part.to_lowercase()).collect()
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
    let is_quantity = |part: &str| [TIME, POSITION, VELOCITY, EFFORT].iter().any(|list| list.contains(&part));
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
fn without_aside<'a, 'b>(mut parts: &'a [(usize, &'b str)]) -> &'a [(usize, &'b str)] {
    let is_aside = |part: &str| {
        let part = part.to_lowercase();
        WANTED.contains(&part.as_str()) || MEASURED.contains(&part.as_str())
    };
    while let Some((_, rest)) = parts.split_first().filter(|((_, first), _)| is_aside(first)) {
        parts = rest;
    }
    while let Some((_, rest)) = parts.split_last().filter(|((_, last), _)| is_aside(last)) {
        parts = rest;
    }
    parts
}
