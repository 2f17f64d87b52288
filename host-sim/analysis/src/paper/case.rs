//! One run of the flashed law on the plant, and the figures a claim is judged by.

use er_servo::{Config, Counts};
use plant::{Er, FieldResponse, FluidResponse, Model};

use crate::simulate::{Disturbance, Row, Setup, Summary, run};
use crate::stability::NormalisedGains;
use recording::Error;

/// J, kg m2 (control.md section 1).
pub const INERTIA_KG_M2: f64 = 0.075;
/// c of equation (1), the dry friction of the rotor, N m.
pub const COULOMB_NM: f64 = 0.763;
/// L of control.md section 4, s; the paper does not say it.
pub const DELAY_S: f64 = 0.005;
/// The step of control.md section 7, 30 degrees, rad.
pub const STEP_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// The push of control.md section 7 on a rotor at rest.
pub const PUSH: Disturbance = Disturbance { start_s: 0.1, duration_s: 0.05, torque_nm: 8.0 };

/// The delay models of control.md section 7, in its order, and Q without delay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fluid {
    /// The damper is not energised.
    Off,
    /// No delay.
    None,
    /// No delay, through the channel of Q: [`Self::None`] holds the field between two ticks, this one the viscosity.
    QNone,
    /// Dead time of Q, 5 ms (Fig. 12).
    QDead5,
    /// Dead time of Q, 50 ms (Fig. 13).
    QDead50,
    /// Lag of Q, 5 ms (Fig. 15).
    QLag5,
    /// Dead time of E, 5 ms (Fig. 14).
    EDead5,
    /// Lag of E, 5 ms (Fig. 16).
    ELag5,
    /// Dead time 2 ms and lag 3 ms of E (Fig. 17).
    EDead2Lag3,
}

impl Fluid {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Off,
        Self::None,
        Self::QNone,
        Self::QDead5,
        Self::QDead50,
        Self::QLag5,
        Self::EDead5,
        Self::ELag5,
        Self::EDead2Lag3,
    ];

    /// In tables and legends.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "ER off",
            Self::None => "no delay",
            Self::QNone => "no delay of Q",
            Self::QDead5 => "Q dead 5 ms",
            Self::QDead50 => "Q dead 50 ms",
            Self::QLag5 => "Q lag 5 ms",
            Self::EDead5 => "E dead 5 ms",
            Self::ELag5 => "E lag 5 ms",
            Self::EDead2Lag3 => "E dead 2 + lag 3 ms",
        }
    }

    /// Whether its delay is one of the viscosity, so that the two readings differ.
    #[must_use]
    pub fn delays_viscosity(self) -> bool {
        matches!(self, Self::QDead5 | Self::QDead50 | Self::QLag5)
    }

    fn response(self, reading: Reading) -> FluidResponse {
        let torque_limit = match reading {
            Reading::AsAFluid => Er::largest_torque(A, B),
            Reading::AsPrinted => f64::INFINITY,
        };
        let field = |dead_time_s, lag_s| FluidResponse::Field(FieldResponse::new(dead_time_s, lag_s));
        match self {
            Self::Off | Self::None => field(0.0, 0.0),
            Self::QNone => FluidResponse::ViscosityDeadTime { dead_time_s: 0.0, torque_limit },
            Self::QDead5 => FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit },
            Self::QDead50 => FluidResponse::ViscosityDeadTime { dead_time_s: 0.05, torque_limit },
            Self::QLag5 => FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit },
            Self::EDead5 => field(0.005, 0.0),
            Self::ELag5 => field(0.0, 0.005),
            Self::EDead2Lag3 => field(0.002, 0.003),
        }
    }
}

/// a of equation (1), N m per (kV/mm)^2.
pub const A: f64 = 0.0704;
/// b of equation (1), N m per kV/mm.
pub const B: f64 = 0.470;

/// How (6) and (7), the delays of the viscosity, are read. A late coefficient times a high speed is any torque: with the
/// step of 30 degrees 28.7 N m after 5 ms and 571 N m after 50 ms, where 3.5 kV/mm gives 2.51.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// The torque is at most that of 3.5 kV/mm, as control.md section 5 has it.
    AsAFluid,
    /// Without a bound, as the equations stand in the paper.
    AsPrinted,
}

impl Reading {
    /// Both.
    pub const ALL: [Self; 2] = [Self::AsAFluid, Self::AsPrinted];

    /// In tables and legends.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AsAFluid => "as a fluid can",
            Self::AsPrinted => "as printed",
        }
    }
}

/// Where the law takes the speed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Speed {
    /// The true one, brake without dead-band: what the paper's equations assume, and how it is reproduced.
    True,
    /// As flashed: difference of counts, 1 ms low-pass, brake dead-band of one count a sample.
    Counts,
}

/// One experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Delay model.
    pub fluid: Fluid,
    /// How a delay of the viscosity is read.
    pub reading: Reading,
    /// L that scales the gains, s.
    pub gains_delay_s: f64,
    /// L of the plant, s.
    pub plant_delay_s: f64,
    /// Height of the step at time 0, rad; 0 to stay.
    pub step_rad: f64,
    /// Speed the law uses.
    pub speed: Speed,
    /// The brake also holds at rest.
    pub hold: bool,
    /// The brake of Fig. 7 is there at all.
    pub brake: bool,
    /// Dry friction of the plant, N m.
    pub coulomb_nm: f64,
    /// Push from outside.
    pub push: Option<Disturbance>,
}

impl Case {
    /// The step of control.md section 7.
    pub const PAPER: Self = Self {
        fluid: Fluid::None,
        reading: Reading::AsAFluid,
        gains_delay_s: DELAY_S,
        plant_delay_s: DELAY_S,
        step_rad: STEP_RAD,
        speed: Speed::True,
        hold: false,
        brake: true,
        coulomb_nm: COULOMB_NM,
        push: None,
    };

    /// Parameters of the law.
    ///
    /// The brake's zone is the default 0.02 rad at L = 5 ms and grows with L squared above, as the error the brake can
    /// hold does; at 0.02 rad the library refuses the gains of L = 7 ms and more.
    #[must_use]
    pub fn config(&self) -> Config {
        let gains = NormalisedGains::PAPER.physical(INERTIA_KG_M2, self.gains_delay_s);
        let near_rad = 0.02 * (self.gains_delay_s / DELAY_S).powi(2).max(1.0);
        let flashed = Config {
            kp_nm_rad: gains.k_p_nm_rad as f32,
            kd_nm_s_rad: gains.k_d_nm_s_rad as f32,
            near_rad: if self.brake { near_rad as f32 } else { 0.0 },
            hold: self.hold,
            er_enabled: self.fluid != Fluid::Off,
            // Counts that stand still under torque are a fault of the resolver, unless the motor just answers late.
            stale_time_s: 0.1,
            ..Config::default()
        };
        match self.speed {
            Speed::Counts => flashed,
            Speed::True => Config { speed_from_converter: true, brake_deadband_rad_s: 0.0, ..flashed },
        }
    }

    /// The error dry friction alone can hold, u = c / K_P, rad.
    #[must_use]
    pub fn friction_error_rad(&self) -> f64 {
        COULOMB_NM / f64::from(self.config().kp_nm_rad)
    }

    /// Runs the loop.
    ///
    /// # Errors
    /// A value the law or the plant does not take.
    pub fn run(&self) -> Result<Vec<Row>, Error> {
        let er = Er { response: self.fluid.response(self.reading), ..Er::new(A, B, 0.0, 0.0) };
        let model =
            Model { er: Some(er), coulomb: self.coulomb_nm, torque_delay_s: self.plant_delay_s, ..Model::paper() };
        let config = self.config();
        let ticks = (self.duration_s() / f64::from(config.period_s)).round() as usize;
        let setup = Setup {
            model,
            config,
            disturbances: self.push.into_iter().collect(),
            sensor_noise_rad: 0.0,
            torque_noise_nm: 0.0,
            seed: 0,
        };
        run(&setup, std::iter::repeat_n(Counts::from_rad(self.step_rad), ticks))
    }

    /// The rotor's creep under the full damper takes Q(0)/K_P, which grows with L squared: 1 s at 5 ms.
    fn duration_s(&self) -> f64 {
        (self.gains_delay_s / DELAY_S).powi(2).clamp(0.4, 4.0)
    }

    /// Figures of a run of this case; none if the reference is not away from the start, or friction holds the rotor
    /// where it is.
    #[must_use]
    pub fn response(&self, rows: &[Row]) -> Option<Response> {
        let period_s = f64::from(self.config().period_s);
        let figures = Summary::of(rows, period_s).step?;
        let moved = rows.last()?.truth.position.abs() > 0.0;
        // Friction may hold the rotor at u wherever it stops; a band inside that would say nothing of the damper.
        let band_rad = (0.02 * self.step_rad).max(1.5 * self.friction_error_rad());
        let outside = rows.iter().rposition(|row| (self.step_rad - row.truth.position).abs() > band_rad);
        moved.then(|| Response {
            overshoot: figures.overshoot,
            settling_s: match outside {
                Some(last) if last + 1 == rows.len() => None,
                Some(last) => Some((last + 1) as f64 * period_s),
                None => Some(0.0),
            },
            residual_u: figures.residual_rad / self.friction_error_rad(),
            dips: figures.speed_dips,
        })
    }
}

/// Figures of a step response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Beyond the reference, as a share of the step.
    pub overshoot: f64,
    /// From the step to the last time further off than 2 % of it, or than 1.5 u where that is more, s; none if it ends
    /// there.
    pub settling_s: Option<f64>,
    /// Reference minus position at the end, in u = c / K_P.
    pub residual_u: f64,
    /// Falls and rises of the speed after its peak.
    pub dips: usize,
}

/// Largest distance from the start, rad.
#[must_use]
pub fn peak_rad(rows: &[Row]) -> f64 {
    rows.iter().map(|row| row.truth.position.abs()).fold(0.0, f64::max)
}
