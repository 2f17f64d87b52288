//! What tuning found as a page.

use super::Tuned;
use crate::Error;
use crate::output::Provenance;
use crate::report::html::{Page, Section, badge, figure, number, picture, plain, short, text};
use crate::tune::search::SEED;
use crate::tune::trial::config_for;
use crate::tune::{Candidate, PEAK_NM_S_RAD, Task, Tuning};

/// The page, with the machine file it goes with, and what made it.
///
/// # Errors
/// What the drawing library says.
pub(super) fn page(task: &Task, tuned: &Tuned, file: &str, made: &Provenance) -> Result<String, Error> {
    let tuning = &tuned.tuning;
    let mut panels = crate::tune::figure(tuning);
    // The settling is seen first, the gains under their table.
    let gains = panels.panels.pop();
    let caption = "The shortest mean settling for each level of margin that is kept; level 1 keeps every demand.";
    let mut body = candidates(task, tuning);
    if let Some(panel) = gains {
        let drawing = crate::plot::Figure { title: "Gains".to_owned(), panels: vec![panel] };
        body += &figure(&drawing, "The gains along the same curve, scaled with the machine's L and J.")?;
    }
    let sections = [
        short_of_peak(task, tuning),
        Some(Section::new("gains", "The gains, beside the paper's", body)),
        Some(demands(task, tuning)),
        Some(trade_off(tuning)),
        Some(checks(tuning)),
        Some(Section::new("file", "The machine file", format!("<p>The gains are in <code>{}</code>.</p>", text(file)))),
    ];
    let page = Page {
        title: "Tuned gains".to_owned(),
        about: format!("Gains for {}", tuned.machine.name),
        heading: badge("good", "tuned") + &text(&sentence(tuning)),
        picture: picture(&panels, caption)?,
        sections: sections.into_iter().flatten().collect(),
        script: None,
    };
    Ok(page.html(made))
}

/// A computed figure, which has no interval: four digits; in words where nothing of the kind loses the loop.
fn margin(value: f64, unbounded: &str) -> String {
    if value.is_finite() { number(value, 0.0) } else { unbounded.to_owned() }
}

fn sentence(tuning: &Tuning) -> String {
    let gains = tuning.best.gains;
    let settles = tuning.best.trial.map_or_else(String::new, |trial| {
        let [large, small] = trial.settling_s.map(|settling_s| number(1e3 * settling_s, 0.0));
        format!("; the large step settles in {large} ms, the small one in {small} ms")
    });
    format!(
        "K_P {} N m/rad and K_D {} N m s/rad keep every margin over every delay within its uncertainty{settles}.",
        number(gains.k_p_nm_rad, 0.0),
        number(gains.k_d_nm_s_rad, 0.0)
    )
}

fn short_of_peak(task: &Task, tuning: &Tuning) -> Option<Section> {
    let alone = task.range(PEAK_NM_S_RAD).unstable_alone_nm_s_rad().map_or_else(String::new, |q1| {
        format!(
            " A fluid this late makes the damper of the linear loop unstable by itself above Q1 {} N m s/rad.",
            number(q1, 0.0)
        )
    });
    let body = format!(
        "<p>No gains keep these margins up to the peak of (5), Q {PEAK_NM_S_RAD} N m s/rad.{alone} They are kept up to Q1 {} N m \
         s/rad; above it stand the nonlinear runs and the harmonic balance.</p>",
        short(tuning.range.q1_nm_s_rad)
    );
    tuning.short_of_peak.then(|| Section::new("warnings", "Before you believe this", body))
}

fn demands(task: &Task, tuning: &Tuning) -> Section {
    let (range, demands) = (&tuning.range, &task.demands);
    let percent = format!("\u{b1}{} %", short(100.0 * range.uncertainty));
    let (dead, lag) = range.fluid_s.map_or(("none".to_owned(), "none".to_owned()), |(dead_s, lag_s)| {
        (format!("{} ms {percent}", short(1e3 * dead_s)), format!("{} ms {percent}", short(1e3 * lag_s)))
    });
    let rows = [
        ("phase margin", format!("{} degrees", short(demands.phase_deg))),
        ("gain margin", short(demands.gain)),
        ("delay margin", format!("{} L", short(demands.delay_share))),
        ("for every delay of the motor L", format!("{} ms {percent}", short(1e3 * range.torque_delay_s))),
        ("and for hold and speed estimate", format!("{} ms", short(1e3 * range.law_delay_s))),
        ("for every dead time of the fluid", dead),
        ("for every lag of the fluid", lag),
        ("for every viscosity Q1", format!("0 to {} N m s/rad", short(range.q1_nm_s_rad))),
        ("overshoot at most", format!("{} %", short(100.0 * task.steps.overshoot))),
        ("settled within", format!("{} mrad", number(1e3 * task.steps.tolerance_rad, 0.0))),
    ];
    let rows = rows.map(|(what, value)| vec![what.to_owned(), value]);
    Section::new(
        "demands",
        "What was demanded",
        plain("Margins, and what they are kept for", &["demand", "value"], &rows),
    )
}

/// The tuned gains beside the paper's, line by line.
fn candidates(task: &Task, tuning: &Tuning) -> String {
    let both = [figures(task, &tuning.best), figures(task, &tuning.paper)];
    let rows = LINES.iter().zip(&both[0]).zip(&both[1]);
    let rows: Vec<Vec<String>> =
        rows.map(|((line, tuned), paper)| vec![(*line).to_owned(), tuned.clone(), paper.clone()]).collect();
    let head = ["figure", "tuned, with all delays tried", "paper, with the nominal delays"];
    plain("What each pair of gains keeps, and does", &head, &rows)
}

/// The lines of the table of gains.
const LINES: [&str; 15] = [
    "K_P (N m/rad)",
    "K_D (N m s/rad)",
    "K_p* (1)",
    "K_d* (1)",
    "brake within (rad)",
    "least margin over the one demanded (1)",
    "phase margin (degrees)",
    "gain margin (1)",
    "delay margin (ms)",
    "least at L, dead time, lag (ms), Q1 (N m s/rad)",
    "settling of the large step (ms)",
    "settling of the small step (ms)",
    "overshoot (%)",
    "rests within (mrad)",
    "moved by a push of 8 N m (mrad)",
];

fn figures(task: &Task, candidate: &Candidate) -> [String; LINES.len()] {
    let four = |value: f64| number(value, 0.0);
    let (gains, normalised) = (candidate.gains, candidate.normalised);
    let near_rad = config_for(&task.config, gains, &task.model, task.uncertainty).near_rad;
    let [level, phase, gain, delay, worst] = match &candidate.guarantee {
        Some(kept) => {
            let at = &kept.worst;
            let delays = [at.torque_delay_s, at.dead_time_s, at.lag_s].map(|delay_s| short(1e3 * delay_s)).join(", ");
            [
                four(kept.level),
                margin(kept.phase_deg, "any"),
                margin(kept.gain, "more than is looked for"),
                margin(1e3 * kept.delay_s, "any"),
                format!("{delays}, {}", short(at.q1_nm_s_rad)),
            ]
        }
        None => ["0: unstable somewhere", "none", "none", "none", ""].map(str::to_owned),
    };
    let [large, small, overshoot, push] = match &candidate.trial {
        Some(trial) => {
            let [large_s, small_s] = trial.settling_s;
            [1e3 * large_s, 1e3 * small_s, 100.0 * trial.overshoot, 1e3 * trial.push_rad].map(four)
        }
        None => ["does not settle", "does not settle", "too far, or none", "not run"].map(str::to_owned),
    };
    let [kp, kd] = [four(gains.k_p_nm_rad), four(gains.k_d_nm_s_rad)];
    let rests = four(1e3 * task.model.coulomb / gains.k_p_nm_rad);
    let scaled = [four(normalised.kp), four(normalised.kd), four(f64::from(near_rad))];
    let [kp_star, kd_star, near] = scaled;
    [kp, kd, kp_star, kd_star, near, level, phase, gain, delay, worst, large, small, overshoot, rests, push]
}

fn trade_off(tuning: &Tuning) -> Section {
    let rows = tuning.trade_off.iter().map(|(level, candidate)| {
        let level = level.to_string();
        match candidate.as_ref().and_then(|found| Some((found.worth()?, found.normalised))) {
            Some((worth, gains)) => {
                vec![level, number(1e3 * worth.1, 0.0), number(gains.kp, 0.0), number(gains.kd, 0.0)]
            }
            None => vec![level, "not kept by any gains that settle".to_owned(), String::new(), String::new()],
        }
    });
    let rows: Vec<_> = rows.collect();
    let caption = format!("The best of {} pairs of gains for each level", tuning.judged);
    let table = plain(&caption, &["level", "mean settling (ms)", "K_p*", "K_d*"], &rows);
    Section::new("trade-off", "What a larger margin costs", table)
}

fn checks(tuning: &Tuning) -> Section {
    let (draws, unstable) = tuning.draws;
    let rows = [
        (
            "loops drawn within the range that are unstable, by root counting",
            format!("{unstable} of {draws} (seed {SEED})"),
        ),
        ("limit cycles by harmonic balance, delays nominal and all off", tuning.limit_cycles.to_string()),
        ("the paper's gains stay stable up to", format!("\u{b1}{:.0} % of every delay", 100.0 * tuning.paper_bears)),
    ];
    let rows = rows.map(|(what, value)| vec![what.to_owned(), value]);
    let caption = "By methods that the search does not use";
    Section::new("checks", "How it was checked", plain(caption, &["check", "outcome"], &rows))
}
