//! Section III-B: the damper as a brake.

use rayon::prelude::*;

use super::claim::{Claim, Verdict, trim_zeros};
use crate::paper::case::{Case, Fluid, PUSH, Speed, peak_rad};
use crate::paper::scan::GAINS_DELAYS_S;
use crate::simulate::{Disturbance, Row};
use recording::Error;

/// Pushes on the rotor at rest, N m; friction holds 0.763.
const PUSHES_NM: [f64; 4] = [2.0, 4.0, 8.0, 12.0];
/// Delay models under which the brake must still help.
const FLUIDS: [Fluid; 5] = [Fluid::None, Fluid::QDead5, Fluid::EDead5, Fluid::ELag5, Fluid::EDead2Lag3];

/// When a rotor with dry friction alone has long come to rest again, and one under the brake has not, after a push, s: the end of Fig. 19.
const LATER_S: f64 = 0.25;

/// What is left of one push.
#[derive(Clone, Copy)]
struct After {
    /// Largest distance from rest, mrad.
    peak: f64,
    /// From the end of the push until the rotor stays within 1.5 u, ms; none if it does not within the run.
    recovery_ms: Option<f64>,
    /// Distance from the reference [`LATER_S`] after the push, mrad; in the direction of the push.
    later: f64,
    /// The same at the end of the run.
    residual: f64,
}

/// One push with the field off, the damper only, damper and brake.
struct Push {
    delay_s: f64,
    push_nm: f64,
    fluid: Fluid,
    off: After,
    damper: After,
    brake: After,
}

impl Push {
    fn helps(&self) -> bool {
        self.brake.peak < 0.99 * self.damper.peak && self.damper.peak < self.off.peak
    }

    /// Back no later than with the damper alone, and no further off.
    fn recovers(&self) -> bool {
        let time = |after: &After| after.recovery_ms.unwrap_or(f64::INFINITY);
        time(&self.brake) <= time(&self.damper) && self.brake.residual.abs() <= self.damper.residual.abs() + 0.1
    }

    fn in_words(&self) -> String {
        let one = |after: &After| {
            let recovery =
                after.recovery_ms.map_or("not back in the run".to_owned(), |ms| format!("back in {ms:.0} ms"));
            format!(
                "peak {:.2} mrad, {recovery}, {:.1} mrad off 250 ms after the push, rests {:.1} mrad off",
                after.peak, after.later, after.residual
            )
        };
        let (off, damper, brake) = (one(&self.off), one(&self.damper), one(&self.brake));
        format!("L 5 ms, 8 N m, {}: off {off}; damper only {damper}; with brake {brake}", self.fluid.name())
    }
}

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    let pushes = pushes(Speed::True)?;
    let flashed = self::pushes(Speed::Counts)?;
    let holding = pushes.iter().filter(|push| push.helps());
    let typical = pushes.iter().filter(|push| push.delay_s == 0.005 && push.push_nm == 8.0);
    let mut figures: Vec<String> = typical.map(Push::in_words).collect();
    let best = holding.clone().map(|push| 1.0 - push.brake.peak / push.damper.peak).fold(0.0, f64::max);
    figures.push(format!("the brake takes up to {:.0} % off the peak of the damper alone", 100.0 * best));
    let with_counts = flashed.iter().filter(|push| push.helps()).count();
    figures.push(format!("speed from counts: at {with_counts} of {} places", flashed.len()));
    let failing = pushes.iter().filter(|push| !push.helps()).map(|push| {
        let delay_ms = trim_zeros(&format!("{:.4}", push.delay_s * 1e3));
        format!("{} N m at L {delay_ms} ms with {}", push.push_nm, push.fluid.name())
    });
    let failing = failing.collect::<Vec<_>>().join(", ");
    let range =
        "L 1.5 to 10 ms times pushes of 2, 4, 8, 12 N m times no delay, Q dead 5, E dead 5, E lag 5, E 2 + 3 ms";
    let claim = |statement, test, figures, verdict| Claim {
        section: "III-B, Fig. 7",
        statement,
        test,
        range: range.to_owned(),
        figures,
        verdict,
    };
    let recovers = |pushes: &[Push]| pushes.iter().filter(|push| push.recovers()).count();
    let rest =
        vec![format!("speed from counts: at {} of {} places", recovers(&flashed), flashed.len()), after_a_step()?];
    Ok(vec![
        claim(
            "Use as a brake, while moving away near the reference, improves the resistance against disturbances",
            "push of 50 ms on the rotor at rest; peak with the field off, damper only, damper and brake",
            figures,
            Verdict::of(holding.count(), pushes.len(), &format!("not for {failing}")),
        ),
        claim(
            "The same, asked of what comes after the peak",
            "back within 1.5 u of the reference no later than with the damper alone, and resting no further off (0.1 mrad)",
            rest,
            Verdict::of(recovers(&pushes), pushes.len(), "the other way round elsewhere: the brake lets go late"),
        ),
    ])
}

/// The push of Fig. 19, which hits a rotor that rests where friction holds it after a step, in words.
fn after_a_step() -> Result<String, Error> {
    let push = Some(Disturbance { start_s: 0.4, ..PUSH });
    let case = Case { fluid: Fluid::EDead2Lag3, push, ..Case::PAPER };
    let brake = after(case)?;
    let damper = after(Case { brake: false, ..case })?;
    let off = after(Case { fluid: Fluid::Off, ..case })?;
    Ok(format!(
        "Fig. 19, 8 N m for 50 ms at 0.4 s after a step of 30 degrees, {}: at 0.7 s {:.1} mrad from the reference with the brake, {:.1} \
         with the damper only, {:.1} with the field off",
        case.fluid.name(),
        brake.later,
        damper.later,
        off.later
    ))
}

fn pushes(speed: Speed) -> Result<Vec<Push>, Error> {
    let mut places = Vec::new();
    for delay_s in GAINS_DELAYS_S {
        for push_nm in PUSHES_NM {
            places.extend(FLUIDS.map(|fluid| (delay_s, push_nm, fluid)));
        }
    }
    places
        .into_par_iter()
        .map(|(delay_s, push_nm, fluid)| {
            let push = Some(Disturbance { torque_nm: push_nm, ..PUSH });
            let case = Case {
                fluid,
                gains_delay_s: delay_s,
                plant_delay_s: delay_s,
                step_rad: 0.0,
                speed,
                push,
                ..Case::PAPER
            };
            Ok(Push {
                delay_s,
                push_nm,
                fluid,
                off: after(Case { fluid: Fluid::Off, ..case })?,
                damper: after(Case { brake: false, ..case })?,
                brake: after(case)?,
            })
        })
        .collect()
}

fn after(case: Case) -> Result<After, Error> {
    let rows = case.run()?;
    let period_s = f64::from(case.config().period_s);
    let band_rad = 1.5 * case.friction_error_rad();
    let push = case.push.unwrap_or(PUSH);
    let end = ((push.start_s + push.duration_s) / period_s) as usize;
    let off_rad = |row: &Row| row.truth.position - case.step_rad;
    let outside = rows.iter().rposition(|row| off_rad(row).abs() > band_rad);
    let later = (end + (LATER_S / period_s) as usize).min(rows.len().saturating_sub(1));
    Ok(After {
        peak: 1e3 * peak_rad(&rows),
        recovery_ms: match outside {
            Some(last) if last + 1 == rows.len() => None,
            Some(last) => Some(1e3 * period_s * (last + 1).saturating_sub(end) as f64),
            None => Some(0.0),
        },
        later: rows.get(later).map_or(0.0, |row| 1e3 * off_rad(row)),
        residual: rows.last().map_or(0.0, |row| 1e3 * off_rad(row)),
    })
}
