//! The counts as text.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{Arm, Outcome};

/// Every count, every single effect by size, every miss.
pub fn report(outcomes: &[Outcome]) -> String {
    let mut text = counts(outcomes);
    text += &singles(outcomes);
    text += &power(outcomes);
    text += &misses(outcomes);
    text
}

/// How many of them, and of how many.
fn share<'a>(of: impl Iterator<Item = &'a Outcome> + Clone, holds: impl Fn(&Outcome) -> bool) -> String {
    let (count, all) = (of.clone().filter(|outcome| holds(outcome)).count(), of.count());
    if all == 0 { "-".to_owned() } else { format!("{count}/{all}") }
}

fn counts(outcomes: &[Outcome]) -> String {
    let mut text = format!(
        "{:<11} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9}\n",
        "arm", "right", "exact", "first", "listed", "wrong", "abstained"
    );
    for arm in Arm::ALL {
        let of = outcomes.iter().filter(|outcome| outcome.arm == arm);
        if of.clone().next().is_none() {
            continue;
        }
        let when = |asked: bool, holds: fn(&Outcome) -> bool| {
            if asked { share(of.clone(), holds) } else { "-".to_owned() }
        };
        let right = when(true, Outcome::is_right);
        let exact = when(arm.nameable(), |o| o.exact);
        let first = when(arm.nameable(), |o| o.first_right);
        let listed = when(arm.nameable(), |o| o.listed);
        let wrong = when(true, |o| o.confidently_wrong);
        let abstained = when(!arm.nameable(), |o| o.abstained_right);
        let _ = writeln!(text, "{arm:<11} {right:>8} {exact:>8} {first:>8} {listed:>8} {wrong:>8} {abstained:>9}");
    }
    let intervals: Vec<_> = outcomes.iter().flat_map(|outcome| &outcome.intervals).collect();
    let holding = intervals.iter().filter(|interval| interval.holds).count();
    let _ = writeln!(text, "95 % intervals that hold the truth: {holding}/{}", intervals.len());
    let located = outcomes.iter().filter(|outcome| outcome.located.is_some());
    let _ = writeln!(text, "pushes located: {}", share(located, |outcome| outcome.located == Some(true)));
    for (what, ratios) in [
        ("oracle's", outcomes.iter().filter_map(|outcome| outcome.heldout_over_oracle).collect::<Vec<f64>>()),
        (
            "floor",
            outcomes.iter().map(|outcome| outcome.heldout_over_floor).filter(|ratio| ratio.is_finite()).collect(),
        ),
    ] {
        if let Some([median, high]) = quantiles(ratios) {
            let _ = writeln!(text, "held-out error over the {what}: median {median:.3}, 95 % below {high:.3}");
        }
    }
    text
}

/// Median and 95th percentile.
fn quantiles(mut values: Vec<f64>) -> Option<[f64; 2]> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some([0.5, 0.95].map(|q| values[(q * last as f64).round() as usize]))
}

fn by_effect(outcomes: &[Outcome]) -> BTreeMap<&str, Vec<&Outcome>> {
    let mut by_effect: BTreeMap<&str, Vec<&Outcome>> = BTreeMap::new();
    for outcome in outcomes.iter().filter(|outcome| outcome.arm == Arm::Single) {
        if let Some(effect) = outcome.truth.effects.first() {
            by_effect.entry(&effect.id).or_default().push(outcome);
        }
    }
    by_effect
}

/// One line an effect: the smallest size from which on the first name was right in half and in nine of ten cases, with
/// the values of one case of that size in the units of the machine.
fn power(outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for (id, mut cases) in by_effect(outcomes) {
        cases.sort_by(|a, b| b.size.total_cmp(&a.size));
        let sizes: Vec<&[&Outcome]> = cases.chunk_by(|a, b| a.size == b.size).collect();
        let found = [0.5, 0.9].map(|wanted| {
            let enough = |of: &&&[&Outcome]| {
                of.iter().filter(|outcome| outcome.first_right).count() as f64 >= wanted * of.len() as f64
            };
            let smallest = sizes.iter().take_while(enough).last().and_then(|of| of.first());
            smallest
                .map_or_else(|| "none of the sizes".to_owned(), |case| format!("{:.2} {}", case.size, case.concealed()))
        });
        let _ = writeln!(text, "{id:<22} 50 %: {}; 90 %: {}", found[0], found[1]);
    }
    if text.is_empty() {
        text
    } else {
        format!("\nsmallest size whose first name is right (share of the clear size)\n{text}")
    }
}

/// One line a case, by effect and size.
fn singles(outcomes: &[Outcome]) -> String {
    let by_effect = by_effect(outcomes);
    let mut text = String::new();
    if !by_effect.is_empty() {
        text += "\nsingle effects: value concealed, first name, interval of its first parameter\n";
    }
    for (id, mut cases) in by_effect {
        cases.sort_by(|a, b| b.size.total_cmp(&a.size).then(a.seed.cmp(&b.seed)));
        for case in cases {
            let value = case.truth.effects.first().and_then(|effect| effect.parameters.first());
            let value = value.map_or_else(String::new, |(name, value)| format!("{name} {value:.5}"));
            let holds = case.intervals.first().map_or("", |first| if first.holds { "holds" } else { "MISSES" });
            let mark = if case.is_right() { "ok" } else { "--" };
            let named = answer(case);
            let _ = writeln!(text, "{mark} {id:<22} {:>5.2}  {value:<32} {named} {holds}", case.size);
        }
    }
    text
}

fn answer(outcome: &Outcome) -> String {
    let verdict = format!("{:?}", outcome.verdict).to_lowercase();
    let equivalent =
        if outcome.equivalent.is_empty() { String::new() } else { format!(" ~ {}", outcome.equivalent.join(", ")) };
    format!("{verdict}: {}{equivalent}", outcome.named.join(" + "))
}

fn misses(outcomes: &[Outcome]) -> String {
    let mut text = String::from("\nmisses (again with --case SEED)\n");
    for outcome in outcomes.iter().filter(|outcome| !outcome.is_right()) {
        let concealed = if outcome.truth.effects.is_empty() { "nothing".to_owned() } else { outcome.concealed() };
        let _ = writeln!(text, "{:>7} {} {concealed} -> {}", outcome.seed, outcome.arm, answer(outcome));
    }
    let out = |outcome: &&Outcome| outcome.intervals.iter().any(|interval| !interval.holds);
    for outcome in outcomes.iter().filter(out) {
        for interval in outcome.intervals.iter().filter(|interval| !interval.holds) {
            let _ = writeln!(
                text,
                "{:>7} interval {}: {:.6} [{:.6}, {:.6}] misses {:.6}",
                outcome.seed, interval.parameter, interval.value, interval.low, interval.high, interval.truth
            );
        }
    }
    text
}
