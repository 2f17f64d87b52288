//! Section III-B: the damper as a brake.

use rayon::prelude::*;

use super::claim::{Claim, Verdict, trim_zeros};
use crate::paper::case::{Case, Fluid, PUSH, Speed, peak_rad};
use crate::paper::scan::GAINS_DELAYS_S;
use crate::simulate::Disturbance;
use recording::Error;

/// Pushes on the rotor at rest, N m; friction holds 0.763.
const PUSHES_NM: [f64; 4] = [2.0, 4.0, 8.0, 12.0];
/// Delay models under which the brake must still help.
const FLUIDS: [Fluid; 5] = [Fluid::None, Fluid::QDead5, Fluid::EDead5, Fluid::ELag5, Fluid::EDead2Lag3];

/// Peaks of one push, mrad.
struct Peaks {
    delay_s: f64,
    push_nm: f64,
    fluid: Fluid,
    off: f64,
    damper: f64,
    brake: f64,
}

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    let peaks = peaks(Speed::True)?;
    let flashed = self::peaks(Speed::Counts)?;
    let helps = |p: &Peaks| p.brake < 0.99 * p.damper && p.damper < p.off;
    let holding: Vec<&Peaks> = peaks.iter().filter(|p| helps(p)).collect();
    let mut figures = Vec::new();
    for p in peaks.iter().filter(|p| p.delay_s == 0.005 && p.push_nm == 8.0) {
        let (off, damper, brake) = (p.off, p.damper, p.brake);
        let name = p.fluid.name();
        figures
            .push(format!("L 5 ms, 8 N m, {name}: {off:.2} mrad off, {damper:.2} damper only, {brake:.2} with brake"));
    }
    let best = holding.iter().map(|p| 1.0 - p.brake / p.damper).fold(0.0, f64::max);
    figures.push(format!("the brake takes up to {:.0} % off the peak of the damper alone", 100.0 * best));
    let with_counts = flashed.iter().filter(|p| helps(p)).count();
    figures.push(format!("speed from counts: at {with_counts} of {} places", flashed.len()));
    let failing = peaks.iter().filter(|p| !helps(p)).map(|p| {
        format!("{} N m at L {} ms with {}", p.push_nm, trim_zeros(&format!("{:.4}", p.delay_s * 1e3)), p.fluid.name())
    });
    let failing = failing.collect::<Vec<_>>().join(", ");
    let verdict = match holding.len() {
        0 => Verdict::DoesNotHold("at no place of the range".to_owned()),
        n if n == peaks.len() => Verdict::Holds,
        n => Verdict::HoldsOnly(format!("at {n} of {} places; not for {failing}", peaks.len())),
    };
    Ok(vec![Claim {
        section: "III-B, Fig. 7",
        statement: "Use as a brake, while moving away near the reference, improves the resistance against disturbances",
        test: "push of 50 ms on the rotor at rest; peak with the field off, damper only, damper and brake",
        range: "L 1.5 to 10 ms times pushes of 2, 4, 8, 12 N m times no delay, Q dead 5, E dead 5, E lag 5, E 2 + 3 ms"
            .to_owned(),
        figures,
        verdict,
    }])
}

fn peaks(speed: Speed) -> Result<Vec<Peaks>, Error> {
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
            let peak = |case: Case| Ok::<_, Error>(1e3 * peak_rad(&case.run()?));
            Ok(Peaks {
                delay_s,
                push_nm,
                fluid,
                off: peak(Case { fluid: Fluid::Off, ..case })?,
                damper: peak(Case { brake: false, ..case })?,
                brake: peak(case)?,
            })
        })
        .collect()
}
