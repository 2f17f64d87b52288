//! The parts of the page that are text and tables.

use super::data::prefix;
use super::escape::text;
use super::words::{estimate, interval, number, p_value, title};
use super::{MapPlot, PlotData};
use crate::output::{Input, Provenance};
use crate::report::text::{fall, per_cent};
use crate::report::{Answer, EffectAnswer};

/// Every effect of the best model: what it is, its values, why it is believed or that it is not.
pub(super) fn effects(answer: &Answer) -> String {
    if answer.effects.is_empty() {
        return String::new();
    }
    let each: String = answer.effects.iter().map(effect).collect();
    if answer.verdict.believes_its_effects() {
        return section("effects", "What is missing", &each);
    }
    let note = "<p class=\"note\">The best that the vocabulary does with these recordings. Something is left beside it that these \
                values may only stand in for: do not put them into a model.</p>";
    section("effects", "Fitted, but not believed", &format!("{note}{each}"))
}

fn effect(effect: &EffectAnswer) -> String {
    let rows = effect
        .parameters
        .iter()
        .map(|p| vec![format!("<code>{}</code>", text(&p.id)), estimate(p), interval(p), text(&p.unit)]);
    let values =
        table("Values in the improved model", &["parameter", "value", "95 % interval", "unit"], rows.collect());
    let evidence = &effect.evidence;
    let because = format!(
        "<p class=\"quiet\">Held-out error up to {} % less with it than without it; p {} after correction for everything \
         tried.</p>",
        per_cent(evidence.heldout_gain),
        text(&p_value(evidence.p_value)),
    );
    let others: Vec<String> = effect.equivalent.iter().map(|id| format!("<code>{}</code>", text(id))).collect();
    let others = if others.is_empty() {
        String::new()
    } else {
        format!("<p class=\"note\">These recordings cannot tell it from {}.</p>", others.join(", "))
    };
    let nuisances: Vec<String> = effect.nuisances.iter().map(|one| text(one).to_string()).collect();
    let others = if nuisances.is_empty() {
        others
    } else {
        format!("{others}<p class=\"note\">As good, and no effect of a machine: {}.</p>", nuisances.join("; "))
    };
    let event = effect.recording.as_ref().map_or_else(String::new, |name| format!(" in {}", text(name)));
    let (heading, id) = (text(&title(&effect.id)), text(&effect.id));
    let values = if effect.parameters.is_empty() { String::new() } else { values };
    format!(
        "<article><h3>{heading}{event} <code>{id}</code></h3><p>{}</p>{values}{others}{because}</article>",
        text(&effect.text)
    )
}

/// How large the residual is before and after, beside the noise.
pub(super) fn fit(answer: &Answer) -> String {
    let fit = &answer.fit;
    let (prefix, factor) = prefix(fit.before_rms.max(fit.heldout_before_rms));
    let row = |name: &str, before: f64, after: f64, floor: f64| {
        let less = per_cent(fall(before, after));
        let [before, after, floor] = [before, after, floor].map(|rms| number(rms * factor, 0.0));
        vec![name.to_owned(), before, after, format!("{less} %"), floor]
    };
    let rows = vec![
        row("fitted", fit.before_rms, fit.after_rms, fit.noise_floor_rms),
        row("held out", fit.heldout_before_rms, fit.heldout_after_rms, fit.heldout_floor_rms),
    ];
    let unit = format!("{prefix}{}", fit.unit);
    let caption = format!("Recorded less simulated position, rms in {unit}, windows of {:.0} ms", 1e3 * fit.horizon_s);
    let table = table(&caption, &["data", "nominal", "improved", "less", "noise alone"], rows);
    let floor = format!(
        "<p class=\"quiet\">The improved model explains {} % of the excess over the noise.</p>",
        per_cent(fit.excess_explained)
    );
    section("fit", "How well it fits", &format!("{table}{floor}"))
}

/// Places for the curves, which the script fills, and what each shows.
pub(super) fn curves(plot: &PlotData) -> String {
    let each = plot.recordings.iter().enumerate().map(|(index, recording)| {
        let role = if recording.held_out { "held out" } else { "fitted" };
        let drawn = recording.t_s.at.len();
        let thinned = if drawn < recording.rows {
            format!(" {drawn} of {} rows are drawn, among them every peak.", recording.rows)
        } else {
            String::new()
        };
        // A page of many recordings opens quickly when only the first are drawn at once.
        let open = if index < 3 { " open" } else { "" };
        format!(
            "<details class=\"recording\" data-index=\"{index}\"{open}><summary><h3>{}</h3> <span class=\"quiet\">{role}.\
             {thinned}</span></summary><div class=\"curves\"></div></details>",
            text(&recording.name)
        )
    });
    let body = format!(
        "<p class=\"quiet\">Drag over a stretch to zoom, double-click for the whole; point for values; a name in the legend \
         hides its curve. The models run in windows of {:.0} ms, each from its best start, so a residual that repeats at \
         that period is a steady error and no vibration; shaded spans are those of the table below.</p>{}",
        1e3 * plot.window_s,
        each.collect::<String>()
    );
    section("curves", "Recorded, nominal and improved", &body)
}

/// Where the nominal model fails in time and state.
pub(super) fn located(answer: &Answer, plot: &PlotData) -> String {
    let mut body = String::new();
    let spans = answer.locations.iter().map(|location| {
        let index = plot.recordings.iter().position(|recording| recording.name == location.recording);
        let (start, end) = (location.start_s, location.end_s);
        let show = index.map_or_else(String::new, |index| {
            format!(
                "<button type=\"button\" class=\"show\" data-index=\"{index}\" data-start=\"{start}\" data-end=\"{end}\" \
                 aria-label=\"Show {start:.2} to {end:.2} s of {}\">show</button>",
                text(&location.recording)
            )
        });
        let span = format!("{start:.2} to {end:.2}");
        vec![text(&location.recording), span, share(location.share), text(&location.text), show]
    });
    let spans: Vec<_> = spans.collect();
    if !spans.is_empty() {
        let head = ["recording", "time (s)", "share of the excess", "what happens there", ""];
        body += &table("Spans of time in which the nominal model fails most", &head, spans);
    }
    let regions = answer.regions.iter().map(|region| {
        let width = region.high - region.low;
        let range = format!("{} to {}", number(region.low, width / 10.0), number(region.high, width / 10.0));
        vec![format!("<code>{}</code>", text(&region.channel)), range, share(region.share)]
    });
    let regions: Vec<_> = regions.collect();
    if !regions.is_empty() {
        let head = ["channel", "range", "share of the excess"];
        body += &table("Ranges of state in which the nominal model fails most", &head, regions);
    }
    if body.is_empty() { body } else { section("located", "Where the nominal model fails", &body) }
}

fn share(share: f64) -> String {
    let percent = per_cent(share.clamp(0.0, 1.0));
    format!("<span class=\"bar\" style=\"--share:{percent}%\">{percent} %</span>")
}

/// Maps of the residual torque, each with its figures.
pub(super) fn maps(plot: &PlotData) -> String {
    let each: String = plot.maps.iter().enumerate().map(|(index, map)| self::map(index, map)).collect();
    if each.is_empty() {
        return String::new();
    }
    let body = format!(
        "<p class=\"quiet\">Mean residual {} ({}) of the windows of {:.0} ms, with its 95 % band: stretches of one second count \
         once, of 0.2 s over time. What the improved model takes away lies between the two.</p><div \
         class=\"grid\">{each}</div>",
        text(plot.effort_name),
        text(plot.effort_unit),
        1e3 * plot.window_s
    );
    section("maps", &format!("Residual {} over state and time", plot.effort_name), &body)
}

fn map(index: usize, map: &MapPlot) -> String {
    let cell = |band: &super::Band, bin: usize| {
        let half = band.half[bin].map_or_else(String::new, |half| format!(" \u{b1} {}", number(half, half)));
        format!("{}{half}", number(band.mean[bin], band.half[bin].unwrap_or(0.0)))
    };
    let rows = (0..map.x.len()).map(|bin| {
        let mut row = vec![number(map.x[bin], 0.0), cell(&map.before, bin)];
        row.extend(map.after.as_ref().map(|after| cell(after, bin)));
        row
    });
    let mut head = vec![map.x_label.as_str(), "nominal"];
    head.extend(map.after.as_ref().map(|_| "improved"));
    let figures = table(&map.y_label, &head, rows.collect());
    format!(
        "<figure><figcaption>{}</figcaption><div class=\"map\" data-index=\"{index}\"></div><details><summary>Figures\
         </summary>{figures}</details></figure>",
        text(&map.title)
    )
}

/// What the best model leaves, and what predicts it.
pub(super) fn left(answer: &Answer) -> String {
    let Some(left) = &answer.remainder else { return String::new() };
    let unit = text(&left.unit);
    let mut body = format!(
        "<p>The noise has to stand in for {} {unit} rms, some of which the values above may have absorbed.</p>",
        number(left.effort_rms, 0.0)
    );
    if !left.unnamed.is_empty() {
        let ids: Vec<String> = left.unnamed.iter().map(|id| format!("<code>{}</code>", text(id))).collect();
        body += &format!("<p>Traces of {}, too small to be named.</p>", ids.join(", "));
    }
    let rows: Vec<_> = left
        .predictors
        .iter()
        .map(|one| {
            let size = one.effort_rms.map_or_else(String::new, |rms| format!("{} {unit}", number(rms, 0.0)));
            vec![format!("<code>{}</code>", text(&one.channel)), share(one.share), size, text(&p_value(one.p_value))]
        })
        .collect();
    if !rows.is_empty() {
        let head = ["channel", "share of the squares", "rms", "p"];
        body += &table("Channels that predict part of it", &head, rows);
    }
    section("left", "What is left", &body)
}

/// What was tried and not taken.
pub(super) fn rejected(answer: &Answer) -> String {
    let rows =
        answer.rejected.iter().map(|effect| vec![format!("<code>{}</code>", text(&effect.id)), text(&effect.why)]);
    let rows: Vec<_> = rows.collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = ["effect", "why not"];
    section("rejected", "What was rejected", &table("Effects that were tried and not taken", &head, rows))
}

/// What to record next.
pub(super) fn experiment(answer: &Answer) -> String {
    let Some(experiment) = &answer.experiment else { return String::new() };
    let apart: Vec<String> = experiment.separates.iter().map(|id| format!("<code>{}</code>", text(id))).collect();
    let apart = if apart.is_empty() { String::new() } else { format!("<p>Tells apart {}.</p>", apart.join(", ")) };
    let file = experiment.reference_csv.as_ref();
    let file = file.map_or_else(String::new, |file| format!("<p>Reference to play: <code>{}</code></p>", text(file)));
    section("next", "What to record next", &format!("<p>{}</p>{apart}{file}", text(&experiment.text)))
}

/// What made the page.
pub(super) fn provenance(made: &Provenance) -> String {
    let input = |input: &Input| {
        let sha256 = input.sha256.as_deref().unwrap_or("read once, not hashed");
        vec![format!("<code>{}</code>", text(&input.file)), format!("<code>{}</code>", text(sha256))]
    };
    let files = table("Files that were read", &["file", "SHA-256"], made.inputs.iter().map(input).collect());
    let seed = made.seed.map_or_else(String::new, |seed| format!(", random draws from seed {seed}"));
    let body = format!(
        "<p>{} on {}, built from commit <code>{}</code>{seed}.</p><p><code>{}</code></p>{files}",
        text(&made.written_by),
        text(&made.date),
        text(&made.commit),
        text(&made.command)
    );
    section("provenance", "What made this page", &body)
}

/// What the reader should know before believing the answer.
pub(super) fn warnings(answer: &Answer) -> String {
    if answer.warnings.is_empty() {
        return String::new();
    }
    let each: String = answer.warnings.iter().map(|warning| format!("<li>{}</li>", text(warning))).collect();
    section("warnings", "Before you believe this", &format!("<ul>{each}</ul>"))
}

fn section(id: &str, heading: &str, body: &str) -> String {
    format!("<section aria-labelledby=\"{id}\"><h2 id=\"{id}\">{}</h2>{body}</section>\n", text(heading))
}

/// A table; captions and headings are text, cells are markup.
fn table(caption: &str, head: &[&str], rows: Vec<Vec<String>>) -> String {
    let head: String = head.iter().map(|cell| format!("<th scope=\"col\">{}</th>", text(cell))).collect();
    let row = |cells: Vec<String>| {
        let mut cells = cells.into_iter();
        let first = cells.next().unwrap_or_default();
        let rest: String = cells.map(|cell| format!("<td>{cell}</td>")).collect();
        format!("<tr><th scope=\"row\">{first}</th>{rest}</tr>")
    };
    let rows: String = rows.into_iter().map(row).collect();
    format!(
        "<div class=\"table\"><table><caption>{}</caption><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>",
        text(caption)
    )
}
