//! Every law once more, written straight from the diagnosis specification and stepped by brute force. The stepping is
//! first order, so a quarter of the step must leave about a quarter of its distance to the exact motion.

use crate::common::{TICK_S, command, every_effect, run};
use plant::effects::{Harmonic, Warming};
use plant::{FieldResponse, FluidResponse, Model};

/// Position after each tick by Euler steps, `steps` to a tick; undelayed torque, field dead time 2 ms and lag 3 ms.
fn brute_force(model: &Model, ticks: usize, steps: usize) -> Vec<f64> {
    let h = TICK_S / steps as f64;
    let er = model.er.as_ref().unwrap();
    let (mut position, mut speed, mut field, mut bristle, mut spring) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let (mut twist, mut twist_rate) = (0.0_f64, 0.0_f64);
    let (mut friction_heat, mut fluid_heat) = (0.0_f64, 0.0_f64);
    let share = |warming: Option<Warming>, heat: f64| warming.map_or(1.0, |w| (-w.per_j * heat).exp());
    let mut positions = Vec::new();
    for tick in 0..ticks {
        let wanted = if tick >= 4 { command(tick - 4).field_kv_mm } else { 0.0 };
        for step in 0..steps {
            let t_s = tick as f64 * TICK_S + step as f64 * h;
            field += (wanted - field) * (1.0 - (-h / 0.003).exp());
            let acting = er.field_gain * field;
            let level = er.scale * (1.0 + er.drift_per_s * t_s) * (er.a * acting * acting + er.b * acting);
            let level = level * share(er.warming, fluid_heat);
            let ripple = |h: &Harmonic| h.amplitude * (h.order * position + h.phase_rad).sin();
            let drive = command(tick).torque * (1.0 + model.torque_ripple.iter().map(ripple).sum::<f64>());
            let mut push = drive;
            push += model.cogging.iter().map(|c| c.amplitude * (c.order * position + c.phase_rad).sin()).sum::<f64>();
            push -= model.gravity.map_or(0.0, |g| g.amplitude * (position + g.phase_rad).sin());
            push -= model.spring_stiffness * position + model.quadratic_drag * speed * speed.abs();
            push += model
                .vibration
                .map_or(0.0, |v| v.amplitude * (std::f64::consts::TAU * v.frequency_hz * t_s + v.phase_rad).sin());
            let mut hold = if model.presliding_stiffness.is_some() { 0.0 } else { model.coulomb };
            if let FluidResponse::Field(FieldResponse { flow: Some(flow), .. }) = er.response {
                let consistency = flow.consistency + flow.consistency_per_kv_mm * acting;
                push -= consistency * speed * (speed * speed + 0.002 * 0.002).powf(0.5 * (flow.exponent - 1.0));
            }
            if let Some(stiffness) = er.preyield_stiffness {
                spring = (spring + stiffness * speed * h).clamp(-level, level);
                push -= spring;
            } else {
                hold += level;
            }
            if let Some(stiffness) = model.presliding_stiffness {
                bristle += stiffness * speed * h * (1.0 - speed.signum() * bristle / model.coulomb);
                push -= bristle;
            }
            hold += model.load_friction * drive.abs();
            hold += model.stribeck.map_or(0.0, |s| s.excess * (-(speed / s.velocity).powi(2)).exp());
            let direction = if speed == 0.0 { push.signum() } else { speed.signum() };
            hold += 0.5 * model.asymmetry.coulomb * direction;
            let viscous = share(model.viscous_warming, friction_heat) * model.viscous;
            push -= (viscous + 0.5 * model.asymmetry.viscous * direction) * speed;
            let mut inertia = model.inertia;
            if let Some(shaft) = model.shaft {
                let ratio = shaft.inertia_ratio;
                let load = inertia * ratio / (1.0 + ratio);
                inertia /= 1.0 + ratio;
                let reduced = load / (1.0 + ratio);
                let omega = std::f64::consts::TAU * shaft.resonance_hz;
                let bent = (twist.abs() - 0.5 * shaft.gap).max(0.0).copysign(twist);
                let bends = reduced * omega * (omega * bent + 2.0 * shaft.damping_ratio * twist_rate);
                // Teeth push and do not pull.
                let through = if shaft.gap == 0.0 || bends * bent > 0.0 { bends } else { 0.0 };
                twist_rate -= h * through / load;
                push += through;
            }
            // The drag takes what speed there is, and no more.
            let before = speed;
            let free = speed + h * push / inertia;
            speed = if free.abs() <= h * hold / inertia { 0.0 } else { free - h * hold / inertia * free.signum() };
            twist_rate -= speed - before;
            twist += h * twist_rate;
            position += h * speed;
            let power = (hold + viscous * speed.abs()) * speed.abs();
            let warmed = |warming: Option<Warming>, heat: f64| warming.map_or(0.0, |w| power - w.cooling_per_s * heat);
            friction_heat += h * warmed(model.viscous_warming, friction_heat);
            fluid_heat += h * warmed(er.warming, fluid_heat);
        }
        positions.push(position);
    }
    positions
}

#[test]
fn brute_force_converges_to_every_law() {
    let elsewhere = [
        "fractional delays",
        "viscosity_dead_time",
        "viscosity_lag",
        "field_lag_asymmetry",
        "kinetics",
        "kinetics behind a slew limit",
        "field_slew_limit",
        "field_slew_limit and asymmetry",
        "torque_deadband",
        "torque_lag",
        "torque_saturation",
        "disturbance_pulse",
    ];
    for (name, model) in every_effect().into_iter().filter(|(name, _)| !elsewhere.contains(name)) {
        let model = Model { torque_delay_s: 0.0, ..model };
        let ticks = 600;
        let exact = run(&model, ticks, 1);
        let error = |steps| {
            let rough = brute_force(&model, ticks, steps);
            exact.iter().zip(&rough).map(|(exact, rough)| (exact.position - rough).abs()).fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(50), error(200));
        println!("{name}: brute force within {coarse:.1e} rad at 10 us, {fine:.1e} rad at 2.5 us");
        assert!(fine < 0.4 * coarse && fine < 1e-4, "{name}: {coarse:e} {fine:e}");
    }
}
