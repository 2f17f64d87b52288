//! What the tuning found: text, picture, machine file.

use std::fmt::Write;
use std::path::PathBuf;

use plant::{FluidResponse, Model};

use super::search::{Candidate, SEED, Tuning};
use super::series::LARGEST_GAIN;
use super::trial::config_for;
use super::{PEAK_NM_S_RAD, Task};
use crate::plot::{Figure, Mark, Panel, Series};
use recording::{Axis, AxisKind, ErNominal, Machine, PlantNominal};

/// A page for a terminal. Writing to a string cannot fail, so the results of `writeln!` are dropped.
#[must_use]
pub fn summary(task: &Task, tuning: &Tuning) -> String {
    let mut text = String::new();
    let (range, demands) = (&tuning.range, &task.demands);
    let percent = 100.0 * range.uncertainty;
    if tuning.short_of_peak {
        let alone = task.range(PEAK_NM_S_RAD).unstable_alone_nm_s_rad().map_or(String::new(), |q1| {
            format!(" (a fluid this late makes\nthe damper of the linear loop unstable by itself above Q1 {q1:.1})")
        });
        let _ = writeln!(
            text,
            "No gains keep these margins up to the peak of (5), Q {PEAK_NM_S_RAD} N m s/rad{alone}.\nThey are kept up \
             to the Q1 below; above it stand the nonlinear runs and the harmonic balance.\n"
        );
    }
    let _ = writeln!(
        text,
        "Kept for every L of {:.2} ms +-{percent:.0} % (and {:.2} ms for hold and speed estimate), {}, Q1 0 to {} N m s/rad:",
        1e3 * range.torque_delay_s,
        1e3 * range.law_delay_s,
        fluid(range.fluid_s, percent),
        range.q1_nm_s_rad
    );
    let _ = writeln!(
        text,
        "  phase margin {} degrees, gain margin {}, delay margin {} L\n",
        demands.phase_deg, demands.gain, demands.delay_share
    );
    candidate_lines(&mut text, "tuned, with all delays tried", task, &tuning.best);
    candidate_lines(&mut text, "paper, with the nominal delays", task, &tuning.paper);
    let _ = writeln!(text, "the paper's gains stay stable up to +-{:.0} % of every delay", 100.0 * tuning.paper_bears);
    let (draws, unstable) = tuning.draws;
    let _ = writeln!(text, "root counting: {unstable} of {draws} loops drawn within the range unstable (seed {SEED})");
    let cycles = tuning.limit_cycles;
    let _ = writeln!(text, "harmonic balance: {cycles} limit cycles, delays nominal and all off by the uncertainty");
    trade_off_lines(&mut text, tuning);
    text
}

fn trade_off_lines(text: &mut String, tuning: &Tuning) {
    let _ = writeln!(text, "{} pairs of gains judged\n\nlevel   mean settling   K_p*     K_d*", tuning.judged);
    for (level, candidate) in &tuning.trade_off {
        let _ = match candidate.as_ref().and_then(|found| Some((found.worth()?, found.normalised))) {
            Some((worth, gains)) => {
                writeln!(text, "{level:<7} {:>8.2} ms    {:.4}   {:.4}", 1e3 * worth.1, gains.kp, gains.kd)
            }
            None => writeln!(text, "{level:<7} not kept by any gains that settle"),
        };
    }
}

fn fluid(fluid_s: Option<(f64, f64)>, percent: f64) -> String {
    match fluid_s {
        None => "no damper".to_owned(),
        Some((dead_s, lag_s)) => {
            format!("dead time {:.2} and lag {:.2} ms of the fluid +-{percent:.0} %", 1e3 * dead_s, 1e3 * lag_s)
        }
    }
}

fn candidate_lines(text: &mut String, name: &str, task: &Task, candidate: &Candidate) {
    let (gains, normalised) = (candidate.gains, candidate.normalised);
    let _ = writeln!(
        text,
        "{name}:\n  K_P {:.3} N m/rad, K_D {:.4} N m s/rad (K_p* {:.4}, K_d* {:.4}), near {:.4} rad",
        gains.k_p_nm_rad,
        gains.k_d_nm_s_rad,
        normalised.kp,
        normalised.kd,
        config_for(&task.config, gains, &task.model, task.uncertainty).near_rad
    );
    let _ = match &candidate.guarantee {
        Some(kept) => writeln!(
            text,
            "  keeps {:.2} of the margins: phase {} degrees, gain {}, delay {} ms; least at L {:.2}, dead time \
             {:.2}, lag {:.2} ms, Q1 {:.1}",
            kept.level,
            margin(kept.phase_deg, 1, "any"),
            margin(kept.gain, 2, &format!("over {LARGEST_GAIN}")),
            margin(1e3 * kept.delay_s, 2, "any"),
            1e3 * kept.worst.torque_delay_s,
            1e3 * kept.worst.dead_time_s,
            1e3 * kept.worst.lag_s,
            kept.worst.q1_nm_s_rad
        ),
        None => writeln!(text, "  keeps nothing: unstable somewhere in the range"),
    };
    trial_line(text, task, candidate);
}

/// A margin with these decimals; in words where nothing of the kind loses the loop.
fn margin(value: f64, decimals: usize, unbounded: &str) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { unbounded.to_owned() }
}

fn trial_line(text: &mut String, task: &Task, candidate: &Candidate) {
    let _ = match &candidate.trial {
        Some(trial) => writeln!(
            text,
            "  settles {:.1} ms ({:.0} mrad), {:.1} ms ({:.0} mrad); overshoot at most {:.2} %; rests within {:.2} mrad; 8 N m \
             push moves it {:.1} mrad\n",
            1e3 * trial.settling_s[0],
            1e3 * task.steps.large_rad,
            1e3 * trial.settling_s[1],
            1e3 * task.steps.small_rad,
            100.0 * trial.overshoot,
            1e3 * task.model.coulomb / candidate.gains.k_p_nm_rad,
            1e3 * trial.push_rad
        ),
        None => writeln!(text, "  does not settle, or overshoots too far, with some delays of the range\n"),
    };
}

/// A point of a figure, in the units of its axes.
type Point = (f64, f64);

/// Settling over kept margins, and the gains.
#[must_use]
pub fn figure(tuning: &Tuning) -> Figure {
    let best: Vec<&Candidate> = tuning.trade_off.iter().filter_map(|(_, found)| found.as_ref()).collect();
    let curve: Vec<Point> =
        best.iter().filter_map(|found| found.worth()).map(|(level, cost_s)| (level, 1e3 * cost_s)).collect();
    let along: Vec<Point> = best.iter().map(|found| place(found)).collect();
    // Gains that keep nothing stand at level 0, where the loop is lost.
    let judged = |candidate: &Candidate| {
        let level = candidate.guarantee.map_or(0.0, |kept| kept.level);
        Some((level, 1e3 * candidate.trial?.cost_s()))
    };
    let panel = |x: &str, y: &str, line: Vec<Point>, tuned: Option<Point>, paper: Option<Point>| {
        let points: Vec<Point> = line.iter().copied().chain(tuned).chain(paper).collect();
        let size = half_size(&points);
        let mut series = vec![Series::new("best for each level", Mark::Line, line)];
        series.extend(tuned.map(|point| Series::cross("tuned", point, size)));
        series.extend(paper.map(|point| Series::cross("paper", point, size)));
        Panel::new(x, y, series)
    };
    let (tuned, paper) = (&tuning.best, &tuning.paper);
    Figure {
        title: "Settling against margins kept over the uncertainty".to_owned(),
        panels: vec![
            panel(
                "least margin over the one demanded (1)",
                "mean settling time (ms)",
                curve,
                judged(tuned),
                judged(paper),
            ),
            panel("K_p* = K_P L^2 / J (1)", "K_d* = K_D L / J (1)", along, Some(place(tuned)), Some(place(paper))),
        ],
    }
}

fn place(candidate: &Candidate) -> Point {
    (candidate.normalised.kp, candidate.normalised.kd)
}

/// Half the size of a cross among points: a hundredth and a thirtieth of what they span.
fn half_size(points: &[Point]) -> Point {
    let span = |value: fn(&Point) -> f64| {
        let values = points.iter().map(value);
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
    };
    (0.01 * span(|point| point.0), 0.03 * span(|point| point.1))
}

/// The machine with the tuned parameters, as a machine file has it: its section `[controller]` is what the firmware
/// takes. Of the machine only what a machine file can say is kept; a delay of Q stands there as one of E.
#[must_use]
pub fn machine(task: &Task, tuning: &Tuning, read: Option<Machine>) -> Machine {
    let controller = Some(config_for(&task.config, tuning.best.gains, &task.model, task.uncertainty));
    let mut plant = nominal(&task.model, read.as_ref().map_or(0.0, |machine| machine.plant.sample_to_output_s));
    if let (Some(er), Some(read)) = (&mut plant.er, read.as_ref().and_then(|machine| machine.plant.er.as_ref())) {
        er.fluid = read.fluid.clone();
    }
    match read {
        Some(machine) => Machine { plant, controller, ..machine },
        None => Machine {
            file: PathBuf::new(),
            name: "er-dd-servo".to_owned(),
            axis: Axis {
                kind: AxisKind::Rotary,
                // The decimal number the single-precision one stands for.
                sample_period_s: (f64::from(task.config.period_s) * 1e9).round() * 1e-9,
                resolution: std::f64::consts::TAU / f64::from(er_servo::COUNTS_PER_REV),
            },
            plant,
            controller,
            columns: Default::default(),
            effects: Vec::new(),
        },
    }
}

/// The delays of a model count from the sample, those of a machine file from the outputs.
fn nominal(model: &Model, sample_to_output_s: f64) -> PlantNominal {
    let from_output_s = |delay_s: f64| (delay_s - sample_to_output_s).max(0.0);
    PlantNominal {
        inertia: model.inertia,
        coulomb: model.coulomb,
        viscous: model.viscous,
        torque_gain: model.torque_gain,
        torque_offset: model.torque_offset,
        torque_limit: model.torque_limit,
        sample_to_output_s,
        torque_delay_s: from_output_s(model.torque_delay_s),
        er: model.er.as_ref().map(|er| {
            let (dead_time_s, lag_s) = match er.response {
                FluidResponse::Field(field) => (field.dead_time_s, field.rise_s),
                FluidResponse::ViscosityDeadTime { dead_time_s, .. } => (dead_time_s, 0.0),
                FluidResponse::ViscosityLag { lag_s, .. } => (0.0, lag_s),
            };
            ErNominal { a: er.a, b: er.b, dead_time_s: from_output_s(dead_time_s), lag_s, fluid: None }
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_that_nothing_loses_is_said_in_words() {
        assert_eq!(margin(1.234, 2, "any"), "1.23");
        assert_eq!(margin(f64::INFINITY, 2, "over 10"), "over 10");
    }
}
