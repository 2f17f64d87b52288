//! Where the missing torque has structure: orders over position, tones and pushes over time, read off the adjoint.

use plant::effects::Pulse;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use crate::effects::Excitation;
use crate::hypothesis::{Kept, KeptRecording};
use crate::likelihood::Grid;
use crate::likelihood::filter::{HUBER, Innovations, loss};
use crate::likelihood::inverse::Motion;
use crate::physics::Tone;
use crate::problem::Problem;

use super::orders::{HIGHEST_ORDER, MOST, orders, peaks};

/// Lengths of pushes that are looked for, s.
const PUSHES_S: [f64; 7] = [0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64];

/// Lengths of pushes that are told apart: each is twice the one before, and sums over half a window go along with it.
const INDEPENDENT_LENGTHS: usize = 3;

/// What the motion excites, with the orders, tones and pushes that stand out of what a pass leaves.
pub(crate) fn seek(problem: &Problem, path: &Kept) -> Excitation {
    let missing: Vec<Missing<'_>> =
        path.recordings.iter().enumerate().map(|(index, kept)| of_recording(problem, path, index, kept)).collect();
    let mut excitation = problem.excitation.clone();
    excitation.orders = orders(weighted(&missing, |_, _| 1.0), &problem.excitation);
    // A ripple's missing torque goes along with the drive's.
    excitation.ripple_orders = orders(weighted(&missing, |one, row| one.drive[row]), &problem.excitation);
    excitation.tones = tones(&missing, excitation.recordings, problem.band_hz());
    excitation.pulses = pushes(&missing, problem.motions.first().map_or(0.0, Motion::support_s));
    excitation.glitch = glitch(path);
    let rows = missing.iter().map(|one| one.torque.len()).max().unwrap_or(0) as f64;
    excitation.field_least = field_least(problem);
    excitation.looked_at = [HIGHEST_ORDER as f64, rows, rows * PUSHES_S.len() as f64];
    excitation
}

/// Smallest field above 0 that is commanded where a hypothesis is fitted, kV/mm; 0 where there is none.
fn field_least(problem: &Problem) -> f64 {
    let commands = problem.recordings[..problem.fitted].iter().flat_map(|recorded| &recorded.commands);
    let least = commands.map(|command| command.field_kv_mm).filter(|&field| field > 0.0).reduce(f64::min);
    least.unwrap_or(0.0)
}

fn of_recording<'a>(problem: &'a Problem, path: &Kept, index: usize, kept: &'a KeptRecording) -> Missing<'a> {
    let grid = &problem.grids[index];
    let fine = path.missing_torque(problem, index);
    // One value a row: the sum over its substeps.
    let rows = |fine: &[f64]| -> Vec<f64> {
        let sum = |row: usize| fine[grid.first[row] as usize..grid.first[row + 1] as usize].iter().sum();
        (0..grid.dt_s.len()).map(sum).collect()
    };
    Missing {
        torque: rows(&fine),
        drive: mean_over_rows(&kept.acting.drive.drive, grid),
        misfit: misfit(problem, &kept.innovations),
        position: &kept.innovations.position,
        t_s: &problem.recordings[index].t_s,
    }
}

/// By how much each row's innovation is less likely than expected, with its sign; nothing where the motion is given and all of the torque
/// is seen.
fn misfit(problem: &Problem, innovations: &Innovations) -> Vec<(f64, f64)> {
    if !problem.motions.is_empty() {
        return Vec::new();
    }
    let of = |(&whitened, &counted): (&f64, &bool)| if counted { (loss(whitened) - 1.0, whitened) } else { (0.0, 0.0) };
    innovations.whitened.iter().zip(&innovations.counted).map(of).collect()
}

/// Wrong samples that make a habit and no accident.
const FEWEST_GLITCHES: usize = 3;

/// Share and median size of samples that stand out of their neighbours on both sides.
fn glitch(path: &Kept) -> Option<(f64, f64)> {
    let (mut sizes, mut rows) = (Vec::new(), 0);
    for kept in &path.recordings {
        let found = &kept.innovations;
        rows += found.whitened.len();
        for row in 1..found.whitened.len().saturating_sub(1) {
            let [before, here, behind] = [row - 1, row, row + 1].map(|row| found.whitened[row].abs());
            if found.counted[row] && here > HUBER && before < 0.5 * here && behind < 0.5 * here {
                sizes.push(found.innovation[row].abs());
            }
        }
    }
    let middle = sizes.len() / 2;
    let share = sizes.len() as f64 / rows.max(1) as f64;
    (sizes.len() >= FEWEST_GLITCHES).then(|| (share, *sizes.select_nth_unstable_by(middle, f64::total_cmp).1))
}

/// What a pass says is missing in one recording, one value a row.
struct Missing<'a> {
    /// Torque, of no certain scale.
    torque: Vec<f64>,
    /// The drive's, N m (N).
    drive: Vec<f64>,
    /// How much less likely than expected a row is, and its whitened innovation; none where the motion is given.
    misfit: Vec<(f64, f64)>,
    /// rad (m).
    position: &'a [f64],
    /// s.
    t_s: &'a [f64],
}

/// The missing torque of all rows with a weight of its row, and the position of each.
fn weighted(missing: &[Missing<'_>], weight: fn(&Missing<'_>, usize) -> f64) -> impl Iterator<Item = (f64, f64)> {
    missing.iter().flat_map(move |one| {
        let rows = one.torque.iter().zip(one.position).enumerate();
        rows.map(move |(row, (torque, position))| (torque * weight(one, row), *position))
    })
}

/// One value a row from one a substep.
fn mean_over_rows(values: &[f64], grid: &Grid) -> Vec<f64> {
    let row = |pair: &[u32]| {
        let of = &values[pair[0] as usize..pair[1] as usize];
        of.iter().sum::<f64>() / of.len().max(1) as f64
    };
    grid.first.windows(2).map(row).collect()
}

/// Tones of the missing torque over time, best first, without amplitudes, within the band that is judged.
fn tones(missing: &[Missing<'_>], recordings: usize, band_hz: Option<f64>) -> Vec<Tone> {
    let Some(longest) = missing.iter().max_by_key(|one| one.torque.len()) else { return Vec::new() };
    let (rows, duration_s) = (longest.torque.len(), longest.t_s[longest.torque.len()] - longest.t_s[0]);
    let length = (2 * rows).next_power_of_two();
    let dt_s = duration_s / rows.max(1) as f64;
    let fft = FftPlanner::new().plan_fft_forward(length);
    let mut power = vec![0.0; length / 2];
    for one in missing {
        let mut even = vec![Complex::new(0.0, 0.0); length];
        for (torque, t_s) in one.torque.iter().zip(one.t_s) {
            let at = ((t_s - one.t_s[0]) / dt_s).round() as usize;
            if let Some(cell) = even.get_mut(at) {
                cell.re += torque;
            }
        }
        fft.process(&mut even);
        power.iter_mut().zip(&even).for_each(|(power, value)| *power += value.norm_sqr());
    }
    // Below three periods in the longest recording a tone is no tone.
    let lowest = (3.0 * length as f64 * dt_s / duration_s).ceil() as usize;
    let highest = band_hz.map_or(power.len(), |hz| (hz * length as f64 * dt_s).floor() as usize);
    power.truncate(highest);
    let from = lowest.min(power.len());
    let tone = |index: usize| Tone {
        frequency_hz: (from + index) as f64 / (length as f64 * dt_s),
        phasors: vec![(0.0, 0.0); recordings],
    };
    peaks(&power[from..], 1).into_iter().map(tone).collect()
}

/// Stretches whose missing torque sums to most, for their length, and those that are least likely, best first. A torque that the rotor at
/// rest under this hypothesis does not feel, or that makes the belief lose it, is no large sum.
fn pushes(missing: &[Missing<'_>], smeared_s: f64) -> Vec<(usize, Pulse, f64)> {
    // Test functions smear a push over their own support, and only they do.
    let given = smeared_s > 0.0;
    let by_chance: ByChance = if given { of_a_heavy_tail } else { of_an_exponential_tail };
    let mut found: Vec<(usize, Pulse, f64)> = Vec::new();
    for (recording, one) in missing.iter().enumerate() {
        let torque = Summed::of(one.torque.iter().copied());
        let unlikely = Summed::of(one.misfit.iter().map(|of| of.0));
        let signed = Summed::of(one.misfit.iter().map(|of| of.1));
        let period_s = (one.t_s[one.torque.len()] - one.t_s[0]) / one.torque.len().max(1) as f64;
        for length_s in PUSHES_S {
            let many = (length_s / period_s).round() as usize;
            if many < 2 || 4 * many > one.torque.len() {
                continue;
            }
            let distance = many + many / 2 + (smeared_s / period_s).ceil() as usize;
            let mut found_in = |sums: Vec<f64>, sign: &[f64]| {
                let peaks = apart(&sums, distance);
                let Some(&best) = peaks.first() else { return };
                let duration_s = many as f64 * period_s;
                let pulse = Pulse { start_s: one.t_s[best], duration_s, amplitude: sign[best].signum() };
                let sizes: Vec<f64> = peaks.iter().map(|&at| sums[at]).collect();
                found.push((recording, pulse, by_chance(&sizes)));
            };
            let torques = torque.windows(many);
            found_in(torques.iter().map(|sum| sum.abs()).collect(), &torques);
            found_in(unlikely.windows(many), &signed.windows(many));
        }
    }
    let kinds_of_sum = if given { 1 } else { 2 };
    let tried = kinds_of_sum * missing.len() * INDEPENDENT_LENGTHS;
    found.iter_mut().for_each(|(.., chance)| *chance = (*chance * tried as f64).min(1.0));
    found.sort_by(|a, b| a.2.total_cmp(&b.2));
    found.truncate(MOST);
    if given { found } else { found.iter().map(|own| of_the_place(own, &found)).collect() }
}

/// With the least chance of those that it meets: an event stands out in a stretch of one length, and how long it is the likelihood knows
/// better.
fn of_the_place(own: &(usize, Pulse, f64), all: &[(usize, Pulse, f64)]) -> (usize, Pulse, f64) {
    let (recording, pulse, chance) = own;
    let end_s = |pulse: &Pulse| pulse.start_s + pulse.duration_s;
    let meets = |(of, other, _): &&(usize, Pulse, f64)| {
        of == recording && other.start_s < end_s(pulse) && pulse.start_s < end_s(other)
    };
    (*recording, *pulse, all.iter().filter(meets).map(|(.., chance)| *chance).fold(*chance, f64::min))
}

/// Sums from the first of some values to each.
struct Summed(Vec<f64>);

impl Summed {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut sums = vec![0.0];
        for value in values {
            sums.push(sums[sums.len() - 1] + value);
        }
        Self(sums)
    }

    /// The sum of every so many neighbours.
    fn windows(&self, many: usize) -> Vec<f64> {
        self.0.iter().zip(self.0.iter().skip(many)).map(|(from, to)| to - from).collect()
    }
}

/// Places of the largest sums that are more than that many rows apart, largest first.
fn apart(windows: &[f64], rows: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..windows.len()).collect();
    order.sort_by(|a, b| windows[*b].total_cmp(&windows[*a]));
    let mut kept: Vec<usize> = Vec::new();
    for index in order {
        if kept.iter().all(|other| index.abs_diff(*other) > rows) {
            kept.push(index);
        }
        if kept.len() == TAIL + 1 {
            break;
        }
    }
    kept
}

/// Most extremes that the tail is fitted to.
const TAIL: usize = 12;

/// Probability that chance has the largest of some extremes that far beyond the second, with their sizes, largest first, and the tail of
/// the others.
type ByChance = fn(&[f64]) -> f64;

/// Where the motion is given, all that the model leaves stands in for noise: its tail is heavy, as Hill's estimator (1975) fits it, so
/// that it has no events for its own. It takes the fitted tail for the true one and asks for all of [`TAIL`].
fn of_a_heavy_tail(sizes: &[f64]) -> f64 {
    if sizes.len() < TAIL + 1 {
        return 1.0;
    }
    let last = sizes[TAIL].max(f64::MIN_POSITIVE);
    let logs: f64 = sizes[1..TAIL].iter().map(|size| (size / last).ln()).sum();
    let tail_index = (TAIL - 1) as f64 / logs.max(1e-9);
    (sizes[0] / sizes[1].max(f64::MIN_POSITIVE)).powf(-tail_index)
}

/// Where the motion is predicted, noise is what moves it and the tail of its sums is no heavier than an exponential. Spacings of an exponential
/// tail's order statistics, each times its rank, are independent of one mean (Renyi 1953), so that the first over the mean of `k`
/// others is an F of 2 and 2k degrees of freedom.
fn of_an_exponential_tail(sizes: &[f64]) -> f64 {
    let Some((last, before)) = sizes.split_last().filter(|_| sizes.len() > 2) else { return 1.0 };
    let others = before.len() - 1;
    let spacings: f64 = before[1..].iter().map(|size| size - last).sum::<f64>() + before[1] - last;
    let over_the_mean = (before[0] - before[1]) / spacings.max(f64::MIN_POSITIVE);
    (1.0 + over_the_mean).powi(-(others as i32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_that_is_far_beyond_an_exponential_tail_is_no_chance() {
        // Spacings of one mean: the first is as long as the others.
        let sizes: Vec<f64> =
            (1..=13).map(|rank| (1..rank).map(|of| -1.0 / f64::from(of)).sum::<f64>() + 4.0).collect();
        let ordinary = of_an_exponential_tail(&sizes);
        // A spacing of the mean has the chance (1 + 1/11)^-11.
        assert!((ordinary - (1.0_f64 + 1.0 / 11.0).powi(-11)).abs() < 1e-12, "{ordinary}");
        let far = of_an_exponential_tail(&[&[sizes[0] + 30.0], &sizes[1..]].concat());
        assert!(far < 1e-5, "{far}");
    }

    #[test]
    fn few_others_make_nothing_certain() {
        assert_eq!(of_an_exponential_tail(&[9.0, 1.0]), 1.0);
        assert!(of_an_exponential_tail(&[9.0, 1.0, 0.5]) > 0.05);
        assert_eq!(of_a_heavy_tail(&[9.0, 1.0, 0.5]), 1.0);
    }

    #[test]
    fn a_heavy_tail_has_no_event_where_an_exponential_one_has() {
        let mut sizes: Vec<f64> = (1..=13).map(|rank| 1.0 / f64::from(rank)).collect();
        sizes[0] = 3.0;
        assert!(of_a_heavy_tail(&sizes) > 0.01 && of_an_exponential_tail(&sizes) < of_a_heavy_tail(&sizes));
    }

    #[test]
    fn a_place_has_the_least_chance_of_what_meets_there() {
        let push = |start_s, chance| (0, Pulse { start_s, duration_s: 0.1, amplitude: 1.0 }, chance);
        let all = [push(1.0, 0.5), push(1.05, 0.01), push(3.0, 0.2)];
        let chances = all.map(|own| of_the_place(&own, &all).2);
        assert_eq!(chances, [0.01, 0.01, 0.2]);
    }
}
