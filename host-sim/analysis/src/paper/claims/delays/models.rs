//! What section VI says of each delay model, as tests of one place of the scan; the joint search asks the same tests.

use crate::paper::case::Fluid;
use crate::paper::claims::claim::View;
use crate::paper::scan::Outcome;

/// Settling times this far apart are different, as a share.
const SETTLING: f64 = 0.1;
/// Overshoots this far apart are different, share of the step: the settling band.
pub(super) const OVERSHOOT: f64 = 0.02;
/// A residual over this, u, is more than dry friction holds by itself.
const STUCK_U: f64 = 1.5;
/// The field comes short below this share of the commanded torque.
const SHORT: f64 = 0.9;

/// A claim about one place of the scan.
pub(in crate::paper) struct Test {
    /// Section or figure.
    pub(in crate::paper) section: &'static str,
    /// In the paper's words, shortened.
    pub(in crate::paper) statement: &'static str,
    /// How it is tested.
    pub(in crate::paper) test: &'static str,
    /// Models whose figures are shown.
    pub(in crate::paper) show: &'static [Fluid],
    /// Whether it is true at a place.
    pub(in crate::paper) holds: fn(&View) -> bool,
}

/// All of them, in the order of the paper.
pub(in crate::paper) const TESTS: [Test; 12] = [
    Test {
        section: "VI-A, Fig. 11",
        statement: "With the damper off the response vibrates about the reference; Fig. 11 speaks of its vibration cycle",
        test: "ER off overshoots by at least 2 % of the step",
        show: &[Fluid::Off],
        holds: |view| view.of(Fluid::Off).response.overshoot >= OVERSHOOT,
    },
    Test {
        section: "VI-A",
        statement: "Without friction the simulation hardly vibrates, so the delay models are hard to tell apart",
        test: "all models (but Q dead 50) with friction 0 and 0.763 N m: friction doubles the spread of the rest positions, \
               or adds 2 dips; the place counts with any law",
        show: &[],
        holds: friction_tells_apart,
    },
    Test {
        section: "VI-B, Fig. 12",
        statement: "A dead time of 5 ms in Q does not change the behaviour",
        test: "against no delay: overshoot within 2 % of the step, settling within 10 %, no more dips of the speed",
        show: &[Fluid::None, Fluid::QDead5],
        holds: |view| !differs(view.of(Fluid::QDead5), view.of(Fluid::None)),
    },
    Test {
        section: "VI-B, Fig. 13",
        statement: "A dead time of 50 ms in Q deteriorates the damping",
        test: "against no delay: settles more than 10 % later, or overshoots 2 % more, or more dips",
        show: &[Fluid::QDead50],
        holds: |view| worse(view.of(Fluid::QDead50), view.of(Fluid::None)),
    },
    Test {
        section: "VI-C",
        statement: "With 0 ms of dead time the models of E and of Q give the same result",
        test: "as for Fig. 12; a field held between two ticks against a viscosity held between them",
        show: &[Fluid::QNone],
        holds: |view| !differs(view.of(Fluid::QNone), view.of(Fluid::None)),
    },
    Test {
        section: "VI-C, Fig. 14",
        statement: "A dead time of 5 ms in E makes the response somewhat vibrational",
        test: "at least 2 dips of the speed more than without delay",
        show: &[Fluid::EDead5],
        holds: |view| view.of(Fluid::EDead5).response.dips >= view.of(Fluid::None).response.dips + 2,
    },
    Test {
        section: "VI-D, Fig. 15",
        statement: "A lag of 5 ms in Q differs little from the dead time, and hardly affects the response",
        test: "against Q dead 5 ms, and against no delay, each as for Fig. 12",
        show: &[Fluid::QLag5],
        holds: |view| {
            let lag = view.of(Fluid::QLag5);
            !differs(lag, view.of(Fluid::QDead5)) && !differs(lag, view.of(Fluid::None))
        },
    },
    Test {
        section: "VI-E, Fig. 16",
        statement: "A lag of 5 ms in E leaves too little damping and so a large overshoot",
        test: "overshoot at least 2 % of the step more than without delay",
        show: &[Fluid::ELag5],
        holds: |view| more_overshoot(view) >= OVERSHOOT,
    },
    Test {
        section: "VI-E",
        statement: "The slow field is insufficient in the vicinity of the reference",
        test: "torque of the lagged field over the commanded one, from the last 1.5 rad/s, or the start, until the command \
               peaks; short below 90 %",
        show: &[],
        holds: |view| view.of(Fluid::ELag5).arrival.is_some_and(|share| share < SHORT),
    },
    Test {
        section: "VI-E, Fig. 16",
        statement: "The large field leaves a large friction, and the angle cannot return to the reference",
        test: "E lag 5 ms rests further than 1.5 u = 1.5 c / K_P from the reference, half as far again as dry friction holds",
        show: &[Fluid::ELag5],
        holds: |view| view.of(Fluid::ELag5).response.residual_u.abs() > STUCK_U,
    },
    Test {
        section: "VI-E",
        statement: "The response with a lag in E is not similar to that with a lag in Q",
        test: "E lag 5 ms against Q lag 5 ms as for Fig. 12",
        show: &[Fluid::QLag5, Fluid::ELag5],
        holds: |view| differs(view.of(Fluid::ELag5), view.of(Fluid::QLag5)),
    },
    Test {
        section: "VI-F, Fig. 17",
        statement: "E dead 2 + lag 3 ms differs a little from the other models of E",
        test: "overshoot within that of E dead 5 and E lag 5 ms or 0.5 % of it, dips within theirs or one more",
        show: &[Fluid::EDead5, Fluid::ELag5, Fluid::EDead2Lag3],
        holds: lies_between,
    },
];

/// If the machine is E dead 2 + lag 3 ms, as the paper ends, its next claim can be tested without its measurements.
pub(in crate::paper) const FURTHEST: Test = Test {
    section: "VII",
    statement: "The simulation with a lag of 5 ms in E shows the largest deviation from the experiment",
    test: "taking E dead 2 + lag 3 ms for the experiment: E lag 5 ms is further from its path than no delay, Q dead 5, Q lag 5 \
           and E dead 5 ms are",
    show: &[],
    holds: |view| {
        let lag = view.of(Fluid::ELag5).from_both;
        let others = [Fluid::None, Fluid::QDead5, Fluid::QLag5, Fluid::EDead5];
        others.into_iter().all(|fluid| view.of(fluid).from_both < lag)
    },
};

/// Overshoot of E lag 5 ms over that without delay, share of the step.
pub(super) fn more_overshoot(view: &View) -> f64 {
    view.of(Fluid::ELag5).response.overshoot - view.of(Fluid::None).response.overshoot
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

fn friction_tells_apart(view: &View) -> bool {
    let with = view.cell.apart(view.reading);
    view.cell
        .apart_without_friction(view.reading)
        .is_some_and(|without| 2.0 * without.rest_rad < with.rest_rad || without.dips + 2 <= with.dips)
}

fn lies_between(view: &View) -> bool {
    let [both, dead, lag] = [Fluid::EDead2Lag3, Fluid::EDead5, Fluid::ELag5].map(|fluid| view.of(fluid).response);
    let within = |value: f64, a: f64, b: f64, spare: f64| value >= a.min(b) - spare && value <= a.max(b) + spare;
    within(both.overshoot, dead.overshoot, lag.overshoot, 0.005)
        && within(both.dips as f64, dead.dips as f64, lag.dips as f64, 1.0)
}
