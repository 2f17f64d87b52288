//! The figures of a run: overshoot, settling, residual, peak field, time in each mode.

use er_servo::{Mode, RAD_PER_COUNT};

use super::closed_loop::Row;

/// Settling band as a share of the step: 2 %, the 10.47 mrad of a 30 degree step in control.md section 7.
const SETTLING_BAND: f64 = 0.02;
/// A dip is a fall and a rise of the speed by at least this, rad/s: less is the damper's own ripple.
const DIP_RAD_S: f64 = 0.02;

/// What a run looked like. Step figures are none where the reference does not end on a level away from its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Number of control periods.
    pub ticks: usize,
    /// Figures of the last step.
    pub step: Option<StepFigures>,
    /// Highest field commanded, kV/mm.
    pub peak_field_kv_mm: f64,
    /// Highest torque commanded either way, N m.
    pub peak_torque_nm: f64,
    /// Root mean square of reference minus position, rad.
    pub rms_error_rad: f64,
    /// Largest error either way, rad.
    pub peak_error_rad: f64,
    /// Time off, as damper, as brake, s.
    pub mode_s: [f64; 3],
    /// Whether the drive latched a fault.
    pub faulted: bool,
}

/// Figures of one step response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepFigures {
    /// Height, rad.
    pub height_rad: f64,
    /// Beyond the reference, as a share of the step.
    pub overshoot: f64,
    /// From the step to the last time outside the band, s; none if it ends outside.
    pub settling_s: Option<f64>,
    /// Reference minus position at the end, rad.
    pub residual_rad: f64,
    /// Falls and rises of the speed after its peak.
    pub speed_dips: usize,
}

impl Summary {
    /// The figures of a run at a control period, s; positions are the true ones.
    pub fn of(rows: &[Row], period_s: f64) -> Self {
        let error = |row: &Row| row.reference.to_rad() - row.truth.position;
        let time_in = |mode| period_s * rows.iter().filter(|row| row.outputs.mode == mode).count() as f64;
        let peak = |value: fn(&Row) -> f64| rows.iter().map(value).fold(0.0, f64::max);
        let sum_squares: f64 = rows.iter().map(|row| error(row).powi(2)).sum();
        Self {
            ticks: rows.len(),
            step: StepFigures::of(rows, period_s),
            peak_field_kv_mm: peak(|row| f64::from(row.outputs.field_kv_mm)),
            peak_torque_nm: peak(|row| f64::from(row.outputs.torque_nm.abs())),
            rms_error_rad: (sum_squares / rows.len().max(1) as f64).sqrt(),
            peak_error_rad: rows.iter().map(|row| error(row).abs()).fold(0.0, f64::max),
            mode_s: [Mode::Off, Mode::Damper, Mode::Brake].map(time_in),
            faulted: rows.iter().any(|row| !row.outputs.supervisor.faults().is_empty()),
        }
    }
}

impl StepFigures {
    /// Figures of the last change of the reference, if it is held to the end for at least 20 ms.
    fn of(rows: &[Row], period_s: f64) -> Option<Self> {
        let last = rows.last()?;
        let start = rows.iter().rposition(|row| row.reference != last.reference).map_or(0, |before| before + 1);
        let response = rows.get(start..).filter(|response| response.len() as f64 * period_s >= 0.02)?;
        let (from, to) = (response.first()?.truth.position, last.reference.to_rad());
        let height_rad = to - from;
        // A step of a few counts has no overshoot that means anything.
        if height_rad.abs() < 10.0 * f64::from(RAD_PER_COUNT) {
            return None;
        }
        let band_rad = SETTLING_BAND * height_rad.abs();
        let outside = response.iter().rposition(|row| (to - row.truth.position).abs() > band_rad);
        let beyond = response.iter().map(|row| (row.truth.position - to) / height_rad).fold(0.0, f64::max);
        Some(Self {
            height_rad,
            overshoot: beyond,
            settling_s: match outside {
                Some(last_outside) if last_outside + 1 == response.len() => None,
                Some(last_outside) => Some((last_outside + 1) as f64 * period_s),
                None => Some(0.0),
            },
            residual_rad: to - last.truth.position,
            speed_dips: speed_dips(response, height_rad.signum()),
        })
    }
}

impl std::fmt::Display for Summary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(step) = &self.step {
            writeln!(f, "step             {:.5} rad", step.height_rad)?;
            writeln!(f, "overshoot        {:.2} %", 100.0 * step.overshoot)?;
            match step.settling_s {
                Some(settling_s) => writeln!(f, "settling         {:.1} ms (within 2 %)", 1e3 * settling_s)?,
                None => writeln!(f, "settling         not within the run (2 %)")?,
            }
            writeln!(f, "residual         {:.3} mrad", 1e3 * step.residual_rad)?;
            writeln!(f, "speed dips       {}", step.speed_dips)?;
        }
        writeln!(
            f,
            "error            {:.3} mrad rms, {:.3} peak",
            1e3 * self.rms_error_rad,
            1e3 * self.peak_error_rad
        )?;
        writeln!(f, "peak field       {:.4} kV/mm", self.peak_field_kv_mm)?;
        writeln!(f, "peak torque      {:.3} N m", self.peak_torque_nm)?;
        let [off, damper, brake] = self.mode_s;
        writeln!(f, "time             {off:.4} s off, {damper:.4} s damper, {brake:.4} s brake")?;
        if self.faulted {
            writeln!(f, "the drive latched a fault; see the column fault")?;
        }
        Ok(())
    }
}

/// Counts how often the speed along the step falls and rises again, after its peak.
fn speed_dips(response: &[Row], direction: f64) -> usize {
    let speed = |row: &Row| direction * row.truth.velocity;
    let peak = response.iter().map(speed).fold(f64::NEG_INFINITY, f64::max);
    let after = response.iter().map(speed).skip_while(|speed| *speed < peak);
    let (mut dips, mut falling, mut extreme) = (0, true, peak);
    for speed in after {
        let further = if falling { speed < extreme } else { speed > extreme };
        if further {
            extreme = speed;
        } else if (speed - extreme).abs() > DIP_RAD_S {
            dips += usize::from(falling);
            falling = !falling;
            extreme = speed;
        }
    }
    dips
}
