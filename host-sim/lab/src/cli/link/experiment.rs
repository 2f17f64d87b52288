//! Experiments of the image, from flags in the user's units.

use er_servo::experiment::{self, Experiment, MAX_TONES};

use crate::Error;
use crate::cli::examples::link as examples;
use crate::cli::experiment_flags::refused;

/// What the reference does.
#[derive(Debug, clap::Subcommand)]
pub enum Shape {
    /// One step at once.
    #[command(after_help = examples::STEP)]
    Step {
        /// Height, degrees.
        #[arg(long, default_value_t = 30.0, allow_negative_numbers = true)]
        amplitude_deg: f32,
        /// Duration, s.
        #[arg(long, default_value_t = 2.0)]
        duration_s: f32,
    },
    /// A new level within the amplitude after each dwell.
    #[command(after_help = examples::STEPS)]
    Steps {
        /// Largest level either way, degrees.
        #[arg(long, default_value_t = 30.0)]
        amplitude_deg: f32,
        /// Time at each level, s.
        #[arg(long, default_value_t = 0.4)]
        dwell_s: f32,
        /// Of the draw.
        #[arg(long, default_value_t = 1)]
        seed: u32,
        /// Duration, s.
        #[arg(long, default_value_t = 10.0)]
        duration_s: f32,
    },
    /// Equal tones spaced evenly over a band.
    #[command(after_help = examples::MULTISINE)]
    Multisine {
        /// Bound of the sum either way, degrees.
        #[arg(long, default_value_t = 10.0)]
        amplitude_deg: f32,
        /// Lowest tone, Hz.
        #[arg(long, visible_alias = "from-hz", default_value_t = 0.2)]
        low_hz: f32,
        /// Highest tone, Hz.
        #[arg(long, visible_alias = "to-hz", default_value_t = 8.0)]
        high_hz: f32,
        /// Number of tones.
        #[arg(long, default_value_t = MAX_TONES)]
        tones: u8,
        /// Duration, s.
        #[arg(long, default_value_t = 20.0)]
        duration_s: f32,
    },
    /// One sine whose frequency runs evenly from one end to the other.
    #[command(after_help = examples::CHIRP)]
    Chirp {
        /// Amplitude, degrees.
        #[arg(long, default_value_t = 10.0)]
        amplitude_deg: f32,
        /// Frequency at the start, Hz.
        #[arg(long, visible_alias = "low-hz", default_value_t = 0.2)]
        from_hz: f32,
        /// Frequency at the end, Hz.
        #[arg(long, visible_alias = "high-hz", default_value_t = 8.0)]
        to_hz: f32,
        /// Duration, s.
        #[arg(long, default_value_t = 20.0)]
        duration_s: f32,
    },
    /// To and fro at constant speed.
    #[command(after_help = examples::RAMP)]
    Ramp {
        /// Speed, rad/s.
        #[arg(long, default_value_t = 1.0)]
        speed_rad_s: f32,
        /// Turning point, degrees.
        #[arg(long, visible_alias = "amplitude-deg", default_value_t = 30.0)]
        travel_deg: f32,
        /// Duration, s.
        #[arg(long, default_value_t = 10.0)]
        duration_s: f32,
    },
}

impl Shape {
    /// The experiment, checked for a drive of that control period, s.
    ///
    /// # Errors
    /// The first value out of its range.
    pub fn experiment(&self, period_s: f32) -> Result<Experiment, Error> {
        let (shape, duration_s) = match *self {
            Self::Step { amplitude_deg, duration_s } => {
                (experiment::Shape::Step { amplitude_rad: amplitude_deg.to_radians() }, duration_s)
            }
            Self::Steps { amplitude_deg, dwell_s, seed, duration_s } => {
                (experiment::Shape::Steps { amplitude_rad: amplitude_deg.to_radians(), dwell_s, seed }, duration_s)
            }
            Self::Multisine { amplitude_deg, low_hz, high_hz, tones, duration_s } => {
                let amplitude_rad = amplitude_deg.to_radians();
                (experiment::Shape::Multisine { amplitude_rad, low_hz, high_hz, tones }, duration_s)
            }
            Self::Chirp { amplitude_deg, from_hz, to_hz, duration_s } => {
                (experiment::Shape::Chirp { amplitude_rad: amplitude_deg.to_radians(), from_hz, to_hz }, duration_s)
            }
            Self::Ramp { speed_rad_s, travel_deg, duration_s } => {
                (experiment::Shape::Ramp { speed_rad_s, travel_rad: travel_deg.to_radians() }, duration_s)
            }
        };
        let experiment = Experiment { shape, duration_s };
        experiment.start(period_s).map_err(|error| refused(&error, &[]))?;
        Ok(experiment)
    }
}
