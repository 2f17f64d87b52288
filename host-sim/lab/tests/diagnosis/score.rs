//! A table of single effects: what was named, and whether the interval holds the truth. Run by name; it prints.

use lab::simulate::Disturbance;
use plant::effects::{Gravity, Harmonic, Shaft, Stribeck, Vibration};
use plant::{FieldResponse, FluidResponse, Model};

use crate::cases::{answer, recordings};

type Change = Box<dyn Fn(&mut Model) + Sync + Send>;

fn field(change: impl Fn(&mut FieldResponse) + Sync + Send + 'static) -> Change {
    Box::new(move |model| {
        if let Some(er) = &mut model.er
            && let FluidResponse::Field(response) = &mut er.response
        {
            change(response);
        }
    })
}

fn er(change: impl Fn(&mut plant::Er) + Sync + Send + 'static) -> Change {
    Box::new(move |model| change(model.er.as_mut().unwrap()))
}

/// Effect, its true parameters in the order of the vocabulary, and the change of the plant.
pub fn singles() -> Vec<(&'static str, Vec<f64>, Change)> {
    vec![
        ("none", vec![], Box::new(|_| ())),
        ("field_dead_time", vec![0.005], field(|f| f.dead_time_s = 0.005)),
        ("field_lag", vec![0.008], field(|f| (f.rise_s, f.fall_s) = (0.008, 0.008))),
        ("field_lag_asymmetry", vec![0.003, 0.012], field(|f| f.fall_s = 0.012)),
        ("field_slew_limit", vec![200.0], field(|f| f.slew_kv_mm_s = Some(200.0))),
        ("field_gain", vec![0.85], er(|e| e.field_gain = 0.85)),
        ("er_strength", vec![0.8], er(|e| e.scale = 0.8)),
        ("er_drift", vec![-0.03], er(|e| e.drift_per_s = -0.03)),
        ("er_preyield", vec![300.0], er(|e| e.preyield_stiffness = Some(300.0))),
        (
            "viscosity_dead_time",
            vec![0.005],
            er(|e| e.response = FluidResponse::ViscosityDeadTime { dead_time_s: 0.005, torque_limit: 2.5074 }),
        ),
        (
            "viscosity_lag",
            vec![0.005],
            er(|e| e.response = FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit: 2.5074 }),
        ),
        ("coulomb_friction", vec![0.95], Box::new(|m| m.coulomb = 0.95)),
        ("viscous_friction", vec![0.15], Box::new(|m| m.viscous = 0.15)),
        ("stribeck_friction", vec![0.5, 0.1], Box::new(|m| m.stribeck = Some(Stribeck { excess: 0.5, velocity: 0.1 }))),
        (
            "friction_asymmetry",
            vec![0.0, 0.0],
            Box::new(|m| {
                m.asymmetry.coulomb = 0.3;
                m.viscous = 0.0;
            }),
        ),
        ("presliding", vec![400.0], Box::new(|m| m.presliding_stiffness = Some(400.0))),
        ("torque_gain", vec![0.93], Box::new(|m| m.torque_gain = 0.93)),
        ("torque_offset", vec![0.2], Box::new(|m| m.torque_offset = 0.2)),
        ("torque_saturation", vec![12.0], Box::new(|m| m.torque_limit = Some(12.0))),
        ("torque_deadband", vec![0.3], Box::new(|m| m.torque_deadband = 0.3)),
        ("torque_delay", vec![0.0062], Box::new(|m| m.torque_delay_s = 0.0062)),
        ("torque_lag", vec![0.0015], Box::new(|m| m.torque_lag_s = 0.0015)),
        (
            "cogging",
            vec![0.3, 14.0, 1.0],
            Box::new(|m| m.cogging.push(Harmonic { amplitude: 0.3, order: 14.0, phase_rad: 1.0 })),
        ),
        ("inertia", vec![0.082], Box::new(|m| m.inertia = 0.082)),
        ("gravity_load", vec![0.5, 0.4], Box::new(|m| m.gravity = Some(Gravity { amplitude: 0.5, phase_rad: 0.4 }))),
        ("spring_load", vec![0.6], Box::new(|m| m.spring_stiffness = 0.6)),
        (
            "compliance",
            vec![40.0, 0.03, 0.4],
            Box::new(|m| {
                m.shaft = Some(Shaft { resonance_hz: 40.0, damping_ratio: 0.03, inertia_ratio: 0.4, gap: 0.0 })
            }),
        ),
        (
            "backlash",
            vec![0.004, 60.0, 0.05, 0.4],
            Box::new(|m| {
                m.shaft = Some(Shaft { resonance_hz: 60.0, damping_ratio: 0.05, inertia_ratio: 0.4, gap: 0.004 })
            }),
        ),
        ("disturbance_pulse", vec![3.1, 0.12, 2.0], Box::new(|_| ())),
        (
            "vibration",
            vec![17.3, 0.25],
            Box::new(|m| m.vibration = Some(Vibration { frequency_hz: 17.3, amplitude: 0.25, phase_rad: 0.3 })),
        ),
        ("quadratic_drag", vec![0.1], Box::new(|m| m.quadratic_drag = 0.1)),
        (
            "resolver_eccentricity",
            vec![0.002, 4.0, 0.5],
            Box::new(|m| m.sensor.eccentricity.push(Harmonic { amplitude: 0.002, order: 4.0, phase_rad: 0.5 })),
        ),
        ("sensor_latency", vec![0.0012], Box::new(|m| m.sensor.latency_s = 0.0012)),
    ]
}

#[test]
#[ignore = "prints a table, takes minutes: cargo test --release -p lab --test diagnosis table -- --ignored --nocapture"]
fn table_of_single_effects() {
    let only = std::env::var("CASE").ok();
    let noise: f64 = std::env::var("NOISE").ok().and_then(|text| text.parse().ok()).unwrap_or(0.05);
    let mut right = 0;
    for (index, (id, truth, change)) in singles().into_iter().enumerate() {
        if only.as_ref().is_some_and(|only| !only.split(',').any(|o| o == id)) {
            continue;
        }
        let push = [Disturbance { start_s: 3.1, duration_s: 0.12, torque_nm: 2.0 }];
        let files = recordings(&*change, index as u64 + 1, noise, if id == "disturbance_pulse" { &push } else { &[] });
        let begun = std::time::Instant::now();
        let answer = answer(&files, std::env::var("WITHOUT").as_deref().unwrap_or(""));
        let took_s = begun.elapsed().as_secs_f64();
        let first = answer.effects.first();
        right += usize::from(first.map_or("none", |effect| effect.id.as_str()) == id && answer.effects.len() <= 1);
        println!(
            "{id:22} {took_s:5.1} s {:?} excess {:.3} fit {:.2e} {:.2e} holdout {:.2e} {:.2e} floor {:.2e}",
            answer.verdict,
            answer.fit.excess_explained,
            answer.fit.before_rms,
            answer.fit.after_rms,
            answer.fit.heldout_before_rms,
            answer.fit.heldout_after_rms,
            answer.fit.noise_floor_rms
        );
        for effect in &answer.effects {
            print!(
                "    {} (gain {:.3}, p {:.0e}) ~{:?}",
                effect.id, effect.evidence.heldout_gain, effect.evidence.p_value, effect.equivalent
            );
            for (k, p) in effect.parameters.iter().enumerate() {
                let inside = effect.id == id && truth.get(k).is_some_and(|t| p.low <= *t && *t <= p.high);
                print!(
                    " {}={:.5} [{:.5},{:.5}]{}",
                    p.id,
                    p.value,
                    p.low,
                    p.high,
                    if effect.id == id { if inside { " in" } else { " OUT" } } else { "" }
                );
            }
            println!();
        }
        if only.is_some() {
            for r in answer.rejected.iter().take(6) {
                println!("      rejected {} {:.4} {}", r.id, r.heldout_gain, r.why);
            }
        }
        for warning in &answer.warnings {
            println!("    ! {warning}");
        }
    }
    println!("{right} right");
}
