//! The parts of the page that are text and tables.

use super::data::{Fit, prefix};
use super::escape::text;
use super::markup::{Section, table};
use super::words::{estimate, fit_percent, interval, nominal, number, p_value, title};
use super::{MapPlot, PlotData};
use crate::report::text::{fall, per_cent};
use crate::report::{Answer, EffectAnswer, shown};

/// Every effect of the best model: what it is, its values, why it is believed.
pub(super) fn effects(answer: &Answer) -> Option<Section> {
    if answer.effects.is_empty() {
        return None;
    }
    let each: String = answer.effects.iter().map(effect).collect();
    Some(Section::new("effects", "What is missing", each))
}

fn effect(effect: &EffectAnswer) -> String {
    let rows = effect.parameters.iter().map(|p| {
        let (id, nominal) = (format!("<code>{}</code>", text(&p.id)), nominal(p).unwrap_or_default());
        vec![id, estimate(p), interval(p), nominal, text(shown(&p.unit)).to_string()]
    });
    let head = ["parameter", "value", "95 % interval", "nominal", "unit"];
    let values = table("Values in the improved model", &head, rows.collect());
    let evidence = &effect.evidence;
    let because = format!(
        "<p class=\"quiet\">Accounts for up to {} % of the held-out error without it; p {} after correction for everything \
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

/// How large the residual is before and after, beside the noise, and how much of the motion is predicted.
pub(super) fn fit(answer: &Answer, plot: &PlotData) -> Section {
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
    Section::new("fit", "How well it fits", format!("{table}{floor}{}", predicted(plot)))
}

/// The fit in per cent, recording by recording.
fn predicted(plot: &PlotData) -> String {
    let row = |recording: &super::data::RecordingPlot| {
        let Fit { nominal, improved, noise } = recording.fit;
        let role = if recording.held_out { "held out" } else { "fitted" };
        let mut row = vec![text(&recording.name), role.to_owned(), fit_percent(nominal)];
        row.extend(improved.map(fit_percent));
        row.push(fit_percent(noise));
        row
    };
    let mut head = vec!["recording", "data", "nominal"];
    head.extend(plot.recordings.iter().any(|one| one.fit.improved.is_some()).then_some("improved"));
    head.push("noise alone");
    let caption = "Fit: share of what a steady speed leaves of the motion within a window that the model predicts, rms";
    let table = table(caption, &head, plot.recordings.iter().map(row).collect());
    format!(
        "{table}<p class=\"quiet\">0 % is no better than a rotor that keeps its speed, 100 % leaves nothing; a model that does harm \
         is below 0.</p>"
    )
}

/// The picture at the top: what both models leave of one recording, and the answer's figures beside it.
pub(super) fn picture(answer: &Answer, plot: &PlotData) -> String {
    let Some(recording) = plot.recordings.get(plot.first) else { return String::new() };
    let role = if recording.held_out { ", which nothing was fitted to" } else { "" };
    let after = recording.fit.improved.map_or_else(String::new, |fit| {
        let held = fall(answer.fit.heldout_before_rms, answer.fit.heldout_after_rms);
        format!(", the improved one {}; held-out error {} % less", fit_percent(fit), per_cent(held))
    });
    format!(
        "<figure id=\"picture\"><figcaption>What the models leave of {}{role}. The nominal model predicts {} of the \
         motion{after}.</figcaption><div class=\"picture\"></div></figure>\n",
        text(&recording.name),
        fit_percent(recording.fit.nominal)
    )
}

/// Places for the curves, which the script fills, and what each shows.
pub(super) fn curves(plot: &PlotData) -> Section {
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
         that period is a steady error and no vibration. Shaded upright: the spans of the table below; shaded along the residuals, \
         which have a scale each: where 95 % of them would be, were noise alone left. By keyboard, on a picture: arrows move, + and \
         − zoom, 0 shows the whole.</p>{}",
        1e3 * plot.window_s,
        each.collect::<String>()
    );
    Section::new("curves", "Recorded, nominal and improved", body)
}

/// Where the nominal model fails in time and state.
pub(super) fn located(answer: &Answer, plot: &PlotData) -> Option<Section> {
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
    (!body.is_empty()).then(|| Section::new("located", "Where the nominal model fails", body))
}

fn share(share: f64) -> String {
    let percent = per_cent(share.clamp(0.0, 1.0));
    format!("<span class=\"bar\" style=\"--share:{percent}%\">{percent} %</span>")
}

/// Maps of the residual torque, each with its figures.
pub(super) fn maps(plot: &PlotData) -> Option<Section> {
    let each: String = plot.maps.iter().enumerate().map(|(index, map)| self::map(index, map)).collect();
    if each.is_empty() {
        return None;
    }
    let body = format!(
        "<p class=\"quiet\">Mean residual {} ({}) of the windows of {:.0} ms, with its 95 % band: stretches of one second count \
         once, of 0.2 s over time. What the improved model takes away lies between the two.</p><div \
         class=\"grid\">{each}</div>",
        text(plot.effort_name),
        text(plot.effort_unit),
        1e3 * plot.window_s
    );
    Some(Section::new("maps", &format!("Residual {} over state and time", plot.effort_name), body))
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
pub(super) fn left(answer: &Answer) -> Option<Section> {
    let left = answer.remainder.as_ref()?;
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
    Some(Section::new("left", "What is left", body))
}

/// What was tried and not taken.
pub(super) fn rejected(answer: &Answer) -> Option<Section> {
    let rows =
        answer.rejected.iter().map(|effect| vec![format!("<code>{}</code>", text(&effect.id)), text(&effect.why)]);
    let rows: Vec<_> = rows.collect();
    if rows.is_empty() {
        return None;
    }
    let body = table("Effects that were tried and not taken", &["effect", "why not"], rows);
    Some(Section::new("rejected", "What was rejected", body))
}

/// What to record next.
pub(super) fn experiment(answer: &Answer) -> Option<Section> {
    let experiment = answer.experiment.as_ref()?;
    let apart: Vec<String> = experiment.separates.iter().map(|id| format!("<code>{}</code>", text(id))).collect();
    let apart = if apart.is_empty() { String::new() } else { format!("<p>Tells apart {}.</p>", apart.join(", ")) };
    let file = experiment.reference_csv.as_ref();
    let file = file.map_or_else(String::new, |file| format!("<p>Reference to play: <code>{}</code></p>", text(file)));
    Some(Section::new("next", "What to record next", format!("<p>{}</p>{apart}{file}", text(&experiment.text))))
}

/// What the reader should know before believing what follows.
pub(crate) fn warnings(warnings: &[String]) -> Option<Section> {
    if warnings.is_empty() {
        return None;
    }
    let each: String = warnings.iter().map(|warning| format!("<li>{}</li>", text(warning))).collect();
    Some(Section::new("warnings", "Before you believe this", format!("<ul>{each}</ul>")))
}
