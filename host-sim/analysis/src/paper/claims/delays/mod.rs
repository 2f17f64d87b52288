//! Section VI: the step responses under each delay model. What is judged over the range of the scan is here; runs made
//! for one claim are in [`apart`] and [`overshoot`].

mod apart;
mod overshoot;

use super::claim::{Claim, Where, scanned};
use crate::paper::case::{Fluid, STEP_RAD, Speed};
use crate::paper::scan::{Cell, Outcome, Scan};
use overshoot::OVERSHOOT;
use recording::Error;

/// Settling times this far apart are different, as a share.
const SETTLING: f64 = 0.1;

pub(super) fn claims(scan: &Scan) -> Result<Vec<Claim>, Error> {
    Ok(vec![
        apart::friction_shows_the_differences()?,
        q_dead_time_is_harmless(scan),
        long_dead_time_is_not(scan),
        channels_agree(scan),
        e_dead_time_vibrates(scan),
        q_lag_is_harmless(scan),
        overshoot::of_the_e_lag(scan)?,
        apart::field_comes_short()?,
        apart::cannot_return()?,
        e_lag_is_not_q_lag(scan),
        both_lie_between(scan),
        apart::experiment(),
    ])
}

/// Settling times apart by more than a tenth of the second, or one of them never.
fn settles_apart(a: &Outcome, b: &Outcome) -> bool {
    match (a.response.settling_s, b.response.settling_s) {
        (Some(a), Some(b)) => (a - b).abs() > SETTLING * b,
        (a, b) => a.is_some() != b.is_some(),
    }
}

/// Whether a response differs from another in what the eye sees: overshoot, settling, a more ragged speed.
fn differs(a: &Outcome, b: &Outcome) -> bool {
    let overshoot = (a.response.overshoot - b.response.overshoot).abs() > OVERSHOOT;
    overshoot || settles_apart(a, b) || a.response.dips > b.response.dips
}

/// Whether a response is worse than another: later by a tenth, further over, or more ragged.
fn worse(a: &Outcome, b: &Outcome) -> bool {
    let later = match (a.response.settling_s, b.response.settling_s) {
        (Some(a), Some(b)) => a > (1.0 + SETTLING) * b,
        (None, Some(_)) => true,
        (_, None) => false,
    };
    later || a.response.overshoot > b.response.overshoot + OVERSHOOT || a.response.dips > b.response.dips
}

/// Figures of a model at a place.
fn described(cell: &Cell, fluid: Fluid) -> String {
    let response = &cell.of(fluid).response;
    let settling = response.settling_s.map_or("never".to_owned(), |s| format!("{:.1} ms", s * 1e3));
    format!(
        "{}: overshoot {:.2} %, settles {settling}, residual {:.2} u, dips {}",
        fluid.name(),
        100.0 * response.overshoot,
        response.residual_u,
        response.dips
    )
}

/// The step of control.md section 7.
fn papers_step(scan: &Scan) -> impl Iterator<Item = &Cell> {
    scan.at(Speed::True, 1.0).filter(|cell| cell.point.gains_delay_s == 0.005 && cell.point.step_rad == STEP_RAD)
}

/// What a claim says, and which models its figures show.
struct Text {
    section: &'static str,
    statement: &'static str,
    test: &'static str,
    show: &'static [Fluid],
}

/// A claim that is true or not at each place of the scan with the plant as the gains assume.
fn over_the_scan(scan: &Scan, text: Text, more: Vec<String>, holds: impl Fn(&Cell) -> bool) -> Claim {
    let found = Where::of(scan.at(Speed::True, 1.0), &holds);
    let with_counts = Where::of(scan.at(Speed::Counts, 1.0), &holds);
    let mut figures: Vec<String> = Vec::new();
    for cell in papers_step(scan) {
        figures.extend(text.show.iter().map(|fluid| format!("30 degrees, L 5 ms, {}", described(cell, *fluid))));
    }
    figures.extend(more);
    figures.push(format!("true at {found} places; with the speed from counts at {with_counts}"));
    Claim {
        section: text.section,
        statement: text.statement,
        test: text.test,
        range: scanned(found.of),
        figures,
        verdict: found.verdict(),
    }
}

/// Largest distance of a model's path from the one without delay, over the range, percent of the step.
fn furthest(scan: &Scan, fluid: Fluid) -> String {
    let apart = scan.at(Speed::True, 1.0).map(|cell| cell.of(fluid).from_prompt).fold(0.0, f64::max);
    format!("{}: path up to {:.1} % of the step from the one without delay", fluid.name(), 100.0 * apart)
}

fn q_dead_time_is_harmless(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-B, Fig. 12",
        statement: "A dead time of 5 ms in Q does not change the behaviour",
        test: "against no delay: overshoot within 2 % of the step, settling within 10 %, no more dips of the speed",
        show: &[Fluid::None, Fluid::QDead5],
    };
    over_the_scan(scan, text, vec![furthest(scan, Fluid::QDead5)], |cell| {
        !differs(cell.of(Fluid::QDead5), cell.of(Fluid::None))
    })
}

fn long_dead_time_is_not(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-B, Fig. 13",
        statement: "A dead time of 50 ms in Q deteriorates the damping",
        test: "against no delay: settles more than 10 % later, or overshoots 2 % more, or more dips",
        show: &[Fluid::QDead50],
    };
    let both = [Fluid::None, Fluid::QDead50];
    let stuck = both.map(|fluid| {
        let never = scan.at(Speed::True, 1.0).filter(|cell| cell.of(fluid).response.settling_s.is_none());
        format!("{}: does not settle in the run at {} places", fluid.name(), never.count())
    });
    over_the_scan(scan, text, stuck.to_vec(), |cell| worse(cell.of(Fluid::QDead50), cell.of(Fluid::None)))
}

fn channels_agree(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-C",
        statement: "With 0 ms of dead time the models of E and of Q give the same result",
        test: "as for Fig. 12; a field held between two ticks against a viscosity held between them",
        show: &[Fluid::QNone],
    };
    over_the_scan(scan, text, vec![furthest(scan, Fluid::QNone)], |cell| {
        !differs(cell.of(Fluid::QNone), cell.of(Fluid::None))
    })
}

fn e_dead_time_vibrates(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-C, Fig. 14",
        statement: "A dead time of 5 ms in E makes the response somewhat vibrational",
        test: "at least 2 dips of the speed more than without delay",
        show: &[Fluid::EDead5],
    };
    over_the_scan(scan, text, Vec::new(), |cell| {
        cell.of(Fluid::EDead5).response.dips >= cell.of(Fluid::None).response.dips + 2
    })
}

fn q_lag_is_harmless(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-D, Fig. 15",
        statement: "A lag of 5 ms in Q differs little from the dead time, and hardly affects the response",
        test: "against Q dead 5 ms, and against no delay, each as for Fig. 12",
        show: &[Fluid::QLag5],
    };
    let near_dead = |cell: &Cell| !differs(cell.of(Fluid::QLag5), cell.of(Fluid::QDead5));
    let near_none = |cell: &Cell| !differs(cell.of(Fluid::QLag5), cell.of(Fluid::None));
    let more = vec![
        format!("as the dead time: at {} places", Where::of(scan.at(Speed::True, 1.0), near_dead)),
        format!("as without delay: at {} places", Where::of(scan.at(Speed::True, 1.0), near_none)),
        furthest(scan, Fluid::QLag5),
    ];
    over_the_scan(scan, text, more, |cell| near_dead(cell) && near_none(cell))
}

fn e_lag_is_not_q_lag(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-E",
        statement: "The response with a lag in E is not similar to that with a lag in Q",
        test: "E lag 5 ms against Q lag 5 ms as for Fig. 12",
        show: &[Fluid::ELag5],
    };
    over_the_scan(scan, text, vec![furthest(scan, Fluid::QLag5), furthest(scan, Fluid::ELag5)], |cell| {
        differs(cell.of(Fluid::ELag5), cell.of(Fluid::QLag5))
    })
}

fn both_lie_between(scan: &Scan) -> Claim {
    let text = Text {
        section: "VI-F, Fig. 17",
        statement: "E dead 2 + lag 3 ms differs a little from the other models of E",
        test: "overshoot within that of E dead 5 and E lag 5 ms or 0.5 % of it, dips within theirs or one more",
        show: &[Fluid::EDead5, Fluid::ELag5, Fluid::EDead2Lag3],
    };
    over_the_scan(scan, text, Vec::new(), |cell| {
        let [both, dead, lag] = [Fluid::EDead2Lag3, Fluid::EDead5, Fluid::ELag5].map(|fluid| cell.of(fluid).response);
        let within = |value: f64, a: f64, b: f64, spare: f64| value >= a.min(b) - spare && value <= a.max(b) + spare;
        let dips = |count: usize| f64::from(u32::try_from(count).unwrap_or(u32::MAX));
        within(both.overshoot, dead.overshoot, lag.overshoot, 0.005)
            && within(dips(both.dips), dips(dead.dips), dips(lag.dips), 1.0)
    })
}
