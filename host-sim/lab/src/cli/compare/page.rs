//! Recordings beside a model as a page.

use super::{Beside, Compared};
use crate::Error;
use crate::output::Provenance;
use crate::plot::Figure;
use crate::report::compare::{Followed, Left, Worst};
use crate::report::html::{Page, Section, figure, number, picture, plain, prefix, short, text, warnings};

/// Recordings whose pictures are open at once: a page of many opens quickly.
const OPEN: usize = 3;

/// The page for recordings beside the machine called `machine`, and what made it.
///
/// # Errors
/// What the drawing library says.
pub(super) fn page(machine: &str, compared: &Compared<'_>, made: &Provenance) -> Result<String, Error> {
    let all = &compared.beside;
    let names: Vec<&str> = all.iter().map(|one| one.recording.name.as_str()).collect();
    let sections = [
        warnings(&compared.warnings),
        notes(all),
        Some(Section::new("left", "How much is left", left(all))),
        Some(Section::new("follows", "What it follows", all.iter().map(followed).collect())),
        Some(Section::new("worst", "Where most is left", all.iter().map(worst).collect())),
        Some(pictures(all)?),
    ];
    let page = Page {
        title: format!("{machine}: comparison"),
        about: format!("Comparison of {machine} with {}", names.join(", ")),
        heading: text(&sentence(all)),
        picture: all.first().map_or(Ok(String::new()), first)?,
        sections: sections.into_iter().flatten().collect(),
        script: None,
    };
    Ok(page.html(made))
}

/// What the shorter windows leave of each recording, in times of the sensor's noise.
fn times_the_noise(one: &Beside<'_>) -> f64 {
    one.nominal.rms() / one.nominal.noise().max(f64::MIN_POSITIVE)
}

/// Less of the residual with the improved model, of one of the lengths of the windows.
fn less(one: &Beside<'_>, length: usize) -> Option<f64> {
    let (improved, nominal) = (one.improved.as_ref()?.left().nth(length)?, one.nominal.left().nth(length)?);
    Some(100.0 * (1.0 - improved.rms / nominal.rms.max(f64::MIN_POSITIVE)))
}

fn sentence(all: &[Beside<'_>]) -> String {
    let times: Vec<f64> = all.iter().map(times_the_noise).collect();
    let range = |values: &[f64], unit: &str| {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let [low, high] = [low, high].map(|value| format!("{value:.1}"));
        if low == high { format!("{low}{unit}") } else { format!("{low} to {high}{unit}") }
    };
    let improved: Vec<f64> = all.iter().filter_map(|one| less(one, 0)).collect();
    let improved = if improved.is_empty() {
        String::new()
    } else {
        format!("; the improved one leaves {} less", range(&improved, " %"))
    };
    format!("The model leaves {} the noise of the sensor{improved}.", range(&times, " times"))
}

/// Where the residual of the first recording is in time.
fn first(one: &Beside<'_>) -> Result<String, Error> {
    let all = one.figure();
    let panels = all.panels.into_iter().skip(1).take(1).collect();
    let caption = format!("What is left of {} in the shorter windows, each from its best start.", one.recording.name);
    picture(&Figure { title: one.recording.name.clone(), panels }, &caption)
}

fn notes(all: &[Beside<'_>]) -> Option<Section> {
    let notes = all.iter().flat_map(|one| one.recording.notes());
    let notes: String = notes.map(|note| format!("<li>{}</li>", text(&note.to_string()))).collect();
    (!notes.is_empty()).then(|| Section::new("notes", "What was read how", format!("<ul>{notes}</ul>")))
}

fn left(all: &[Beside<'_>]) -> String {
    let largest = all.iter().flat_map(|one| one.nominal.windows()).map(|(_, rms)| rms).fold(0.0, f64::max);
    let (prefix, factor) = prefix(largest);
    let row = |one: &Beside<'_>, length: usize, left: Left| {
        let noise = one.nominal.noise();
        let mut cells = vec![
            one.recording.name.clone(),
            format!("{:.0}", 1e3 * left.horizon_s),
            left.windows.to_string(),
            number(factor * left.rms, 0.0),
            number(factor * noise, 0.0),
            format!("{:.1}", left.rms / noise.max(f64::MIN_POSITIVE)),
            number(left.effort_rms, 0.0),
        ];
        let improved = one.improved.as_ref().and_then(|improved| improved.left().nth(length));
        cells.extend(improved.map(|left| number(factor * left.rms, 0.0)));
        cells.extend(less(one, length).map(|less| format!("{less:.1} %")));
        cells
    };
    let rows =
        all.iter().flat_map(|one| one.nominal.left().enumerate().map(move |(length, left)| row(one, length, left)));
    let rows: Vec<_> = rows.collect();
    let units = all.first().map(|one| one.nominal.units());
    let (position, effort_name, effort) = units.map_or(("", "", ""), |u| (u.position, u.effort_name, u.effort));
    let effort = format!("as a {effort_name} ({effort})");
    let mut head =
        vec!["recording", "windows of (ms)", "number", "nominal", "noise of one sample", "times the noise", &effort];
    if all.iter().any(|one| one.improved.is_some()) {
        head.extend(["improved", "less"]);
    }
    plain(&format!("Recorded less simulated position, rms in {prefix}{position}"), &head, &rows)
}

/// The share of the residual that goes with each channel, and where it is largest.
fn followed(one: &Beside<'_>) -> String {
    let u = one.nominal.units();
    let orders = one.nominal.orders().map(|orders| {
        let names =
            orders.orders.iter().map(|order| format!("{} ({} N m)", order.per_rev, number(order.amplitude_nm, 0.0)));
        let names: Vec<String> = names.collect();
        let share = format!("{:.1} %", 100.0 * orders.explained);
        vec!["position within a revolution".to_owned(), share, format!("orders {}", names.join(", ")), String::new()]
    });
    let row = |followed: Followed| {
        let share = format!("{:.1} %", 100.0 * followed.share);
        vec![followed.name.to_owned(), share, followed.mean("\u{b1}"), followed.place()]
    };
    let rows: Vec<Vec<String>> = orders.into_iter().chain(one.nominal.followed().into_iter().map(row)).collect();
    let largest = format!("largest mean, 95 % ({})", u.effort);
    let caption =
        format!("Share of the residual {} of {} that goes with each channel", u.effort_name, one.recording.name);
    let table = plain(&caption, &["channel", "share", &largest, "where that is"], &rows);
    let aside = match one.nominal.set_aside() {
        0 => String::new(),
        aside => format!("<p class=\"note\">{aside} windows far beyond all others are set aside.</p>"),
    };
    table + &aside
}

fn worst(one: &Beside<'_>) -> String {
    let u = one.nominal.units();
    let row = |Worst { span_s: [start_s, end_s], effort, speed }| {
        vec![format!("{start_s:.3} to {end_s:.3}"), number(effort, 0.0), number(speed, 0.0)]
    };
    let rows: Vec<_> = one.nominal.worst().into_iter().map(row).collect();
    let caption = format!("Windows of {} in which most is left", one.recording.name);
    let (effort, speed) = (format!("{} left ({})", u.effort_name, u.effort), format!("mean speed ({})", u.speed));
    plain(&caption, &["time (s)", &effort, &speed], &rows)
}

fn pictures(all: &[Beside<'_>]) -> Result<Section, Error> {
    let one = |(index, one): (usize, &Beside<'_>)| {
        let r = one.recording;
        let length_s = r.t_s.last().unwrap_or(&0.0) - r.t_s.first().unwrap_or(&0.0);
        let caption = "Position; what is left of it in the shorter and the longer windows; and the residual over the channels, \
                       with 95 % intervals of the means.";
        let open = if index < OPEN { " open" } else { "" };
        Ok(format!(
            "<details{open}><summary><h3>{}</h3> <span class=\"quiet\">{} rows, {} s, {} gaps</span></summary>{}</details>",
            text(&r.name),
            r.t_s.len(),
            short(length_s),
            r.gaps.len(),
            figure(&one.figure(), caption)?
        ))
    };
    let each = all.iter().enumerate().map(one).collect::<Result<String, Error>>()?;
    Ok(Section::new("pictures", "Pictures", each))
}
