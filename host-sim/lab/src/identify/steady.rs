//! Friction and the law of the fluid from torques at constant speed: linear least squares, exact.

use std::ops::Range;

use diagnosis::confidence_set::Interval;
use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::plan::{Planned, Purpose};
use crate::Error;
use crate::read::Recording;

/// What the torques at constant speed tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Steady {
    /// c of equation (2), dry friction, N m.
    pub coulomb_nm: Interval,
    /// N m s/rad.
    pub viscous_nm_s_rad: Interval,
    /// What the drive adds to its command, N m.
    pub offset_nm: Interval,
    /// a of equation (2), N m per (kV/mm)^2.
    pub er_a: Interval,
    /// b of equation (2), N m per kV/mm.
    pub er_b: Interval,
    /// a E^2 + b E at the field where the wanted drag of (5) has its peak, N m.
    pub fluid_nm: Interval,
    /// What the passes leave unexplained, root mean square, N m.
    pub residual_nm: f64,
    /// Passes at constant speed.
    pub passes: usize,
}

/// One pass at constant speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pass {
    speed_rad_s: f64,
    torque_nm: f64,
    field_kv_mm: f64,
}

/// From when the axis has reached its speed, the loop settles in this, s: the slowest root of the paper's gains is at 94 /s, and a
/// machine a quarter as fast has settled too.
const SETTLES_S: f64 = 0.2;
/// It has reached its speed when it goes at that of the reference, but for this share, over this time, s: after a reversal
/// weak gains leave it at rest until the error overcomes friction and field.
const AT_SPEED: (f64, f64) = (0.05, 0.1);
/// A pass that is shorter than this after it has settled is none, s.
const LEAST_S: f64 = 0.1;
/// Share of a pass in which the field must be at its level.
const AT_LEVEL: f64 = 0.95;
/// By how much of it the speed of a pass may miss that of the reference: more, and the torque was at its bound.
const OFF_SPEED: f64 = 0.02;
/// c, viscous friction, offset, a, b.
const UNKNOWNS: usize = 5;

/// Fits all passes of all ramps at once; also tells the fluid's torque at a field.
///
/// # Errors
///
/// Too few passes, a field or a speed that was not constant, or speeds and fields that do not tell the unknowns apart.
pub(super) fn fit<'a>(
    runs: impl Iterator<Item = (&'a Planned, &'a Recording)>,
    field_kv_mm: f64,
) -> Result<Steady, Error> {
    let mut passes = Vec::new();
    for (run, recording) in runs {
        let Purpose::Steady { speed_rad_s, field_kv_mm } = run.purpose else { continue };
        passes.extend(of(recording, speed_rad_s, field_kv_mm)?);
    }
    solve(&passes, field_kv_mm)
}

/// The passes of a ramp.
fn of(recording: &Recording, speed_rad_s: f64, field_kv_mm: f64) -> Result<Vec<Pass>, Error> {
    let nothing = || Error::Usage(format!("{}: has no reference or no field column", recording.name));
    let reference = recording.reference.as_ref().ok_or_else(nothing)?;
    let field = recording.field_cmd_kv_mm.as_ref().ok_or_else(nothing)?;
    let mut passes = Vec::new();
    for moved in constant(&recording.t_s, reference, speed_rad_s) {
        let Some(rows) = settled(recording, moved, speed_rad_s) else { continue };
        let (first, last) = (rows.start, rows.end - 1);
        let count = rows.len() as f64;
        let at_level = field[rows.clone()].iter().filter(|field| (**field - field_kv_mm).abs() < 1e-3).count() as f64;
        if at_level < AT_LEVEL * count {
            let name = &recording.name;
            return Err(Error::Usage(format!("{name}: the field was not {field_kv_mm:.2} kV/mm throughout a pass")));
        }
        let span_s = recording.t_s[last] - recording.t_s[first];
        let mean_rad_s = (recording.position[last] - recording.position[first]) / span_s;
        if (mean_rad_s.abs() - speed_rad_s).abs() > OFF_SPEED * speed_rad_s {
            let name = &recording.name;
            return Err(Error::Usage(format!(
                "{name}: the axis went at {mean_rad_s:.3} rad/s where {speed_rad_s:.3} was asked: it is blocked, or needs more \
                 torque than allowed"
            )));
        }
        passes.push(Pass {
            speed_rad_s: mean_rad_s,
            torque_nm: recording.effort_cmd[rows].iter().sum::<f64>() / count,
            field_kv_mm,
        });
    }
    Ok(passes)
}

/// Ranges of rows in which the reference moves at constant speed.
fn constant(t_s: &[f64], reference: &[f64], speed_rad_s: f64) -> Vec<Range<usize>> {
    // Of two steps of the reference, which is in counts, one may be a count longer.
    let is_constant = |row: usize, sign: f64| {
        let step = reference[row] - reference[row - 1];
        (step - sign * speed_rad_s * (t_s[row] - t_s[row - 1])).abs() < 1.5 * f64::from(er_servo::RAD_PER_COUNT)
    };
    let mut found = Vec::new();
    let mut row = 1;
    while row < t_s.len() {
        let Some(sign) = [1.0, -1.0].into_iter().find(|sign| is_constant(row, *sign)) else {
            row += 1;
            continue;
        };
        let begin = row;
        while row < t_s.len() && is_constant(row, sign) {
            row += 1;
        }
        found.push(begin..row);
    }
    found
}

/// The rows of a pass from when the axis has reached its speed and the loop has settled; none where too little is left.
fn settled(recording: &Recording, rows: Range<usize>, speed_rad_s: f64) -> Option<Range<usize>> {
    let (t_s, position) = (&recording.t_s, &recording.position);
    let (share, over_s) = AT_SPEED;
    let after = |row: usize, time_s: f64| row + t_s[row..rows.end].partition_point(|t| *t < t_s[row] + time_s);
    let at_speed = |row: &usize| {
        let later = after(*row, over_s);
        later < rows.end && {
            let mean_rad_s = (position[later] - position[*row]).abs() / (t_s[later] - t_s[*row]);
            (mean_rad_s - speed_rad_s).abs() < share * speed_rad_s
        }
    };
    let first = after(rows.clone().find(at_speed)?, SETTLES_S);
    (first < rows.end && t_s[rows.end - 1] - t_s[first] >= LEAST_S).then_some(first..rows.end)
}

fn solve(passes: &[Pass], field_kv_mm: f64) -> Result<Steady, Error> {
    let rows = passes.len();
    if rows <= UNKNOWNS {
        return Err(Error::Usage(format!("{rows} passes at constant speed are too few to tell {UNKNOWNS} numbers")));
    }
    let columns = DMatrix::from_fn(rows, UNKNOWNS, |row, column| {
        let Pass { speed_rad_s, field_kv_mm, .. } = passes[row];
        let sign = speed_rad_s.signum();
        [sign, speed_rad_s, 1.0, sign * field_kv_mm * field_kv_mm, sign * field_kv_mm][column]
    });
    let torques = DVector::from_iterator(rows, passes.iter().map(|pass| pass.torque_nm));
    let vague = || Error::Usage("speeds and fields of the ramps do not tell friction and fluid apart".to_owned());
    let inverse = (columns.transpose() * &columns).cholesky().ok_or_else(vague)?.inverse();
    let values = &inverse * columns.transpose() * &torques;
    let left = torques - &columns * &values;
    let freedom = (rows - UNKNOWNS) as f64;
    let variance = left.norm_squared() / freedom;
    let deviate = StudentsT::new(0.0, 1.0, freedom).map_err(|_| vague())?.inverse_cdf(0.975);
    // Of a sum of the unknowns times weights.
    let interval = |weights: [f64; UNKNOWNS]| {
        let weights = DVector::from_row_slice(&weights);
        let value = weights.dot(&values);
        let half = deviate * (variance * weights.dot(&(&inverse * &weights))).max(0.0).sqrt();
        Interval { value, low: value - half, high: value + half }
    };
    Ok(Steady {
        coulomb_nm: interval([1.0, 0.0, 0.0, 0.0, 0.0]),
        viscous_nm_s_rad: interval([0.0, 1.0, 0.0, 0.0, 0.0]),
        // The command holds against what the drive adds.
        offset_nm: interval([0.0, 0.0, -1.0, 0.0, 0.0]),
        er_a: interval([0.0, 0.0, 0.0, 1.0, 0.0]),
        er_b: interval([0.0, 0.0, 0.0, 0.0, 1.0]),
        fluid_nm: interval([0.0, 0.0, 0.0, field_kv_mm * field_kv_mm, field_kv_mm]),
        residual_nm: (left.norm_squared() / rows as f64).sqrt(),
        passes: rows,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::read::AxisKind;

    #[test]
    fn what_makes_the_torques_is_found_exactly() {
        let law = |speed_rad_s: f64, field_kv_mm: f64| Pass {
            speed_rad_s,
            field_kv_mm,
            torque_nm: 0.05
                + 0.02 * speed_rad_s
                + speed_rad_s.signum() * (0.763 + 0.0704 * field_kv_mm * field_kv_mm + 0.47 * field_kv_mm),
        };
        let speeds = [0.1, 0.5, 1.0].into_iter().flat_map(|speed| [law(speed, 0.0), law(-speed, 0.0)]);
        let fields = [0.7, 1.4, 3.5].into_iter().flat_map(|field| [law(0.3, field), law(-0.3, field)]);
        let passes: Vec<Pass> = speeds.chain(fields).collect();
        let found = solve(&passes, 2.0).unwrap();
        for (interval, truth) in [
            (found.coulomb_nm, 0.763),
            (found.viscous_nm_s_rad, 0.02),
            (found.offset_nm, -0.05),
            (found.er_a, 0.0704),
            (found.er_b, 0.47),
            (found.fluid_nm, 4.0 * 0.0704 + 2.0 * 0.47),
        ] {
            assert!((interval.value - truth).abs() < 1e-12, "{interval:?}, {truth}");
        }
        assert!(solve(&passes[..UNKNOWNS], 2.0).is_err());
        let without_fields = solve(&passes[..6], 2.0);
        assert!(without_fields.unwrap_err().to_string().contains("do not tell friction and fluid apart"));
    }

    #[test]
    fn passes_begin_when_the_axis_has_settled_and_end_at_the_reversal() {
        let t_s: Vec<f64> = (0..4000).map(|row| f64::from(row) * 5e-4).collect();
        let ramp = |t: f64| {
            if t < 0.5 {
                0.0
            } else if t < 1.25 {
                t - 0.5
            } else {
                2.0 - t
            }
        };
        let reference: Vec<f64> = t_s.iter().map(|t| ramp(*t)).collect();
        // Friction leaves the axis at rest for 0.2 s after the reversal.
        let position = t_s.iter().map(|t| if (1.25..1.45).contains(t) { ramp(1.25) } else { ramp(*t) + 1e-9 });
        let recording = Recording { position: position.collect(), t_s, ..Recording::empty(AxisKind::Rotary) };
        let found = constant(&recording.t_s, &reference, 1.0);
        let passes: Vec<_> = found.into_iter().filter_map(|rows| settled(&recording, rows, 1.0)).collect();
        let times: Vec<[f64; 2]> =
            passes.iter().map(|rows| [recording.t_s[rows.start], recording.t_s[rows.end - 1]]).collect();
        assert_eq!(times.len(), 2, "{times:?}");
        assert!((times[0][0] - 0.7).abs() < 2e-3 && (times[0][1] - 1.25).abs() < 2e-3, "{times:?}");
        assert!((times[1][0] - 1.65).abs() < 0.02, "{times:?}");
    }
}
