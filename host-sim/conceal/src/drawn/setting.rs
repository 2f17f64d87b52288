//! A machine nobody has seen before: everything that the fixed plan holds fixed, drawn.

use std::f64::consts::TAU;

use er_servo::Config;
use rand::Rng;
use rand::rngs::StdRng;

use super::controller::{Controller, FieldRule};
use crate::physics::{Physics, Wave};

/// Rows of a recording, about: enough to tell effects, few enough to diagnose in seconds.
const ROWS: f64 = 6000.0;
/// Shortest and longest recording, s.
const DURATION_S: [f64; 2] = [2.0, 20.0];
/// Phase that delays may cost the generator's own loop at its bandwidth, rad: it stays damped with effects put in.
const LOST_PHASE_RAD: f64 = 0.25;

/// What closes the loop.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Law {
    /// The law that is flashed.
    Servo(Box<Config>),
    /// One of the generator's own, of which the machine file says nothing.
    Own(Controller),
}

/// A torque column that was measured and not commanded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MeasuredTorque {
    /// Its stamps are later than the torque by this, s.
    pub(crate) skew_s: f64,
    /// Standard deviation over that of the torque noise, 1.
    pub(crate) noise_share: f64,
}

/// What disturbs beside the effects: torques in shares of the motion's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// Standard deviation of the torque drawn anew each row.
    pub(crate) white: f64,
    /// Standard deviation of the torque with a memory, and that memory, s.
    pub(crate) coloured: Option<(f64, f64)>,
    /// Amplitude of a ripple, its order and phase.
    pub(crate) ripple: Option<Wave>,
    /// Standard deviation of the sensor over its step, 1.
    pub(crate) sensor_steps: f64,
}

/// A drawn machine with its log, before anything is concealed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Setting {
    pub(crate) linear: bool,
    /// Nominal, without noise.
    pub(crate) physics: Physics,
    pub(crate) law: Law,
    pub(crate) period_s: f64,
    /// Largest deviation of a control period, s.
    pub(crate) jitter_s: f64,
    pub(crate) duration_s: f64,
    /// Step of the position, rad or m.
    pub(crate) step: f64,
    pub(crate) measured: Option<MeasuredTorque>,
    pub(crate) noise: Noise,
    /// Amplitude of the references over that of the families, and the same of their time.
    pub(crate) travel: f64,
    pub(crate) slower: f64,
}

fn log_uniform(low: f64, high: f64, random: &mut StdRng) -> f64 {
    low * (high / low).powf(random.random())
}

impl Setting {
    /// Draws a machine; with the flashed law where the case needs it, else in one of four.
    pub(crate) fn draw(servo: bool, random: &mut StdRng) -> Self {
        if servo || random.random_bool(0.25) { Self::servo(random) } else { Self::other(random) }
    }

    /// The servo under its law, with its numbers moved.
    fn servo(random: &mut StdRng) -> Self {
        let mut physics = Physics::nominal();
        let factor = log_uniform(0.6, 1.6, random);
        physics.inertia_kg_m2 *= factor;
        physics.friction.coulomb_nm *= log_uniform(0.6, 1.5, random);
        let strength = log_uniform(0.6, 1.6, random);
        (physics.fluid.a, physics.fluid.b) = (physics.fluid.a * strength, physics.fluid.b * strength);
        physics.drive.delay_s = random.random_range(0.003..0.0055);
        physics.fluid.dead_time_s = random.random_range(0.001..0.004);
        let lag_s = random.random_range(0.001..0.005);
        (physics.fluid.rise_s, physics.fluid.fall_s) = (lag_s, lag_s);
        let mut config = Config::default();
        (config.kp_nm_rad, config.kd_nm_s_rad) = (config.kp_nm_rad * factor as f32, config.kd_nm_s_rad * factor as f32);
        Self {
            linear: false,
            physics,
            period_s: f64::from(config.period_s),
            law: Law::Servo(Box::new(config)),
            jitter_s: if random.random_bool(0.3) { 20e-6 } else { 0.0 },
            duration_s: random.random_range(2.5..4.0),
            step: TAU / f64::from(er_servo::COUNTS_PER_REV),
            measured: None,
            noise: Noise::draw(0.0005, false, random),
            travel: 1.0,
            slower: 1.0,
        }
    }

    /// Any other machine.
    // Over 40 lines: one draw after another.
    fn other(random: &mut StdRng) -> Self {
        let linear = random.random_bool(0.3);
        let period_s = 1.0 / log_uniform(200.0, 8000.0, random);
        let duration_s = (ROWS * random.random_range(0.7..1.4) * period_s).clamp(DURATION_S[0], DURATION_S[1]);
        let measured = random.random_bool(0.25).then(|| MeasuredTorque {
            skew_s: if random.random_bool(0.5) { period_s * random.random_range(-2.0..2.0) } else { 0.0 },
            noise_share: random.random_range(0.2..1.0),
        });
        let no_delay = measured.is_some() || random.random_bool(0.3);
        let delay_s = if no_delay { 0.0 } else { random.random_range(0.0005..0.006) };
        let wanted_rad_s = 6.0 / log_uniform(0.12, 0.5, random);
        let bandwidth_rad_s = wanted_rad_s.min(LOST_PHASE_RAD / (delay_s + 2.5 * period_s));
        let travel = if linear { log_uniform(0.01, 0.5, random) } else { log_uniform(0.3, 3.0, random) };
        let inertia = if linear { log_uniform(0.5, 300.0, random) } else { log_uniform(1e-4, 10.0, random) };
        let torque = 0.3 * inertia * travel * bandwidth_rad_s.powi(2);
        let mut physics = Physics::nominal();
        physics.inertia_kg_m2 = inertia;
        physics.friction.coulomb_nm =
            if random.random_bool(0.1) { 0.0 } else { torque * log_uniform(0.03, 0.5, random) };
        if random.random_bool(0.5) {
            physics.friction.viscous_nm_s_rad = torque / (travel * bandwidth_rad_s) * log_uniform(0.03, 0.4, random);
        }
        physics.drive.delay_s = delay_s;
        physics.drive.limit_nm = if random.random_bool(0.5) { 20.0 * torque } else { f64::INFINITY };
        let field = random.random_bool(0.4).then(|| FieldRule::draw(bandwidth_rad_s, travel, random));
        damper(&mut physics, if field.is_some() { torque * log_uniform(0.2, 1.5, random) } else { 0.0 }, random);
        let step = travel / log_uniform(2e3, 3e5, random);
        Self {
            linear,
            law: Law::Own(Controller::draw(inertia, bandwidth_rad_s, 15.0 * torque, field, random)),
            period_s,
            jitter_s: if random.random_bool(0.3) { period_s * random.random_range(0.02..0.3) } else { 0.0 },
            duration_s,
            step: if linear { step } else { TAU / 2.0_f64.powf((TAU / step).log2().ceil()) },
            measured,
            noise: Noise::draw(period_s, linear, random),
            // The families' own size is about half a radian, their time that of a loop of 40 rad/s.
            travel: travel / 0.5,
            slower: (40.0 / bandwidth_rad_s).max(0.5),
            physics,
        }
    }

    /// Whether the machine has a damper.
    pub(crate) fn has_fluid(&self) -> bool {
        self.physics.fluid.b > 0.0
    }
}

/// A fluid whose torque at 3 kV/mm is that; none at 0.
fn damper(physics: &mut Physics, torque: f64, random: &mut StdRng) {
    let square_share = 0.15 * log_uniform(0.5, 2.0, random);
    let fluid = &mut physics.fluid;
    fluid.b = torque / (3.0 * (1.0 + 3.0 * square_share));
    fluid.a = square_share * fluid.b;
    fluid.dead_time_s = random.random_range(0.0..0.005);
    let lag_s = random.random_range(0.0005..0.006);
    (fluid.rise_s, fluid.fall_s) = (lag_s, lag_s);
}

impl Noise {
    fn draw(period_s: f64, linear: bool, random: &mut StdRng) -> Self {
        let coloured = (log_uniform(0.002, 0.02, random), log_uniform(0.002, 0.03, random));
        let order = if linear { 0.0 } else { f64::from(random.random_range(24..96)) };
        let wave = Wave {
            amplitude: log_uniform(0.002, 0.01, random),
            order_per_rev: order,
            phase_rad: random.random_range(0.0..TAU),
        };
        Self {
            // The same density at every rate.
            white: (log_uniform(0.003, 0.03, random) * (0.0005 / period_s).sqrt()).min(0.1),
            coloured: random.random_bool(0.5).then_some(coloured),
            ripple: (order > 0.0 && random.random_bool(0.3)).then_some(wave),
            sensor_steps: random.random_range(0.0..0.5),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    /// Machines drawn; a share of one half then scatters by 0.025.
    const DRAWN: u64 = 400;

    fn settings() -> Vec<Setting> {
        (0..DRAWN).map(|seed| Setting::draw(false, &mut StdRng::seed_from_u64(seed))).collect()
    }

    /// Whether a share of these is the expected one within four deviations of a binomial draw.
    fn expect<'a>(
        what: &str,
        of: impl Iterator<Item = &'a Setting> + Clone,
        holds: impl Fn(&Setting) -> bool,
        share: f64,
    ) {
        let (count, all) = (of.clone().filter(|one| holds(one)).count() as f64, of.count() as f64);
        let spread = (share * (1.0 - share) / all).sqrt();
        println!("{what}: {count} of {all}, expected {share}");
        assert!((count / all - share).abs() <= 4.0 * spread, "{what}: {count} of {all}, expected {share}");
    }

    #[test]
    fn every_property_of_a_machine_and_its_log_comes_in_its_share() {
        let all = settings();
        let flashed = |one: &Setting| matches!(one.law, Law::Servo(_));
        let own = || all.iter().filter(|one| !flashed(one));
        expect("flashed law", all.iter(), flashed, 0.25);
        expect("uneven time", all.iter(), |one| one.jitter_s > 0.0, 0.3);
        expect("coloured torque noise", all.iter(), |one| one.noise.coloured.is_some(), 0.5);
        expect("linear", own(), |one| one.linear, 0.3);
        expect("no damper", own(), |one| !one.has_fluid(), 0.6);
        expect("torque measured", own(), |one| one.measured.is_some(), 0.25);
        expect("no dry friction", own(), |one| one.physics.friction.coulomb_nm == 0.0, 0.1);
        expect("viscous friction", own(), |one| one.physics.friction.viscous_nm_s_rad > 0.0, 0.5);
        expect("limit of the torque", own(), |one| one.physics.drive.limit_nm.is_finite(), 0.5);
        // A measured torque is none that is late.
        expect("no drive delay", own(), |one| one.physics.drive.delay_s == 0.0, 0.25 + 0.75 * 0.3);
        let measured = || own().filter(|one| one.measured.is_some());
        expect("skew", measured(), |one| one.measured.is_some_and(|law| law.skew_s != 0.0), 0.5);
        expect("ripple of the noise", own().filter(|one| !one.linear), |one| one.noise.ripple.is_some(), 0.3);
        assert!(all.iter().all(|one| one.noise.white > 0.0 && (flashed(one) || one.physics.fluid.b >= 0.0)));
        assert!(all.iter().filter(|one| flashed(one)).all(|one| one.has_fluid() && one.measured.is_none()));
    }

    #[test]
    fn rates_inertias_and_ways_fill_their_ranges_evenly_on_a_logarithmic_scale() {
        let all = settings();
        let own = || all.iter().filter(|one| matches!(one.law, Law::Own(_)));
        let (slow, fast) = (200.0_f64, 8000.0_f64);
        let hz = |one: &Setting| 1.0 / one.period_s;
        assert!(own().all(|one| (slow..fast).contains(&hz(one))));
        // Each quarter of the range has a quarter of the machines.
        for quarter in 0..4 {
            let at = |share: f64| slow * (fast / slow).powf(share);
            let (from, to) = (at(0.25 * f64::from(quarter)), at(0.25 * f64::from(quarter + 1)));
            let within = |one: &Setting| (from..to).contains(&hz(one));
            expect(&format!("{from:.0} to {to:.0} Hz"), own(), within, 0.25);
        }
        let rotary = || own().filter(|one| !one.linear);
        expect("inertia below 0.03 kg m2", rotary(), |one| one.physics.inertia_kg_m2 < 10.0_f64.powf(-1.5), 0.5);
        expect(
            "mass below 12 kg",
            own().filter(|one| one.linear),
            |one| one.physics.inertia_kg_m2 < 150.0_f64.sqrt(),
            0.5,
        );
    }
}
