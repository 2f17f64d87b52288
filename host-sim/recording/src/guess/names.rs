//! How well the name of a column fits what is looked for.

use crate::words::{EFFORT, MEASURED, POSITION, TIME, VELOCITY, WANTED, is_one_of, telling, words};
use crate::{AxisKind, Column, Table, units};

/// How well a column of a log fits one of a recording by its name and unit; none where it does not.
pub(super) fn fit(table: &Table, name: &str, column: Column, axis: AxisKind) -> Option<u32> {
    let words = words(telling(name));
    let whole = crate::words::words(name);
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
