//! What was commanded, where the torque column is not it but something made of it.

use plant::Command;

use crate::recorded::Recorded;

/// The commands whose torque a first-order filter of `tau_s` turned into the recorded ones: T + tau dT/dt, by differences
/// over the neighbouring rows.
pub(super) fn unfiltered(recorded: &Recorded, tau_s: f64) -> Option<Vec<Command>> {
    if tau_s <= 0.0 {
        return None;
    }
    let (t_s, commands) = (&recorded.t_s, &recorded.commands);
    let last = commands.len().checked_sub(1)?;
    let rate = |row: usize| {
        let (from, to) = (row.saturating_sub(1), (row + 1).min(last));
        if to > from { (commands[to].torque - commands[from].torque) / (t_s[to] - t_s[from]) } else { 0.0 }
    };
    Some((0..=last).map(|row| Command { torque: commands[row].torque + tau_s * rate(row), ..commands[row] }).collect())
}

/// The commands whose torque is the mean of what was commanded in the last `over_s`, looked at in the middle of each row's interval.
pub(super) fn blurred(recorded: &Recorded, over_s: f64) -> Option<Vec<Command>> {
    if over_s <= 0.0 {
        return None;
    }
    let (t_s, commands) = (&recorded.t_s, &recorded.commands);
    let mut sums = vec![0.0];
    for (row, pair) in t_s.windows(2).enumerate() {
        sums.push(sums[row] + commands[row].torque * (pair[1] - pair[0]));
    }
    let first = commands.first()?.torque;
    let mut from = 0;
    let means = (0..commands.len()).map(|row| {
        let middle_s = t_s.get(row + 1).map_or(t_s[row], |next_s| 0.5 * (t_s[row] + next_s));
        let began_s = middle_s - over_s;
        while from + 1 < t_s.len() && t_s[from + 1] <= began_s {
            from += 1;
        }
        let until = sums[row] + commands[row].torque * (middle_s - t_s[row]);
        // Before the first row its command held.
        let before = if began_s < t_s[0] {
            first * (began_s - t_s[0])
        } else {
            sums[from] + commands[from].torque * (began_s - t_s[from])
        };
        Command { torque: (until - before) / over_s, ..commands[row] }
    });
    Some(means.collect())
}
