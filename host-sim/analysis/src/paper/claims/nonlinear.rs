//! Section VII for the nonlinear loop: limit cycles by harmonic balance, held against runs in time.

use er_servo::Config;

use super::claim::{Claim, Verdict, refused};
use super::region::plant;
use crate::paper::case::{COULOMB_NM, INERTIA_KG_M2};
use crate::stability::describing::{ModelCycles, Search, cycles_by_model};
use crate::stability::{Fluid, Loop, NormalisedGains};
use recording::Error;

/// L of the gains and L of the plant, ms.
const PLACES_MS: [(f64, f64); 12] = [
    (2.0, 2.0),
    (3.0, 3.0),
    (5.0, 5.0),
    (8.0, 8.0),
    (10.0, 10.0),
    (2.0, 4.4),
    (2.0, 5.0),
    (2.0, 6.0),
    (3.0, 9.0),
    (5.0, 10.0),
    (5.0, 13.0),
    (5.0, 15.0),
];

/// What both methods say of one delay model at a place.
struct Comparison {
    model: &'static str,
    /// A model with a delay of the fluid.
    delayed: bool,
    /// Amplitudes of cycles that last by harmonic balance, rad.
    balance_rad: Vec<f64>,
    /// Amplitude left by a run, rad; none at rest.
    run_rad: Option<f64>,
}

impl Comparison {
    fn new(model: &ModelCycles, friction_error_rad: f64) -> Self {
        let lasting = model.cycles.iter().filter(|cycle| cycle.stable);
        Self {
            model: model.model,
            delayed: !matches!(model.model, "ER off" | "none"),
            balance_rad: lasting.map(|cycle| cycle.amplitude_rad).collect(),
            // Under the full damper the rotor creeps on long after the run; that is no cycle.
            run_rad: Some(model.simulated_amplitude_rad).filter(|amplitude| *amplitude >= 0.1 * friction_error_rad),
        }
    }

    fn at_rest(&self) -> bool {
        self.run_rad.is_none() && self.balance_rad.is_empty()
    }

    fn agrees(&self) -> bool {
        match self.run_rad {
            None => self.balance_rad.is_empty(),
            Some(run_rad) => self.balance_rad.iter().any(|balance_rad| (balance_rad / run_rad - 1.0).abs() < 0.1),
        }
    }

    fn in_words(&self) -> String {
        let mrad = |amplitude_rad: f64| format!("{:.0}", 1e3 * amplitude_rad);
        let balance = self.balance_rad.first().map_or("none".to_owned(), |amplitude| mrad(*amplitude));
        format!("{} {balance}/{}", self.model, self.run_rad.map_or("rest".to_owned(), mrad))
    }
}

fn compare(gains_ms: f64, plant_ms: f64) -> Result<Vec<Comparison>, Error> {
    let gains = NormalisedGains::PAPER.physical(INERTIA_KG_M2, gains_ms * 1e-3);
    let closed = Loop::new(plant(plant_ms * 1e-3, 0.0, 0.0, Fluid::None), gains).map_err(refused)?;
    let near_rad = 0.02 * (gains_ms / 5.0_f64).powi(2).max(1.0);
    let config =
        Config { brake_deadband_rad_s: 0.0, stale_time_s: 0.1, near_rad: near_rad as f32, ..Config::default() };
    let models = cycles_by_model(&closed, &config, COULOMB_NM, Search::SERVO)?;
    let friction_error_rad = COULOMB_NM / gains.k_p_nm_rad;
    Ok(models.iter().map(|model| Comparison::new(model, friction_error_rad)).collect())
}

pub(super) fn claims() -> Result<Vec<Claim>, Error> {
    let mut all = Vec::new();
    let mut swinging = Vec::new();
    let (mut harmless, mut of) = (0, 0);
    for (gains_ms, plant_ms) in PLACES_MS {
        let found = compare(gains_ms, plant_ms)?;
        let prompt_rad = found.iter().find(|one| one.model == "none").and_then(|one| one.run_rad).unwrap_or(0.0);
        let delayed = found.iter().filter(|one| one.delayed);
        of += delayed.clone().count();
        harmless += delayed.filter(|one| one.run_rad.is_none_or(|run_rad| run_rad <= 1.1 * prompt_rad)).count();
        let list: Vec<String> = found.iter().filter(|one| !one.at_rest()).map(Comparison::in_words).collect();
        if !list.is_empty() {
            let list = list.join(", ");
            swinging.push(format!("gains for {gains_ms} ms, plant {plant_ms} ms: mrad by balance / in time: {list}"));
        }
        all.extend(found);
    }
    let agree = all.iter().filter(|one| one.agrees()).count();
    let mut figures = vec![format!(
        "both methods agree at {agree} of {} places (amplitude within 10 %, or rest: under 0.1 u); at rest under every \
         model, by both, where no line follows",
        all.len()
    )];
    figures.extend(swinging);
    Ok(vec![Claim {
        section: "VII",
        statement: "The delay of the fluid does not destabilise the (nonlinear) loop",
        test: "what 2 s of the flashed law with the true speed are left with after a step of 0.1 rad: no more than 1.1 times \
               what a fluid without delay leaves; and limit cycles by harmonic balance",
        range: format!(
            "{} pairs of gains' L and plant's L times 6 delayed models, those of Q in both readings",
            PLACES_MS.len()
        ),
        figures,
        verdict: Verdict::of(
            harmless,
            of,
            "a late damper still opposes the motion; a slow motor alone swings the loop",
        ),
    }])
}
