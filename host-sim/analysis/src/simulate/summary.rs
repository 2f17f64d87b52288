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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use er_servo::{Config, Counts, Inputs, Params, State, step};

    use super::*;

    const PERIOD_S: f64 = 0.001;

    /// Rows with a reference, rad, and a true position and speed each.
    fn rows(values: impl IntoIterator<Item = (f64, f64, f64)>) -> Vec<Row> {
        let params = Params::new(&Config::default()).unwrap();
        let outputs = step(&params, &mut State::default(), &Inputs::default());
        let row = |(k, (reference, position, velocity))| Row {
            t_s: PERIOD_S * f64::from(k),
            reference: Counts::from_rad(reference),
            truth: plant::State::new(position, velocity),
            outputs,
            er_torque_nm: 0.0,
        };
        (0..).zip(values).map(row).collect()
    }

    fn step_to_one(positions: &[f64]) -> Option<StepFigures> {
        Summary::of(&rows(positions.iter().map(|position| (1.0, *position, 0.0))), PERIOD_S).step
    }

    fn dips(speeds: &[f64], direction: f64) -> usize {
        speed_dips(&rows(speeds.iter().map(|speed| (1.0, 0.0, direction * speed))), direction)
    }

    #[test]
    fn overshoot_settling_and_residual_of_a_step() {
        let mut positions = vec![0.0, 0.5, 1.1, 0.97, 1.01];
        positions.resize(30, 0.99);
        let step = step_to_one(&positions).unwrap();
        let one = Counts::from_rad(1.0).to_rad();
        assert!((step.overshoot - (1.1 - one) / one).abs() < 1e-12);
        // 0.97 in row 3 is the last outside of 2 %.
        assert_eq!(step.settling_s, Some(4.0 * PERIOD_S));
        assert!((step.residual_rad - (one - 0.99)).abs() < 1e-12);
        positions[29] = 0.9;
        assert_eq!(step_to_one(&positions).unwrap().settling_s, None, "ends outside");
    }

    #[test]
    fn downwards_is_the_same() {
        let mut values: Vec<(f64, f64, f64)> = vec![(0.0, 1.0, 0.0), (0.0, 0.5, -1.0), (0.0, -0.2, -1.0)];
        values.resize(30, (0.0, 0.005, 0.0));
        let step = Summary::of(&rows(values), PERIOD_S).step.unwrap();
        assert!((step.overshoot - 0.2).abs() < 1e-12 && (step.height_rad + 1.0).abs() < 1e-12);
    }

    #[test]
    fn only_the_last_step_counts_and_only_if_it_is_held() {
        let steps = (0..60).map(|k| if k < 30 { (2.0, f64::from(k).min(2.0), 0.0) } else { (1.0, 1.5, 0.0) });
        let step = Summary::of(&rows(steps), PERIOD_S).step.unwrap();
        assert!((step.height_rad + 0.5).abs() < 1e-5, "from where it stood to the last level: {}", step.height_rad);
        assert_eq!(step_to_one(&[0.0; 10]), None, "held for less than 20 ms");
        let ramp = (0..60).map(|k| (0.01 * f64::from(k), 0.0, 0.0));
        assert_eq!(Summary::of(&rows(ramp), PERIOD_S).step, None, "a reference that moves to the end has no step");
        assert_eq!(Summary::of(&[], PERIOD_S).step, None);
    }

    #[test]
    fn dips_are_falls_and_rises_beyond_the_ripple() {
        for direction in [1.0, -1.0] {
            assert_eq!(dips(&[0.0, 1.0, 2.0, 1.0, 0.0], direction), 0, "one hump");
            assert_eq!(dips(&[0.0, 0.5, 0.3, 2.0, 1.0, 0.0], direction), 0, "before the peak");
            assert_eq!(dips(&[2.0, 1.0, 1.5, 0.2, 0.4, 0.0], direction), 2);
            assert_eq!(dips(&[2.0, 1.0, 1.019, 0.5, 0.0], direction), 0, "less than the ripple");
            assert_eq!(dips(&[2.0, 1.0, 1.01, 1.02, 1.03, 0.0], direction), 1, "a slow rise is one");
        }
    }

    #[test]
    fn errors_peaks_and_times_of_the_modes() {
        let summary = Summary::of(&rows([(1.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 2.0, 0.0)]), PERIOD_S);
        assert!((summary.rms_error_rad - (2.0_f64 / 3.0).sqrt()).abs() < 1e-5);
        assert!((summary.peak_error_rad - 1.0).abs() < 1e-5);
        assert_eq!(summary.mode_s, [3.0 * PERIOD_S, 0.0, 0.0]);
    }
}
