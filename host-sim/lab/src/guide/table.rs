//! The guide as a table.

use super::{Confused, Page, TORQUE_NOISE_NM};

/// The guide in Markdown.
pub fn markdown(pages: &[Page]) -> String {
    let mut text = format!(
        "Default machine, steps and multisine of 8 s each, resolver steps and {TORQUE_NOISE_NM} N m of torque noise. \
         Angles are between the columns of two effects in the likelihood, 0 for the same but for size. Sizes and powers are \
         predicted from the models (exclusion from the confidence set at 0.05), not measured: `prove` measures.\n\n\
         | effect | picture | confused with, default experiments | confused with, slow sine | told from the nearest by | \
         parameter | default | 50 % | 90 % |\n|---|---|---|---|---|---|---|---|---|\n"
    );
    for page in pages {
        let picture = page.figure.as_ref().map_or(String::new(), |_| format!("[plot]({}.svg)", page.id));
        let told = page.separated_by.as_ref().map_or("-".to_owned(), |(other, item, power)| {
            format!("{other}: {} (`{}`), power {power:.2}", item.name, item.flags())
        });
        let [half, most] = page.detectable.map(number);
        text += &format!(
            "| {} | {picture} | {} | {} | {told} | {} | {} | {half} | {most} |\n",
            page.id,
            names(&page.on_rich),
            names(&page.on_sine),
            page.parameter,
            number(page.nominal)
        );
    }
    text + "\nA push in one recording (`disturbance_pulse`) and isolated wrong samples (`sensor_glitch`) are events: no \
            experiment brings them back, and they are told by their own recording.\n"
}

fn names(confused: &[Confused]) -> String {
    let each: Vec<String> = confused.iter().map(|other| format!("{} {:.0}°", other.id, other.angle_deg)).collect();
    if each.is_empty() { "-".to_owned() } else { each.join(", ") }
}

/// With four significant digits.
fn number(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| {
        if value == 0.0 {
            return "0".to_owned();
        }
        let decimals = (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
        format!("{value:.decimals$}")
    })
}
