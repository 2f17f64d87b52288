//! What may predict: smooth functions of a channel, as torques.

use crate::hypothesis::Kept;
use crate::problem::Problem;

/// One value a row of each recording.
type Rows = Vec<Vec<f64>>;

/// What may predict what is left.
pub(super) struct Channel {
    pub(super) name: &'static str,
    functions: Functions,
}

enum Functions {
    /// Torques, N m (N).
    Torques(Vec<Rows>),
    /// What stands in the whitened residual itself.
    Whitened(Vec<Rows>),
}

/// Rows over which a command changes.
const RATE_ROWS: usize = 5;
/// Past rows from which a residual may be predicted, in groups that grow: a noise with a memory shows in one of them.
const PAST_ROWS: [(usize, usize); 4] = [(1, 1), (2, 3), (4, 7), (8, 15)];

impl Channel {
    /// Torques of the size of `unit` that are functions of a channel: `factor` times Legendre polynomials of the channel's ranks, of
    /// degrees 1 to 3: what grows, bends, and comes back.
    fn new(name: &'static str, unit: f64, ranks: &Rows, factor: Option<&Rows>) -> Self {
        let largest = factor.map_or(1.0, largest).max(f64::MIN_POSITIVE);
        let function = |polynomial: fn(f64) -> f64| -> Rows {
            let of = |(index, ranks): (usize, &Vec<f64>)| -> Vec<f64> {
                let factor = |row: usize| factor.map_or(1.0, |factor| factor[index][row] / largest);
                ranks.iter().enumerate().map(|(row, rank)| unit * factor(row) * polynomial(*rank)).collect()
            };
            ranks.iter().enumerate().map(of).collect()
        };
        let polynomials: [fn(f64) -> f64; 3] =
            [|u| u, |u| 0.5 * (3.0 * u * u - 1.0), |u| 0.5 * u * (5.0 * u * u - 3.0)];
        Self { name, functions: Functions::Torques(polynomials.map(function).to_vec()) }
    }

    /// The columns of the whitened residual that its functions make, recordings one behind the other.
    pub(super) fn columns(&self, problem: &Problem, path: &Kept) -> Vec<Vec<f64>> {
        match &self.functions {
            Functions::Whitened(all) => all.iter().map(|function| function.concat()).collect(),
            Functions::Torques(all) => {
                let respond = |function: &Rows| -> Vec<f64> {
                    let of = |(index, torques): (usize, &Vec<f64>)| path.response_to_torque(problem, index, torques);
                    function.iter().enumerate().flat_map(of).collect()
                };
                all.iter().map(respond).collect()
            }
        }
    }

    /// Root mean square of the torque that is predicted by these coefficients of its functions, N m (N); none where they are none.
    pub(super) fn torque_rms(&self, coefficients: &[f64]) -> Option<f64> {
        let Functions::Torques(all) = &self.functions else { return None };
        let (mut squares, mut count) = (0.0, 0_usize);
        for (index, first) in all[0].iter().enumerate() {
            for row in 0..first.len() {
                let torque: f64 = all.iter().zip(coefficients).map(|(function, by)| by * function[index][row]).sum();
                squares += torque * torque;
                count += 1;
            }
        }
        Some((squares / count.max(1) as f64).sqrt())
    }
}

/// Every channel of these recordings.
pub(super) fn channels(problem: &Problem, path: &Kept) -> Vec<Channel> {
    let of = |value: &dyn Fn(usize, usize) -> f64| -> Rows {
        (0..path.recordings.len())
            .map(|index| (0..problem.recordings[index].rows()).map(|row| value(index, row)).collect())
            .collect()
    };
    // Without any torque in the column a torque of one serves as well: columns are linear in it.
    let unit = if problem.excitation.torque_rms > 0.0 { 0.01 * problem.excitation.torque_rms } else { 1.0 };
    // A command is made of the very sample that the innovation holds: only what was there before may predict.
    let command = |index: usize, row: usize| problem.recordings[index].commands[row.saturating_sub(1)];
    let innovations = |index: usize| &path.recordings[index].innovations;
    let change = |value: &dyn Fn(usize) -> f64, row: usize| value(row) - value(row.saturating_sub(RATE_ROWS));
    let speed = of(&|index, row| innovations(index).speed[row.saturating_sub(1)]);
    let direction: Rows = speed.iter().map(|rows| rows.iter().map(|speed| speed.signum()).collect()).collect();
    // By rank, where no value itself is needed.
    let position = ranks(&of(&|index, row| innovations(index).position[row]));
    let time = ranks(&of(&|index, row| problem.recordings[index].t_s[row]));
    let torque = of(&|index, row| command(index, row).torque);
    let load: Rows = torque.iter().map(|rows| rows.iter().map(|torque| torque.abs()).collect()).collect();
    let torque_rate = of(&|index, row| change(&|row| command(index, row).torque, row));
    let past = |(nearest, farthest): (usize, usize)| {
        let whitened = |index: usize, row: usize| {
            if innovations(index).counted[row] { innovations(index).whitened[row] } else { 0.0 }
        };
        of(&|index, row| (nearest..=farthest).filter(|lag| row >= *lag).map(|lag| whitened(index, row - lag)).sum())
    };
    let own_past = Functions::Whitened(PAST_ROWS.map(past).to_vec());
    let mut all = vec![
        Channel::new("speed", unit, &ranks(&speed), None),
        Channel::new("position", unit, &position, None),
        Channel::new("position_by_direction", unit, &position, Some(&direction)),
        Channel::new("position_by_torque", unit, &position, Some(&torque)),
        Channel::new("torque", unit, &ranks(&torque), None),
        Channel::new("torque_by_direction", unit, &ranks(&load), Some(&direction)),
        Channel::new("torque_rate", unit, &ranks(&torque_rate), None),
        Channel::new("time", unit, &time, None),
        Channel::new("time_by_direction", unit, &time, Some(&direction)),
        Channel::new("time_by_speed", unit, &time, Some(&speed)),
        Channel::new("time_by_torque", unit, &time, Some(&torque)),
        Channel { name: "own_past", functions: own_past },
    ];
    if problem.excitation.field_peak > 0.0 {
        let field = of(&|index, row| command(index, row).field_kv_mm);
        let field_rate = of(&|index, row| change(&|row| command(index, row).field_kv_mm, row));
        let braked: Rows =
            field.iter().zip(&direction).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).collect()).collect();
        all.push(Channel::new("field_by_direction", unit, &ranks(&field), Some(&direction)));
        all.push(Channel::new("field_rate_by_direction", unit, &ranks(&field_rate), Some(&direction)));
        all.push(Channel::new("time_by_field", unit, &time, Some(&braked)));
    }
    all
}

/// Each value's rank among all, from -1 to 1: polynomials of it hang on no outlier and on no unit.
fn ranks(channel: &Rows) -> Rows {
    let mut sorted: Vec<f64> = channel.concat();
    sorted.sort_by(f64::total_cmp);
    let most = sorted.len().max(1) as f64;
    let rank = |value: &f64| {
        let below = sorted.partition_point(|other| other < value);
        let up_to = sorted.partition_point(|other| other <= value);
        (below + up_to) as f64 / most - 1.0
    };
    channel.iter().map(|rows| rows.iter().map(rank).collect()).collect()
}

fn largest(rows: &Rows) -> f64 {
    rows.iter().flatten().map(|value| value.abs()).fold(0.0, f64::max)
}
