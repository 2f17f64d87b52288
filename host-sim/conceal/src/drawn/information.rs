//! How much a motion tells about an effect: the generator's own physics along the generator's own motion.
//!
//! An effect's column is the torque that it adds: row by row the machine with it is put where the motion was, driven by the same
//! command, and the difference of its gain of speed to that of the nominal machine, times inertia over time, is the torque of the
//! row. What the drive, the fluid and the contacts remember is not put back. A sensor's effect is the angle it adds. Both are held
//! against the noise through second differences of the position, z = (J/T^2) `(y[k+1] - 2 y[k] + y[k-1])`: a torque passes the mean of
//! two rows, H = cos(w/2), an angle (J/T^2) (2 - 2 cos w). The information is the sum over frequencies of |Z|^2 over the noise's
//! spectrum: twice the expected gain of log-likelihood of the machine with the effect over the one without.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::motion::Sample;
use super::setting::Setting;
use crate::physics::Physics;
use crate::rotor::Rotor;
use crate::sensor::{Measured, unit_normal};
use rand::SeedableRng;
use rand::rngs::StdRng;

/// Information from which an effect can be told from none: what chance exceeds once in 3000 searches over thirty effects at one
/// degree of freedom, found in half of the cases: 4.1 squared is 17 (p = 4e-5, times thirty 1e-3).
pub(crate) const TOLD: f64 = 17.0;
/// Windows that say whether an effect matters, s (diagnosis.md).
const WINDOWS_S: [f64; 2] = [0.05, 0.2];
/// A model without the effect leaves 3 % more than the noise (diagnosis.md): root of 1/0.97^2 - 1.
pub(crate) const MATTERS: f64 = 0.2507;
/// Longest step of the integrator here, s: a twentieth of the shortest delay that is concealed.
pub(crate) const STEP_S: f64 = 5e-5;

/// Noise in the unit of the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Deviations {
    pub(crate) white: f64,
    pub(crate) coloured: Option<(f64, f64)>,
    pub(crate) sensor: f64,
}

/// A motion of the nominal machine, and what is needed to weigh columns on it.
pub(crate) struct Motion<'a> {
    pub(crate) setting: &'a Setting,
    pub(crate) nominal: &'a Physics,
    pub(crate) rows: &'a [Sample],
    pub(crate) noise: Deviations,
    /// Speed that the nominal machine has at the end of each row.
    arrives: Vec<f64>,
    /// What its sensor adds.
    shows: Vec<f64>,
}

/// What an effect adds, row by row.
pub(crate) struct Column {
    torque: Vec<f64>,
    angle: Vec<f64>,
}

impl<'a> Motion<'a> {
    pub(crate) fn new(setting: &'a Setting, nominal: &'a Physics, rows: &'a [Sample], noise: Deviations) -> Self {
        let mut motion = Self { setting, nominal, rows, noise, arrives: Vec::new(), shows: Vec::new() };
        motion.arrives = motion.forced(nominal);
        motion.shows = motion.angles(nominal);
        motion
    }

    /// Speeds at the ends of the rows of a machine that is put on the motion at the start of each.
    fn forced(&self, physics: &Physics) -> Vec<f64> {
        let whole = (self.setting.period_s / STEP_S).ceil();
        let mut rotor = Rotor::new(physics, self.setting.period_s / whole);
        let row = |sample: &Sample| {
            rotor.place(sample.position, sample.speed);
            (0..whole as usize).for_each(|_| rotor.step(&sample.command));
            rotor.speed_rad_s()
        };
        self.rows.iter().map(row).collect()
    }

    /// What a machine adds to the nominal one.
    pub(crate) fn column(&self, physics: &Physics) -> Column {
        let per_speed = self.nominal.inertia_kg_m2 / self.setting.period_s;
        let torque =
            self.forced(physics).into_iter().zip(&self.arrives).map(|(with, without)| per_speed * (with - without));
        let angle = self.angles(physics).into_iter().zip(&self.shows).map(|(with, without)| with - without);
        Column { torque: torque.collect(), angle: angle.collect() }
    }

    /// What the sensor adds; its noise is none of the effect.
    fn angles(&self, physics: &Physics) -> Vec<f64> {
        let mut quiet = physics.clone();
        (quiet.sensor.noise_rad, quiet.sensor.latency_s) = (0.0, 0.0);
        let latency_s = physics.sensor.latency_s;
        let mut sensor = Measured::new(&quiet, STEP_S);
        let mut random = StdRng::seed_from_u64(0);
        let seen = |row: usize| self.earlier(row, latency_s);
        let reads = |row: usize| {
            // A row has the torque from there on.
            sensor.feel(if row > 0 { self.rows[row - 1].drive } else { 0.0 });
            sensor.sample(seen(row), &mut random) - self.rows[row].position
        };
        (0..self.rows.len()).map(reads).collect()
    }

    /// Position some time before a row, by Hermite's cubic between the rows.
    fn earlier(&self, row: usize, time_s: f64) -> f64 {
        let period_s = self.setting.period_s;
        let back = time_s / period_s;
        let whole = back.ceil() as usize;
        if whole > row {
            return self.rows[0].position;
        }
        let at = row - whole;
        let x = whole as f64 - back;
        let (from, to) = (&self.rows[at], &self.rows[(at + 1).min(self.rows.len() - 1)]);
        let (v0, v1) = (from.speed * period_s, to.speed * period_s);
        let rest = 1.0 - x;
        from.position * (1.0 + 2.0 * x) * rest * rest
            + v0 * x * rest * rest
            + to.position * x * x * (3.0 - 2.0 * x)
            + v1 * x * x * (x - 1.0)
    }

    /// The column in units of the noise, frequency by frequency: the product of two is their information.
    pub(crate) fn whitened(&self, column: &Column) -> Vec<Complex<f64>> {
        let n = column.torque.len();
        let per_angle = self.nominal.inertia_kg_m2 / self.setting.period_s.powi(2);
        let mut z: Vec<Complex<f64>> = (0..n)
            .map(|k| {
                let before = k.saturating_sub(1);
                let after = (k + 1).min(n - 1);
                let bend = column.angle[after] - 2.0 * column.angle[k] + column.angle[before];
                Complex::new(0.5 * (column.torque[k] + column.torque[before]) + per_angle * bend, 0.0)
            })
            .collect();
        FftPlanner::new().plan_fft_forward(n).process(&mut z);
        let spectrum = |index: usize| (n as f64 * self.density(TAU * index as f64 / n as f64)).sqrt();
        z.iter().enumerate().map(|(index, value)| value / spectrum(index)).collect()
    }

    /// Spectrum of the noise in a second difference, per row, at an angular frequency per row.
    fn density(&self, w: f64) -> f64 {
        let Deviations { white, coloured, sensor } = self.noise;
        let coloured = coloured.map_or(0.0, |(deviation, memory_s)| {
            let keep = (-self.setting.period_s / memory_s).exp();
            deviation.powi(2) * (1.0 - keep * keep) / (1.0 - 2.0 * keep * w.cos() + keep * keep)
        });
        let passes = 0.5 * (1.0 + w.cos());
        let per_angle = self.nominal.inertia_kg_m2 / self.setting.period_s.powi(2) * (2.0 - 2.0 * w.cos());
        // A density of nothing would weigh one frequency infinitely.
        passes * (white * white + coloured) + (per_angle * sensor).powi(2) + 1e-3 * white * white
    }

    /// Root mean square that the column adds to windows of either length, over that of the noise: the larger.
    pub(crate) fn relevance(&self, column: &Column, noise: &[f64; 2]) -> f64 {
        let ratio = |(window_s, noise): (f64, &f64)| self.left(&column.torque, &column.angle, window_s) / noise;
        WINDOWS_S.into_iter().zip(noise).map(ratio).fold(0.0, f64::max)
    }

    /// Root mean square of the noise alone in windows of either length.
    pub(crate) fn noise_left(&self, seed: u64) -> [f64; 2] {
        let mut random = StdRng::seed_from_u64(seed);
        let mut slow = 0.0;
        let torque: Vec<f64> = (0..self.rows.len())
            .map(|_| {
                if let Some((deviation, memory_s)) = self.noise.coloured {
                    let keep = (-self.setting.period_s / memory_s).exp();
                    slow = keep * slow + deviation * (1.0 - keep * keep).sqrt() * unit_normal(&mut random);
                }
                slow + self.noise.white * unit_normal(&mut random)
            })
            .collect();
        let angle: Vec<f64> = (0..self.rows.len()).map(|_| self.noise.sensor * unit_normal(&mut random)).collect();
        WINDOWS_S.map(|window_s| self.left(&torque, &angle, window_s))
    }

    /// Root mean square of the path that torques and angles add within windows, a straight line taken out of each: its start is
    /// estimated.
    fn left(&self, torque: &[f64], angle: &[f64], window_s: f64) -> f64 {
        let period_s = self.setting.period_s;
        let rows = ((window_s / period_s).round() as usize).max(4);
        let per_torque = period_s / self.nominal.inertia_kg_m2;
        let (mut squares, mut count) = (0.0, 0);
        for (torque, angle) in torque.chunks_exact(rows).zip(angle.chunks_exact(rows)) {
            let (mut position, mut speed) = (0.0, 0.0);
            let path: Vec<f64> = torque
                .iter()
                .zip(angle)
                .map(|(torque, angle)| {
                    let here = position + angle;
                    position += period_s * (speed + 0.5 * per_torque * torque);
                    speed += per_torque * torque;
                    here
                })
                .collect();
            squares += without_line(&path);
            count += rows;
        }
        (squares / count.max(1) as f64).sqrt()
    }
}

/// Sum of squares about the best straight line.
fn without_line(path: &[f64]) -> f64 {
    let n = path.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = path.iter().sum::<f64>() / n;
    let spread = n * (n * n - 1.0) / 12.0;
    let slope = path.iter().enumerate().map(|(k, at)| (k as f64 - middle) * at).sum::<f64>() / spread;
    path.iter().enumerate().map(|(k, at)| (at - mean - slope * (k as f64 - middle)).powi(2)).sum()
}

/// Information that two whitened columns share; of one with itself, its own.
pub(crate) fn product(one: &[Complex<f64>], other: &[Complex<f64>]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a.re * b.re + a.im * b.im).sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::motion::Loop;
    use super::*;
    use crate::reference::Family;
    use rand::Rng;

    /// A machine with only viscous friction: nothing about it depends on where it stands.
    fn viscous(random: &mut StdRng) -> Setting {
        let mut setting = loop {
            let setting = Setting::draw(false, random);
            if setting.measured.is_none() && !setting.has_fluid() && setting.physics.friction.viscous_nm_s_rad > 0.0 {
                break setting;
            }
        };
        setting.physics.friction.coulomb_nm = 0.0;
        setting.jitter_s = 0.0;
        setting
    }

    fn run(setting: &Setting, physics: &Physics, seed: u64) -> Vec<Sample> {
        let mut random = StdRng::seed_from_u64(7);
        let (slower, travel) = (setting.slower, setting.travel);
        let reference = Family::Steps.draw_rad(2.0 / slower, setting.period_s / slower, &mut random);
        let reference: Vec<f64> = reference.into_iter().map(|at| travel * at).collect();
        let run = Loop { setting, physics, coloured: None, gain_error: 1.0, step_s: STEP_S, seed };
        run.follow(&reference).unwrap()
    }

    #[test]
    fn a_constant_torque_under_white_noise_has_the_information_of_the_textbook() {
        let setting = viscous(&mut StdRng::seed_from_u64(1));
        let rows = run(&setting, &setting.physics, 1);
        let noise = Deviations { white: 0.01, coloured: None, sensor: 0.0 };
        let motion = Motion::new(&setting, &setting.physics, &rows, noise);
        let mut physics = setting.physics.clone();
        physics.drive.offset_nm = 1e-3;
        let column = motion.whitened(&motion.column(&physics));
        // Rows times the square of torque over deviation; a speed that friction takes back within a row is no part of it.
        let expected = rows.len() as f64 * 0.01;
        let found = product(&column, &column);
        println!("{found} of {expected}");
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }

    /// The log-likelihood of the true machine over that of none, from simulated recordings: half the information on average where the
    /// effect is there, minus half where it is not, and its variance is the information.
    #[test]
    fn the_likelihood_of_the_truth_over_none_is_what_the_information_says() {
        let mut random = StdRng::seed_from_u64(3);
        // Sums of log-likelihood ratios and of their information, with the effect there and without.
        let mut sums = [[0.0; 2]; 2];
        for effect in 0..12 {
            let mut setting = viscous(&mut random);
            let quiet = run(&setting, &setting.physics, 1);
            let torque = (quiet.iter().map(|row| row.drive.powi(2)).sum::<f64>() / quiet.len() as f64).sqrt();
            setting.physics.torque_noise_nm = 0.02 * torque;
            setting.physics.sensor.noise_rad = 0.5 * setting.step;
            let sensor = setting.physics.sensor.noise_rad.hypot(setting.step / 12.0_f64.sqrt());
            let noise = Deviations { white: 0.02 * torque, coloured: None, sensor };
            let mut physics = setting.physics.clone();
            match effect % 3 {
                0 => physics.drive.gain = 1.002,
                1 => physics.friction.viscous_nm_s_rad *= 1.05,
                _ => physics.drive.offset_nm = 1e-3 * torque,
            }
            for (truth, sum) in [&physics, &setting.physics].into_iter().zip(&mut sums) {
                let rows = run(&setting, truth, random.random());
                let (ratio, information) = likelihood_ratio(&setting, &physics, &rows, noise);
                *sum = [sum[0] + ratio, sum[1] + information];
            }
        }
        let [with, without] = sums.map(|[ratio, information]| ratio / information);
        // The sum scatters by the root of its information.
        let scatter = sums.map(|[_, information]| 1.0 / information.sqrt());
        println!("per information: with {with:.3}, without {without:.3}, each by {scatter:.3?}");
        assert!((with - 0.5).abs() < 3.0 * scatter[0] + 0.02, "{with}");
        assert!((without + 0.5).abs() < 3.0 * scatter[1] + 0.02, "{without}");
    }

    /// Of the machine with the effect over the nominal one, on one recording; and its expected size twice.
    fn likelihood_ratio(setting: &Setting, effect: &Physics, rows: &[Sample], noise: Deviations) -> (f64, f64) {
        // Neither knows the noise.
        let known: Vec<Sample> = rows
            .iter()
            .map(|row| Sample { command: crate::rotor::Command { external_nm: 0.0, ..row.command }, ..*row })
            .collect();
        let motion = Motion::new(setting, &setting.physics, &known, noise);
        let column = motion.whitened(&motion.column(effect));
        let per_speed = setting.physics.inertia_kg_m2 / setting.period_s;
        let next = |k: usize| rows.get(k + 1).map_or(motion.arrives[k], |row| row.speed);
        let seen = Column {
            torque: (0..rows.len()).map(|k| per_speed * (next(k) - motion.arrives[k])).collect(),
            angle: rows.iter().map(|row| row.reading - row.position).collect(),
        };
        let information = product(&column, &column);
        (product(&motion.whitened(&seen), &column) - 0.5 * information, information)
    }
}
