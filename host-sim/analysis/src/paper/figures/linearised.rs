//! Fig. 5 as the machine would measure it: a motor driven at a constant speed, the speed estimate of the flashed law at
//! 2 kHz from counts, the field of (4) for a constant Q, the fluid's delay, the torque averaged over time.

use std::f64::consts::TAU;

use er_servo::{Config, Counts, Outputs};
use plant::{Er, Model};
use rayon::prelude::*;

use super::NamedFigure;
use crate::paper::case::{A, B, COULOMB_NM};
use crate::paper::claims::{VISCOSITIES, field_for_kv_mm};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};
use crate::simulate::{ClosedLoop, Setup};
use recording::Error;

/// An inertia that no torque of the machine slows down noticeably, kg m2.
const FLYWHEEL_KG_M2: f64 = 1e6;
/// Speeds shown, rad/s: as Fig. 4 and 5, whose fit is for 0.1 to 0.5.
const SPEEDS: u32 = 30;
const STEP_RAD_S: f64 = 0.02;
/// A little over the torque of 3.5 kV/mm with friction, N m.
const TOP_NM: f64 = 3.6;
/// Averaged over, s, after as long again to settle.
const MEAN_S: f64 = 0.25;

/// Mean torque, N m, at a speed, rad/s: of a constant Q, or of (5) as the law is flashed.
fn mean_torque_nm(q_nm_s_rad: Option<f64>, speed_rad_s: f64) -> Result<f64, Error> {
    let config = Config { near_rad: 0.0, ..Config::default() };
    let er = Er::new(A, B, 0.002, 0.003);
    let model = Model { er: Some(er), ..Model::new(FLYWHEEL_KG_M2) };
    let setup = Setup { model, config, disturbances: Vec::new(), sensor_noise_rad: 0.0, torque_noise_nm: 0.0, seed: 0 };
    let mut driven = ClosedLoop::new(&setup)?;
    driven.start_from(plant::State::new(0.0, speed_rad_s));
    let ticks = (MEAN_S / f64::from(config.period_s)) as usize;
    let position = Counts::from_rad(0.5 * TAU);
    let constant = |_, outputs: &mut Outputs| {
        if let Some(q) = q_nm_s_rad {
            let wanted = field_for_kv_mm(q, f64::from(outputs.speed_rad_s.abs()));
            outputs.field_kv_mm = wanted.min(f64::from(config.field_limit_kv_mm)) as f32;
        }
    };
    let mut sum_nm = 0.0;
    for tick in 0..2 * ticks {
        let row = driven.tick_beside(position, constant)?;
        sum_nm += if tick < ticks { 0.0 } else { row.er_torque_nm };
    }
    Ok(sum_nm / ticks as f64)
}

pub(super) fn figure() -> Result<NamedFigure, Error> {
    let of = |(name, q): (String, Option<f64>)| {
        let points = (1..=SPEEDS).into_par_iter().map(|k| {
            let speed = STEP_RAD_S * f64::from(k);
            Ok((speed, mean_torque_nm(q, speed)? + COULOMB_NM))
        });
        Ok::<_, Error>(Series::new(&name, Mark::Line, points.collect::<Result<Vec<_>, Error>>()?))
    };
    let mut series = Vec::new();
    for q in VISCOSITIES {
        series.push(of((format!("Q {q} N m s/rad"), Some(q)))?);
        // A straight line up to the top of the picture.
        let end = (STEP_RAD_S * f64::from(SPEEDS)).min((TOP_NM - COULOMB_NM) / q);
        let line = [(0.0, COULOMB_NM), (end, q.mul_add(end, COULOMB_NM))];
        series.push(Series::new("", Mark::Line, line).with(Stroke::Dotted));
    }
    series.push(of(("Q of (5), as flashed".to_owned(), None))?.with(Stroke::Dashed));
    let title = "Fig. 5: torque after linearisation, speed from counts at 2 kHz, E dead 2 + lag 3 ms; dotted Q |w| + c";
    let panels = vec![Panel::new("speed (rad/s)", "mean torque (N m)", series)];
    Ok(NamedFigure { file: "fig05.svg", figure: Figure { title: title.to_owned(), panels } })
}
