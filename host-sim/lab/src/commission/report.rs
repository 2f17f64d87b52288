//! Before and after, in words.

use std::fmt::Write;

use er_servo::Config;
use er_servo::parameters::TABLE;

use super::{Commissioned, Figures};
use crate::report::summary;

/// The report as Markdown: the machine, the diagnosis, the step and the parameters before and after.
pub fn text(done: &Commissioned) -> String {
    let mut text = String::from("# Commissioning\n\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "## Machine\n\n```\n{}```\n", crate::identify::text(&done.identified));
    let _ = writeln!(text, "## Beyond this model\n\n```\n{}```\n\n{}\n", summary(&done.answer), named(done));
    let _ = writeln!(text, "## Gains\n\n```\n{}```\n", done.tuning);
    text += "## Step\n\n| | before | after |\n|---|---|---|\n";
    let (before, after) = (&done.step_before.1, &done.step_after.1);
    for (name, value) in FIGURES {
        let _ = writeln!(text, "| {name} | {} | {} |", value(before), value(after));
    }
    text += "\n## Parameters that differ\n\n| | before | after | |\n|---|---|---|---|\n";
    let kept = if done.kept { &done.after } else { &done.before };
    for parameter in TABLE {
        let value = |config: &Config| (parameter.get)(config);
        if value(&done.before) != value(&done.after) {
            let (name, unit) = (parameter.name, parameter.unit);
            let _ = writeln!(text, "| {name} | {} | {} | {unit} |", value(&done.before), value(&done.after));
        }
    }
    let _ = writeln!(text, "\n{}", if done.kept { KEPT[usize::from(done.saved)] } else { NOT_KEPT });
    let _ = writeln!(text, "Gains in the drive: {} N m/rad, {} N m s/rad.", kept.kp_nm_rad, kept.kd_nm_s_rad);
    text
}

/// Without and with flash.
const KEPT: [&str; 2] =
    ["The drive has the tuned parameters, up to its next reset.", "The drive has the tuned parameters, in flash too."];
const NOT_KEPT: &str = "The tuned step is not good enough: the drive has its parameters of before.";

type Value = fn(&Figures) -> String;

const FIGURES: [(&str, Value); 4] = [
    ("height, rad", |figures| format!("{:.4}", figures.height_rad)),
    ("settling, ms", |figures| {
        figures
            .settling_s
            .map_or_else(|| "not within the recording".to_owned(), |time_s| format!("{:.1}", 1e3 * time_s))
    }),
    ("overshoot, %", |figures| format!("{:.2}", 100.0 * figures.overshoot)),
    ("left at the end, mrad", |figures| format!("{:.3}", 1e3 * figures.residual_rad)),
];

fn named(done: &Commissioned) -> String {
    let ids: Vec<&str> = done.named.iter().map(|entry| entry.id.as_str()).collect();
    if ids.is_empty() {
        return "Nothing of it is added to the machine file.".to_owned();
    }
    format!("Added to the machine file: {}.", ids.join(", "))
}
