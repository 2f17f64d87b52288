//! A finding and its sentence.

use std::fmt::{Display, Formatter};

use super::wrong_rate;
use crate::read::{AxisKind, Column, places};
use crate::report::Units;

/// Whether anything can be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Something can, but may mean something else than it seems.
    Warning,
    /// Nothing can.
    Error,
}

/// Something about one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Its name.
    pub recording: String,
    /// Its axis, which gives the units.
    pub axis: AxisKind,
    /// What.
    pub problem: Problem,
    /// Whether anything can be computed all the same.
    pub severity: Severity,
}

/// What is wrong; lengths in rad (m), efforts in N m (N), times in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Problem {
    /// The position stays within the steps and the noise of the sensor.
    NeverMoves {
        /// How far it goes.
        travel: f64,
    },
    /// The rows of an earlier recording again: counted twice, or judged on what was fitted.
    SameRows,
    /// Too little for the purpose.
    TooShort {
        /// There is.
        length_s: f64,
        /// Needed.
        needed_s: f64,
        /// Median of the rows.
        period_s: f64,
    },
    /// So many gaps that too little is left between them.
    Gaps {
        /// Number of them.
        gaps: usize,
        /// Left between them, s.
        left_s: f64,
        /// Needed, s.
        needed_s: f64,
    },
    /// Rows too far apart for any window.
    SlowSampling {
        /// Median of the rows.
        period_s: f64,
        /// Most that can be worked on.
        most_s: f64,
        /// As the machine file says.
        file_s: f64,
    },
    /// Rows apart by another order of magnitude than the machine file says.
    OtherPeriod {
        /// Median of the rows.
        period_s: f64,
        /// As the machine file says.
        file_s: f64,
    },
    /// A value that no machine and no unit has, and whose square may be no number.
    Huge {
        /// Where.
        column: Column,
        /// The largest, by size.
        value: f64,
        /// The most there is.
        most: f64,
    },
    /// The commanded torque or force is the same in every row.
    ConstantEffort {
        /// Its value.
        value: f64,
    },
    /// Torque and acceleration have opposite signs.
    SignFlipped {
        /// Partial correlation of the two, friction and gravity taken out; -1 to 1.
        correlation: f64,
    },
    /// Single positions that stand apart from both neighbours.
    WrongSamples {
        /// How many.
        count: usize,
        /// The row of the first, counted from 0, and by how much it is off.
        first: (usize, f64),
    },
    /// Faster than any such machine.
    Speed {
        /// The highest, a few wrong rows set aside.
        value: f64,
        /// The most there is.
        most: f64,
    },
    /// Accelerates more than any such machine.
    Acceleration {
        /// The highest, a few wrong rows set aside.
        value: f64,
        /// The most there is.
        most: f64,
    },
    /// The position moves in other steps than the machine file says.
    OtherStep {
        /// Step of the position.
        step: f64,
        /// As the machine file says.
        resolution: f64,
    },
    /// The inertia is far from a first estimate.
    Inertia {
        /// Least that the data allow, kg m2 (kg).
        low: f64,
        /// Most that they allow.
        high: f64,
        /// As the machine file says.
        nominal: f64,
    },
}

/// A factor between a wrong unit and the right one is recognised within this factor: estimates are rough.
const NEAR: f64 = 2.5;

impl Finding {
    /// The column it is about.
    pub fn column(&self) -> Option<&'static str> {
        let column = match self.problem {
            Problem::NeverMoves { .. }
            | Problem::WrongSamples { .. }
            | Problem::Speed { .. }
            | Problem::Acceleration { .. }
            | Problem::OtherStep { .. } => Column::Position,
            Problem::Huge { column, .. } => column,
            Problem::Gaps { .. } | Problem::SlowSampling { .. } | Problem::OtherPeriod { .. } => Column::Time,
            Problem::ConstantEffort { .. } | Problem::SignFlipped { .. } => Column::EffortCmd,
            Problem::SameRows | Problem::TooShort { .. } | Problem::Inertia { .. } => return None,
        };
        Some(column.name(self.axis))
    }

    /// The sentence without the recording and the column.
    // Over 40 lines: one table of sentences.
    pub fn problem_text(&self) -> String {
        let units = Units::of(self.axis);
        let (position, speed, effort) = (units.position, units.speed, units.effort);
        let acceleration = format!("{speed}2");
        let (inertia, effort_name, rotary) = match self.axis {
            AxisKind::Rotary => ("kg m2", "torque", true),
            AxisKind::Linear => ("kg", "force", false),
        };
        let in_ms = |ratio: f64| if is_near(ratio, 1e3) { "; is the time in ms?" } else { "" };
        let wrong_unit =
            if rotary { "the position in degrees, or the time in another unit" } else { "the position in mm" };
        match self.problem {
            Problem::NeverMoves { travel } => {
                format!(
                    "the axis never moves ({travel:.1e} {position} from end to end), beyond the steps and the noise of its sensor; \
                     record a motion"
                )
            }
            Problem::SameRows => {
                "its rows are those of another recording that is given; give each once: what was fitted cannot \
                                  be held out"
                    .to_owned()
            }
            Problem::TooShort { length_s, needed_s, period_s } => {
                let wrong = wrong_rate(period_s).map(|wrong| format!("{:.0} Hz is {wrong}", 1.0 / period_s));
                let wrong = wrong.unwrap_or_else(|| "record longer".to_owned());
                format!("{length_s:.3} s is too short, at least {needed_s:.1} s is needed; {wrong}")
            }
            Problem::Gaps { gaps, left_s, needed_s } => format!(
                "rows are missing in {}, and after each what was commanded meanwhile still acts: {left_s:.3} s are left, \
                 at least {needed_s:.1} s are needed; record without losing rows, or, of rows thinned out on purpose, leave out \
                 the column seq",
                places(gaps)
            ),
            Problem::SlowSampling { period_s, most_s, file_s } => {
                let unit = in_ms(period_s / file_s);
                format!("rows are {period_s} s apart, at most {most_s} s can be worked on{unit}")
            }
            Problem::OtherPeriod { period_s, file_s } => {
                let unit = in_ms(period_s / file_s);
                format!("rows are {period_s:.3e} s apart, and `sample_period_s` of the machine file is {file_s}{unit}")
            }
            Problem::Huge { value, most, .. } => {
                format!("{value:.1e} is a value of no machine (at most {most:.0e}); is it a wrong sample?")
            }
            Problem::ConstantEffort { value } => {
                format!(
                    "the {effort_name} is {value} {effort} in every row; without a command nothing tells the inertia"
                )
            }
            Problem::SignFlipped { correlation } => format!(
                "{effort_name} and acceleration have opposite signs (correlation {correlation:.2} once friction and gravity are \
                 out of it): the sign of this column or of the position is turned round"
            ),
            Problem::WrongSamples { count, first: (row, off) } => format!(
                "single samples stand apart from both neighbours in {}, the first in row {} by {off:.2e} {position}: where the \
                 torque may be a measurement they are taken for noise; leave those rows out, for rows that are missing do no harm",
                places(count),
                row + 1
            ),
            Problem::Speed { value, most } => {
                format!(
                    "speeds of {value:.2e} {speed} are those of no such machine (at most {most:.0e}); is {wrong_unit}?"
                )
            }
            Problem::Acceleration { value, most } => format!(
                "accelerations of {value:.2e} {acceleration} are those of no such machine (at most {most:.0e}); is {wrong_unit}?"
            ),
            Problem::OtherStep { step, resolution } => format!(
                "the position moves in steps of {step:.3e} {position}, and `resolution` of the machine file is {resolution:.3e}; is \
                 it of this sensor, and in {position}?"
            ),
            Problem::Inertia { low, high, nominal } => {
                let ratio = if low > nominal { low / nominal } else { high / nominal };
                let unit = wrong_units(ratio, rotary).map_or_else(String::new, |unit| format!("; {unit}?"));
                format!(
                    "{effort_name} and acceleration ask for an inertia of {low:.2e} to {high:.2e} {inertia}, and that of the machine \
                     file is {nominal}{unit}"
                )
            }
        }
    }
}

/// The unit that makes an inertia wrong by this factor.
fn wrong_units(ratio: f64, rotary: bool) -> Option<&'static str> {
    let known = [
        (1e-3, false, "is the position in mm"),
        (1.0 / 57.3, true, "is the position in degrees"),
        (1e-3, true, "is the position in mrad, or the inertia in g m2"),
        (1e6, false, "is the time in ms"),
        (1e6, true, "is the time in ms"),
        (1e3, false, "is the force in mN, or the inertia in t"),
        (1e3, true, "is the torque in mN m"),
        (1e-4, true, "is the inertia in kg cm2"),
    ];
    known
        .into_iter()
        .find(|(factor, of_rotary, _)| *of_rotary == rotary && is_near(ratio, *factor))
        .map(|known| known.2)
}

fn is_near(value: f64, factor: f64) -> bool {
    (1.0 / NEAR..NEAR).contains(&(value / factor))
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: ", self.recording)?;
        self.column().map_or(Ok(()), |column| write!(f, "{column}: "))?;
        f.write_str(&self.problem_text())
    }
}
