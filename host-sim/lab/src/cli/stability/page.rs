//! The answer as a page.

use super::text::{labelled, name};
use crate::Error;
use crate::output::Provenance;
use crate::plot::Figure;
use crate::report::html::{Page, Section, badge, number, picture, plain, short, text};
use crate::stability::analysis::{Analysis, Methods};
use crate::stability::limits::{Limit, Margins, Tolerance};

/// The page, with the regions as its picture, and what made it.
///
/// # Errors
/// What the drawing library says.
pub(super) fn page(analysis: &Analysis, regions: &Figure, made: &Provenance) -> Result<String, Error> {
    let (kind, word) = if analysis.inside { ("good", "stable") } else { ("", "unstable") };
    let sections = [
        Some(margins(analysis)),
        tolerances(&analysis.tolerances),
        Some(methods(&analysis.methods)),
        Some(areas(analysis)),
        limit_cycles(analysis),
        Some(loop_of(analysis)),
    ];
    let caption =
        "Where the linear loop is stable in the plane of both gains, for three delays of the fluid, and the gains.";
    let page = Page {
        title: format!("Stability: {word}"),
        about: format!("Stability of the linear loop, {}", name(analysis.plant.fluid)),
        heading: badge(kind, word) + &text(&sentence(analysis)),
        picture: picture(regions, caption)?,
        sections: sections.into_iter().flatten().collect(),
        script: None,
    };
    Ok(page.html(made))
}

/// A computed figure, which has no interval: four digits.
fn figure(value: f64) -> String {
    number(value, 0.0)
}

fn sentence(analysis: &Analysis) -> String {
    let Some(margins) = &analysis.margins else {
        return "The gains are outside the region: the loop grows by itself.".to_owned();
    };
    let gain =
        margins.gain.map_or("any larger torque".to_owned(), |gain| format!("a torque {} times as large", figure(gain)));
    let delay =
        margins.delay_s.map_or("any delay".to_owned(), |delay_s| format!("{} ms more of delay", figure(1e3 * delay_s)));
    let phase =
        margins.phase_deg.map_or(String::new(), |deg| format!(", with a phase margin of {} degrees", figure(deg)));
    format!("The gains are inside the region: the loop bears {gain} and {delay}{phase}.")
}

fn margins(analysis: &Analysis) -> Section {
    let Some(margins) = &analysis.margins else {
        return Section::new("margins", "Margins", "<p>An unstable loop has none.</p>".to_owned());
    };
    let Margins {
        gain, gain_db, gain_lower, phase_deg, phase_lead_deg, crossover_rad_s, delay_s, delay_factor, ..
    } = *margins;
    let row = |what: &str, value: Option<f64>, unit: &str| {
        vec![what.to_owned(), value.map_or("none".to_owned(), figure), unit.to_owned()]
    };
    let rows = [
        row("gain: torque times this loses the loop", gain, ""),
        row("the same in decibels", gain_db, "dB"),
        row("lower: so little torque loses the loop", gain_lower, ""),
        row("phase: so much more lag loses the loop", phase_deg, "degrees"),
        row("its crossover", crossover_rad_s, "rad/s"),
        row("phase: so much lead loses the loop", phase_lead_deg, "degrees"),
        row("delay: so much more loses the loop", delay_s.map(|delay_s| 1e3 * delay_s), "ms"),
        row("the same over L: L may grow by this factor", delay_factor, ""),
    ];
    let caption = "Of the loop opened at the control torque, the damper's own feedback staying closed";
    Section::new("margins", "Margins", plain(caption, &["margin", "value", "unit"], &rows))
}

fn tolerances(tolerances: &[Tolerance]) -> Option<Section> {
    let row = |tolerance: &Tolerance| {
        let (label, scale) = labelled(tolerance.quantity);
        let limit = |limit: Option<Limit>, none: &str| match limit {
            Some(limit) => vec![figure(limit.factor), figure(limit.value * scale), figure(limit.omega_rad_s)],
            None => vec![none.to_owned(), String::new(), String::new()],
        };
        let cells = [vec![label.to_owned(), short(tolerance.nominal * scale)], limit(tolerance.lower, "any less")];
        cells.into_iter().chain([limit(tolerance.upper, "any more")]).flatten().collect()
    };
    let rows: Vec<Vec<String>> = tolerances.iter().map(row).collect();
    let head = [
        "quantity",
        "as it is",
        "down to, factor",
        "value",
        "swinging at (rad/s)",
        "up to, factor",
        "value",
        "swinging at (rad/s)",
    ];
    let table = plain("Each alone, the others as they are, until a root reaches the imaginary axis", &head, &rows);
    (!rows.is_empty()).then(|| Section::new("tolerances", "How far each quantity may move alone", table))
}

fn methods(methods: &Methods) -> Section {
    let count = |count: Option<usize>, none: &str| count.map_or_else(|| none.to_owned(), |count| count.to_string());
    let rightmost = methods.rightmost_roots.first().map_or_else(String::new, |root| {
        format!("rightmost {} \u{b1} {}j rad/s", figure(root.re_per_s), figure(root.im_rad_s.abs()))
    });
    let sampled = methods.sampled_stable.map_or("no answer", |stable| if stable { "stable" } else { "unstable" });
    let radius = methods.sampled_spectral_radius.map_or_else(String::new, |radius| {
        // Its distance from 1 decides.
        format!(
            "spectral radius {}, of one period of {} ms",
            number(radius, (1.0 - radius).abs()),
            1e3 * methods.sampled_period_s
        )
    });
    let rows = [
        [
            "boundary curves",
            &methods.curves_unstable_roots.to_string(),
            "by what a path in the plane of the gains crosses",
        ],
        ["argument principle", &count(methods.argument_unstable_roots, "one on the axis"), ""],
        ["Chebyshev discretisation", &count(methods.spectrum_unstable_roots, "no answer"), &rightmost],
        ["sampled loop", sampled, &radius],
    ];
    let rows = rows.map(|row| row.map(str::to_owned).to_vec());
    let table = plain(
        "Unstable roots, and the sampled loop, by methods that share only the equation",
        &["method", "answer", ""],
        &rows,
    );
    let others = methods.unanswered.iter().map(|reason| format!("<p class=\"note\">No answer: {}</p>", text(reason)));
    let agree = if methods.agree {
        "<p>All that answered agree.</p>"
    } else {
        "<p class=\"note\">Not all agree: the loop is at its limit, or as fast as the control period.</p>"
    };
    Section::new("methods", "By which methods", format!("{table}{}{agree}", others.collect::<String>()))
}

fn areas(analysis: &Analysis) -> Section {
    let rows = analysis.regions.iter().map(|region| {
        let side = if region.inside { "inside" } else { "outside" };
        let beyond = if region.leaves_window { "goes on beyond" } else { "" };
        vec![name(region.fluid), figure(region.area), side.to_owned(), beyond.to_owned()]
    });
    let caption = format!("Within K_p* 0 to {} and K_d* 0 to {}", analysis.window.kp, analysis.window.kd);
    let rows: Vec<_> = rows.collect();
    let table = plain(&caption, &["fluid", "area of the region", "the gains are", ""], &rows);
    Section::new("regions", "Stable regions", table)
}

fn limit_cycles(analysis: &Analysis) -> Option<Section> {
    let models = analysis.limit_cycles.as_ref()?;
    let rows = models.iter().map(|model| {
        let cycles = model.cycles.iter().map(|cycle| {
            let kind = if cycle.stable { "lasting" } else { "dividing" };
            format!("{kind} {} mrad at {} rad/s", figure(1e3 * cycle.amplitude_rad), figure(cycle.frequency_rad_s))
        });
        let cycles: Vec<String> = cycles.collect();
        let cycles = if cycles.is_empty() { "none".to_owned() } else { cycles.join(", ") };
        vec![model.model.to_owned(), cycles, figure(1e3 * model.simulated_amplitude_rad)]
    });
    let rows: Vec<_> = rows.collect();
    let caption = "By harmonic balance, with friction, damper law and torque limit in place of Q";
    let table = plain(caption, &["delay model", "limit cycles", "left in a run (mrad)"], &rows);
    Some(Section::new("cycles", "Limit cycles of the nonlinear loop", table))
}

fn loop_of(analysis: &Analysis) -> Section {
    let Analysis { plant, gains, normalised_gains, .. } = analysis;
    let rows = [
        ("inertia J", short(plant.inertia_kg_m2), "kg m2"),
        ("delay of the motor L", short(1e3 * plant.torque_delay_s), "ms"),
        ("viscosity without delay Q0", short(plant.q0_nm_s_rad), "N m s/rad"),
        ("viscosity behind the fluid's delay Q1", short(plant.q1_nm_s_rad), "N m s/rad"),
        ("delay of the fluid", name(plant.fluid), ""),
        ("K_P", figure(gains.k_p_nm_rad), "N m/rad"),
        ("K_D", figure(gains.k_d_nm_s_rad), "N m s/rad"),
        ("K_p* = K_P L\u{b2} / J", figure(normalised_gains.kp), ""),
        ("K_d* = K_D L / J", figure(normalised_gains.kd), ""),
    ];
    let rows = rows.map(|(what, value, unit)| vec![what.to_owned(), value, unit.to_owned()]);
    Section::new("loop", "The loop", plain("What was analysed", &["quantity", "value", "unit"], &rows))
}
