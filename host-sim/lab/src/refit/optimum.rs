//! The refit: from the values of the search to the optimum in the time domain, with what judges it.

use nalgebra::{DMatrix, DVector};

use super::descent::{Goal, NEAR, SETTLED, descend, sums};
use super::point::{Gauge, Point, Slopes};
use super::track::Tracks;
use super::whiten::{Noise, Sample, likely};
use crate::Error;
use crate::read::Recording;
use crate::screen::{Active, Problem, places, solve_near};

/// Rounds of fit and noise, by how far each descends: the noise is what the fit leaves.
const ROUNDS: [Goal; 2] = [NEAR, SETTLED];
/// Windows in motion from one end to the other that make a noise.
const ENOUGH: usize = 10;

/// A hypothesis at its optimum in the time domain. Squares are of residuals of unit variance; windows far beyond the noise
/// count by the root of theirs.
#[derive(Debug, Clone)]
pub struct TimeFit {
    /// Effects with the values found.
    pub active: Vec<Active>,
    /// Sum of squares.
    pub sse: f64,
    /// The same at the values that the refit began with, at their best start states.
    pub start_sse: f64,
    /// Sum of squares in each block of the problem.
    pub blocks: Vec<f64>,
    /// The same as a fit without the block predicts it.
    pub heldout: Vec<f64>,
    /// Rows less start states: what noise alone would leave.
    pub freedom: f64,
    /// Share of the windows whose noise is more than the model's.
    pub far: f64,
    /// Robust sum of squares of each window.
    pub(super) losses: Vec<f64>,
    /// Of each block: derivatives by derivatives, start states eliminated.
    pub(crate) normals: Vec<DMatrix<f64>>,
    /// Of each block: derivatives by residual.
    pub(crate) scores: Vec<DVector<f64>>,
    /// Of each recording, which the squares are in units of.
    noise: Vec<Noise>,
}

impl TimeFit {
    /// Refits the values of `start` to the recordings that the problem was built from. `resolution` is the smallest step of
    /// the position, rad (m). Never ends above the values it starts with.
    ///
    /// # Errors
    /// Values that the plant refuses.
    pub fn new(problem: &Problem, recordings: &[Recording], start: &[Active], resolution: f64) -> Result<Self, Error> {
        Self::fit(problem, recordings, start, resolution)
            .map_err(|error| Error::Usage(format!("the improved machine cannot be simulated: {error}")))
    }

    fn fit(
        problem: &Problem,
        recordings: &[Recording],
        start: &[Active],
        resolution: f64,
    ) -> Result<Self, plant::Error> {
        let mut gauge = Gauge { problem, tracks: Tracks::new(problem, recordings) };
        let count = places(start).len();
        let mut point = gauge.settled(gauge.first(start)?, 3)?;
        let mut noise = Vec::new();
        for goal in ROUNDS {
            for _ in 0..2 {
                noise = noises(&gauge, &point, resolution);
                gauge.tracks.weigh(&noise);
                point = gauge.weighed(point);
            }
            point = lowest(&gauge, gauge.rescued(point)?, count, goal)?;
        }
        let first = gauge.rescued(gauge.settled(gauge.first(start)?, 6)?)?;
        let start_sse = first.loss();
        if start_sse < point.loss() && count > 0 {
            // Under the last weights the start may be better; then it is where the descent begins.
            point = descend(&gauge, first, count, SETTLED)?;
        }
        let slopes = gauge.slopes(&point, true)?;
        Ok(Self::of(&gauge, point, &slopes, start_sse, noise))
    }

    /// The optimum without one of its effects, under the same weights, so that the squares of both compare.
    ///
    /// # Errors
    /// Values that the plant refuses.
    pub fn without(&self, problem: &Problem, recordings: &[Recording], index: usize) -> Result<Self, Error> {
        let mut rest = self.active.clone();
        rest.remove(index);
        self.rival(problem, recordings, &rest)
    }

    /// The optimum of other effects under the same weights, so that the squares of both compare.
    ///
    /// # Errors
    /// Values that the plant refuses.
    pub fn rival(&self, problem: &Problem, recordings: &[Recording], start: &[Active]) -> Result<Self, Error> {
        let fit = || {
            let gauge = self.gauge(problem, recordings);
            let first = gauge.rescued(gauge.settled(gauge.first(start)?, 6)?)?;
            let (start_sse, count) = (first.loss(), places(start).len());
            let point = lowest(&gauge, first, count, SETTLED)?;
            let slopes = gauge.slopes(&point, true)?;
            Ok(Self::of(&gauge, point, &slopes, start_sse, self.noise.clone()))
        };
        fit().map_err(|error: plant::Error| Error::Usage(format!("a machine with other effects: {error}")))
    }

    /// Standard deviation of a white torque held over rows of `period_s` that would scatter an inertia, kg m2 (kg), as this
    /// fit leaves recording number `index`, N m (N); one that was not fitted is taken to be as noisy as the noisiest that was.
    pub fn torque_noise(&self, index: usize, inertia: f64, period_s: f64) -> f64 {
        let noisiest = || self.noise.iter().map(|noise| noise.acceleration).fold(0.0, f64::max);
        let acceleration = self.noise.get(index).map_or_else(noisiest, |noise| noise.acceleration);
        inertia * (acceleration / period_s).sqrt()
    }

    /// What evaluates points under the weights of this fit.
    pub(super) fn gauge<'a>(&self, problem: &'a Problem, recordings: &'a [Recording]) -> Gauge<'a> {
        let mut gauge = Gauge { problem, tracks: Tracks::new(problem, recordings) };
        gauge.tracks.weigh(&self.noise);
        gauge
    }

    fn of(gauge: &Gauge<'_>, point: Point, slopes: &[Slopes], start_sse: f64, noise: Vec<Noise>) -> Self {
        let count = places(&point.active).len();
        let spans = &gauge.tracks.spans;
        let (normal, gradient) = sums(slopes, count);
        let total = gauge.problem.blocks;
        let mut blocks = vec![0.0; total];
        let mut scores = vec![DVector::zeros(count); total];
        let mut normals = vec![DMatrix::zeros(count, count); total];
        for ((span, shot), slopes) in spans.iter().zip(&point.shots).zip(slopes) {
            blocks[span.block] += shot.loss;
            scores[span.block] += &slopes.gradient;
            normals[span.block] += &slopes.normal;
        }
        let predicted = |block: usize| {
            let mut step = solve_near(&(&normal - &normals[block]), &normal, &(&gradient - &scores[block]));
            for (value, place) in step.iter_mut().zip(places(&point.active)) {
                let now = point.active[place.effect].values[place.value];
                // An event informs its own block only; nothing can predict it from the others.
                let event = point.active[place.effect].effect.is_event();
                *value = if event { 0.0 } else { (now + *value).clamp(place.low, place.high) - now };
            }
            (blocks[block] + 2.0 * scores[block].dot(&step) + step.dot(&(&normals[block] * &step))).max(0.0)
        };
        Self {
            sse: point.loss(),
            start_sse,
            heldout: (0..total).map(predicted).collect(),
            blocks,
            freedom: gauge.tracks.freedom(),
            far: point.shots.iter().filter(|shot| shot.weight < 1.0).count() as f64 / spans.len().max(1) as f64,
            losses: point.shots.iter().map(|shot| shot.loss).collect(),
            active: point.active,
            normals,
            scores,
            noise,
        }
    }
}

/// The lowest point from a start; without values to move, that of the start states alone.
fn lowest(gauge: &Gauge<'_>, start: Point, count: usize, goal: Goal) -> Result<Point, plant::Error> {
    if count == 0 { gauge.settled(start, 6) } else { descend(gauge, start, count, goal) }
}

/// The noise of each recording that a point leaves; windows in motion tell it best.
fn noises(gauge: &Gauge<'_>, point: &Point, resolution: f64) -> Vec<Noise> {
    let least = (resolution * resolution / 12.0).max(1e-30);
    (0..gauge.tracks.tracks.len())
        .map(|track| {
            let of = |moving: bool| -> Vec<Sample<'_>> {
                let pairs = gauge.tracks.spans.iter().zip(&point.shots);
                pairs
                    .filter(|(span, _)| span.track == track && (!moving || span.moves))
                    .map(|(span, shot)| Sample {
                        t_s: &gauge.tracks.tracks[track].t_s[span.start..span.end],
                        residual: &shot.residual,
                        weight: shot.weight,
                    })
                    .collect()
            };
            let moving = of(true);
            likely(&if moving.len() < ENOUGH { of(false) } else { moving }, least)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use er_servo::Config;
    use er_servo::experiment::{Experiment, Shape};

    use super::*;
    use crate::effects::{Excitation, Physics, find};
    use crate::read::{Axis, AxisKind, ErNominal, Machine, PlantNominal};
    use crate::refit::{HORIZON_S, Probe, Windows, model};
    use crate::screen::Motion;
    use crate::simulate::{Disturbance, Reference, Setup, record, run};

    const RESOLUTION: f64 = std::f64::consts::TAU / 491_520.0;
    const PUSH: Disturbance = Disturbance { start_s: 1.1, duration_s: 0.1, torque_nm: 1.5 };

    fn nominal() -> Physics {
        let er = Some(ErNominal { a: 0.0704, b: 0.470, dead_time_s: 0.002, lag_s: 0.003 });
        Physics::nominal(&Machine {
            file: "machine.toml".into(),
            name: "test".to_owned(),
            axis: Axis { kind: AxisKind::Rotary, sample_period_s: 5e-4, resolution: RESOLUTION },
            plant: PlantNominal {
                inertia: 0.075,
                coulomb: 0.763,
                viscous: 0.0,
                torque_gain: 1.0,
                torque_offset: 0.0,
                torque_limit: Some(30.0),
                torque_delay_s: 0.005,
                er,
            },
            controller: None,
            columns: Default::default(),
            effects: Vec::new(),
        })
    }

    /// Steps of the closed loop around a machine, with torque noise.
    fn recorded(physics: &Physics, pushes: &[Disturbance]) -> Recording {
        let setup = Setup {
            model: model(physics, 0),
            config: Config::default(),
            disturbances: pushes.to_vec(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.05,
            seed: 3,
        };
        let shape = Shape::Steps { amplitude_rad: 0.8, dwell_s: 0.3, seed: 9 };
        let reference = Reference::Experiment(Experiment { shape, duration_s: 2.4 });
        record("steps.csv", &run(&setup, reference.positions(5e-4).unwrap()).unwrap())
    }

    fn problem(recording: &Recording) -> Problem {
        let nominal = nominal();
        Problem::new(vec![Motion::new(recording, &nominal, RESOLUTION)], 1, nominal)
    }

    fn active(id: &str, values: Vec<f64>) -> Active {
        let effect = find(id).unwrap();
        let sizes =
            Excitation { torque_rms: 1.0, torque_peak: 5.0, speed_peak: 5.0, travel: 1.0, ..Excitation::default() };
        Active { effect, ranges: effect.ranges(values.len(), &nominal(), &sizes), values }
    }

    #[test]
    fn a_level_of_friction_is_found_from_afar_down_to_the_noise() {
        let recording = recorded(&Physics { coulomb: 0.9, ..nominal() }, &[]);
        let start = [active("coulomb_friction", vec![0.7])];
        let fit = TimeFit::new(&problem(&recording), &[recording], &start, RESOLUTION).unwrap();
        assert!((fit.active[0].values[0] - 0.9).abs() < 4e-3, "{:?}", fit.active);
        assert!(fit.sse < 1.1 * fit.freedom && fit.sse < fit.start_sse && fit.far < 0.05, "{fit:?}");
        assert!((fit.blocks.iter().sum::<f64>() - fit.sse).abs() < 1e-6 * fit.sse);
        assert!(fit.heldout.iter().sum::<f64>() >= fit.sse * (1.0 - 1e-6));
    }

    #[test]
    fn from_the_optimum_nothing_gets_worse() {
        let recording = recorded(&Physics { torque_gain: 0.95, ..nominal() }, &[]);
        let problem = problem(&recording);
        let recordings = [recording];
        let first = TimeFit::new(&problem, &recordings, &[active("torque_gain", vec![0.95])], RESOLUTION).unwrap();
        let again = TimeFit::new(&problem, &recordings, &first.active, RESOLUTION).unwrap();
        assert!(first.sse <= first.start_sse && again.sse <= again.start_sse, "{first:?} {again:?}");
        assert!((first.active[0].values[0] - again.active[0].values[0]).abs() < 2e-4, "{first:?} {again:?}");
    }

    #[test]
    fn a_push_is_found_in_the_block_it_happens_in() {
        let recording = recorded(&nominal(), &[PUSH]);
        let start = [active("disturbance_pulse", vec![0.0, 1.097, 0.104, 1.3])];
        let fit = TimeFit::new(&problem(&recording), &[recording], &start, RESOLUTION).unwrap();
        let found = &fit.active[0].values;
        assert!((found[1] - 1.1).abs() < 2e-3 && (found[2] - 0.1).abs() < 4e-3, "{found:?}");
        assert!((found[3] - 1.5).abs() < 0.1 && fit.sse < 1.1 * fit.freedom, "{fit:?}");
    }

    #[test]
    fn a_push_that_is_seen_late_is_moved_to_its_begin() {
        let recordings = [recorded(&nominal(), &[PUSH])];
        let problem = problem(&recordings[0]);
        let push =
            |start_s: f64, duration_s: f64| vec![active("disturbance_pulse", vec![0.0, start_s, duration_s, 1.5])];
        let (right, late) = (push(1.1, 0.1), push(1.15, 0.05));
        let fit = TimeFit::new(&problem, &recordings, &right, RESOLUTION).unwrap();
        let probe = Probe::around(&problem, &recordings, &fit, 0).unwrap();
        let moved = probe.elsewhere(&late, 0).unwrap();
        assert!((moved[0].values[1] - 1.1).abs() < 2e-3 && (moved[0].values[2] - 0.1).abs() < 2e-3, "{moved:?}");
        assert_eq!(probe.elsewhere(&fit.active, 0), None);
        let [start, duration] = probe.reach(&fit.active, 0).unwrap();
        assert!(start.0 <= 1.1 && 1.1 <= start.1 && duration.0 <= 0.1 && 0.1 <= duration.1, "{start:?} {duration:?}");
        assert!(start.1 - start.0 < 0.02 && duration.1 - duration.0 < 0.02, "{start:?} {duration:?}");
    }

    /// A bristle and a load carry their state from window to window; without it the true machine fits worse than the
    /// nominal one.
    #[test]
    fn a_machine_with_memory_starts_its_windows_where_it_was() {
        let load = crate::effects::Load { resonance_hz: 40.0, damping_ratio: 0.03, inertia_ratio: 0.4, gap: 0.0 };
        let soft = Physics { presliding: 400.0, ..nominal() };
        let mut thick = nominal();
        thick.damper.as_mut().unwrap().preyield = 300.0;
        let loose = crate::effects::Load { gap: 1e-3, ..load };
        let behind = |load| Physics { load: Some(load), ..nominal() };
        for physics in [soft, thick, behind(load), behind(loose)] {
            let recordings = [recorded(&physics, &[])];
            let rms = |physics| Windows::new(physics, &recordings, 0, RESOLUTION, HORIZON_S).unwrap().rms();
            let (own, other) = (rms(&physics), rms(&nominal()));
            // Torque noise of 0.05 N m moves the rotor by 1e-5 rad off its best start within a window; on a bristle more.
            assert!(own < 3e-5 && own < 0.5 * other, "{own} {other} {physics:?}");
        }
    }
}
