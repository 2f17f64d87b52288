//! Tuned gains keep what is promised, checked by counting roots, and their file is read back.

use analysis::stability::{Fluid, Loop, Plant as LinearPlant, argument};
use analysis::tune::series::SeriesLoop;
use analysis::tune::{Demands, Steps, Task, Tuning, machine, tune};
use er_servo::{Config, Params};
use nalgebra::Complex;
use plant::{Er, FluidResponse, Model};
use recording::Machine;

const DEMANDS: Demands = Demands { phase_deg: 30.0, gain: 1.5, delay_share: 0.2 };

fn task(response: FluidResponse) -> Task {
    let large_rad = std::f64::consts::FRAC_PI_6;
    Task {
        model: Model { er: Some(Er { response, ..Er::new(0.0704, 0.470, 0.0, 0.0) }), ..Model::paper() },
        config: Config::default(),
        demands: DEMANDS,
        uncertainty: 0.5,
        q1_nm_s_rad: None,
        steps: Steps { large_rad, small_rad: 0.05, tolerance_rad: 0.02 * large_rad, overshoot: 0.02 },
    }
}

fn field(dead_time_s: f64, lag_s: f64) -> FluidResponse {
    FluidResponse::Field(plant::FieldResponse::new(dead_time_s, lag_s))
}

/// Unstable roots with the control torque late by `lag_rad` at every frequency: turns of the characteristic function
/// along the axis, in steps of 0.02 rad/s. Written apart from the crate: no margins, no bounds.
fn roots_with_phase_lag(drawn: &SeriesLoop, lag_rad: f64) -> i32 {
    let at = |w: f64| {
        let s = Complex::new(0.0, w);
        let fluid = (-s * drawn.dead_time_s).exp() / (s * drawn.lag_s + 1.0);
        let control = (s * drawn.gains.k_d_nm_s_rad + drawn.gains.k_p_nm_rad)
            * (-s * drawn.torque_delay_s - Complex::new(0.0, lag_rad)).exp();
        s * s * drawn.inertia_kg_m2 + s * (drawn.q0_nm_s_rad + fluid * drawn.q1_nm_s_rad) + control
    };
    let mut turned = 0.0;
    let mut here = at(0.0);
    for k in 1..=150_000 {
        let next = at(0.02 * f64::from(k));
        turned += (next / here).arg();
        here = next;
    }
    // From K_P e^(-j lag) to -J w^2, half a turn and the lag, less half a turn for each root on the right.
    ((std::f64::consts::PI + lag_rad - turned) / std::f64::consts::PI).round() as i32
}

/// Root counting of the stability module, where it has the fluid.
fn known_roots(drawn: &SeriesLoop) -> Option<usize> {
    let fluid = match (drawn.dead_time_s, drawn.lag_s) {
        (0.0, 0.0) => Fluid::None,
        (l_q_s, 0.0) => Fluid::DeadTime { l_q_s },
        (0.0, t_q_s) => Fluid::Lag { t_q_s },
        _ => return Some(0),
    };
    let SeriesLoop { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, .. } = *drawn;
    let plant = LinearPlant { inertia_kg_m2, torque_delay_s, q0_nm_s_rad, q1_nm_s_rad, fluid };
    argument::unstable_roots(&Loop::new(plant, drawn.gains).unwrap())
}

/// Every margin taken away in full from loops drawn within the range; none may become unstable.
fn keeps_its_promise(tuning: &Tuning) {
    let best = tuning.best;
    assert!(best.guarantee.unwrap().level >= 1.0);
    for (k, drawn) in tuning.range.draws(best.gains, 200, 42).enumerate() {
        let gains = analysis::stability::Gains {
            k_p_nm_rad: DEMANDS.gain * best.gains.k_p_nm_rad,
            k_d_nm_s_rad: DEMANDS.gain * best.gains.k_d_nm_s_rad,
        };
        let louder = SeriesLoop { gains, ..drawn };
        let later_s = drawn.torque_delay_s + DEMANDS.delay_share * tuning.range.torque_delay_s;
        let later = SeriesLoop { torque_delay_s: later_s, ..drawn };
        for lost in [drawn, louder, later] {
            assert_eq!(lost.unstable_roots(), Some(0), "{lost:?}");
            assert_eq!(known_roots(&lost), Some(0), "{lost:?}");
        }
        if k < 8 {
            assert_eq!(roots_with_phase_lag(&drawn, DEMANDS.phase_deg.to_radians()), 0, "{drawn:?}");
            assert_eq!(roots_with_phase_lag(&louder, 0.0), 0, "{louder:?}");
        }
    }
}

#[test]
fn the_papers_machine_is_tuned_and_its_file_reads_back() {
    let task = task(field(0.002, 0.003));
    let tuning = tune(&task).unwrap();
    keeps_its_promise(&tuning);
    assert!(tuning.short_of_peak && tuning.range.q1_nm_s_rad >= 10.0, "a late field cannot be kept up to the peak");
    assert_eq!((tuning.draws.1, tuning.limit_cycles), (0, 0));
    let (best, paper) = (tuning.best.trial.unwrap(), tuning.paper.trial.unwrap());
    println!("tuned {best:?}\npaper {paper:?}, stable up to +-{:.2}", tuning.paper_bears);
    assert!(best.overshoot <= task.steps.overshoot && tuning.paper_bears < task.uncertainty);
    // More margin never settles faster.
    let costs: Vec<f64> = tuning.trade_off.iter().filter_map(|(_, found)| Some(found.as_ref()?.worth()?.1)).collect();
    assert!(costs.len() > 4 && costs.is_sorted(), "{costs:?}");

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tuned.toml");
    let written = machine(&task, &tuning, None);
    written.write(&file).unwrap();
    let read = Machine::read(&file).unwrap();
    assert_eq!((read.controller, &read.plant), (written.controller, &written.plant));
    let config = read.controller.unwrap();
    assert!(Params::new(&config).is_ok());
    assert_eq!(f64::from(config.kp_nm_rad) as f32, tuning.best.gains.k_p_nm_rad as f32);
}

#[test]
fn a_lag_is_kept_up_to_the_peak_of_the_viscosity() {
    let tuning = tune(&task(FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit: 2.6 })).unwrap();
    assert!(!tuning.short_of_peak && tuning.range.q1_nm_s_rad > 55.0);
    keeps_its_promise(&tuning);
}

#[test]
fn what_no_gains_can_keep_is_an_error_that_says_how_near_they_come() {
    let dead = FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit: 2.6 };
    let error = tune(&Task { q1_nm_s_rad: Some(55.0), ..task(dead) }).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("no gains keep the loop stable up to Q1 55"), "{error}");
}

#[test]
fn the_mode_that_won_stands_beside_the_tuned_gains_and_is_not_written() {
    let told = task(field(0.002, 0.003));
    let beside = analysis::tune::beside::beside(&told).unwrap().unwrap();
    assert_eq!(beside.mode.key, "predictor-lead-gains-1.25");
    let nominal = beside.nominal.unwrap();
    assert!(nominal.settling_s[0] > 0.05 && nominal.settling_s[0] < 0.2, "{nominal:?}");
    // The modes know one machine.
    assert_eq!(analysis::tune::beside::beside(&task(field(0.004, 0.003))).unwrap(), None);
}
