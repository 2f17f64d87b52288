//! The answer as text.

use std::fmt::Write;

use crate::stability::Fluid;
use crate::stability::analysis::{Analysis, Methods};
use crate::stability::limits::{Limit, Margins, Quantity, Tolerance};

/// A page for a terminal. Writing to a string cannot fail, so the results of `writeln!` are dropped.
pub(super) fn summary(analysis: &Analysis) -> String {
    let mut out = String::new();
    let Analysis { plant, gains, normalised_gains, .. } = analysis;
    let _ = writeln!(
        out,
        "Loop: J {} kg m2, L {:.3} ms, Q0 {} and Q1 {} N m s/rad, {}",
        plant.inertia_kg_m2,
        plant.torque_delay_s * 1e3,
        plant.q0_nm_s_rad,
        plant.q1_nm_s_rad,
        name(plant.fluid)
    );
    let _ = writeln!(
        out,
        "Gains: K_P {:.4} N m/rad, K_D {:.4} N m s/rad; K_p* {:.4}, K_d* {:.4} with this L and J",
        gains.k_p_nm_rad, gains.k_d_nm_s_rad, normalised_gains.kp, normalised_gains.kd
    );
    let verdict = if analysis.inside { "stable, inside the region" } else { "UNSTABLE, outside the region" };
    let _ = writeln!(out, "\n{verdict}");
    methods(&mut out, &analysis.methods);
    if let Some(found) = &analysis.margins {
        margins(&mut out, found);
    }
    tolerances(&mut out, &analysis.tolerances);
    let _ = writeln!(out, "\nRegion within K_p* 0..{}, K_d* 0..{}:", analysis.window.kp, analysis.window.kd);
    for region in &analysis.regions {
        let beyond = if region.leaves_window { ", goes on beyond" } else { "" };
        let side = if region.inside { "inside" } else { "outside" };
        let _ = writeln!(out, "  {:<22} area {:.4}{beyond}; gains {side}", name(region.fluid), region.area);
    }
    limit_cycles(&mut out, analysis);
    out
}

/// A delay model of the fluid in words.
pub(super) fn name(fluid: Fluid) -> String {
    match fluid {
        Fluid::None => "no delay of the fluid".to_owned(),
        Fluid::DeadTime { l_q_s } => format!("dead time {:.3} ms", l_q_s * 1e3),
        Fluid::Lag { t_q_s } => format!("lag {:.3} ms", t_q_s * 1e3),
    }
}

fn methods(out: &mut String, methods: &Methods) {
    let argument = methods.argument_unstable_roots.map_or_else(|| "one on the axis".to_owned(), |n| n.to_string());
    let spectrum = methods.spectrum_unstable_roots.map_or_else(|| "no answer".to_owned(), |n| n.to_string());
    let rightmost = methods.rightmost_roots.first().map_or_else(String::new, |root| {
        format!("; rightmost {:.3} +- {:.3}j rad/s", root.re_per_s, root.im_rad_s.abs())
    });
    let sampled = methods.sampled_spectral_radius.map_or_else(
        || "no answer".to_owned(),
        |radius| format!("{radius:.5} ({})", if radius < 1.0 { "stable" } else { "unstable" }),
    );
    let _ = writeln!(out, "  unstable roots by the curves       {}", methods.curves_unstable_roots);
    let _ = writeln!(out, "  by the argument principle          {argument}");
    let _ = writeln!(out, "  by the Chebyshev discretisation    {spectrum}{rightmost}");
    let _ = writeln!(out, "  spectral radius, sampled {} ms    {sampled}", methods.sampled_period_s * 1e3);
    for reason in &methods.unanswered {
        let _ = writeln!(out, "  No answer: {reason}");
    }
    if !methods.agree {
        let _ = writeln!(out, "  Not all agree: the loop is at its limit, or as fast as the control period.");
    }
}

fn margins(out: &mut String, margins: &Margins) {
    let _ = writeln!(out, "\nMargins of the loop opened at the control torque:");
    let or_none = |value: Option<String>| value.unwrap_or_else(|| "none".to_owned());
    let _ = writeln!(out, "  gain   {}", or_none(margins.gain.map(|v| format!("{v:.4}"))));
    let _ = writeln!(out, "  lower  {}", or_none(margins.gain_lower.map(|v| format!("{v:.4}"))));
    let phase = margins.phase_deg.zip(margins.crossover_rad_s);
    let _ = writeln!(out, "  phase  {}", or_none(phase.map(|(deg, w)| format!("{deg:.3} degrees at {w:.2} rad/s"))));
    let delay = margins.delay_s.zip(margins.delay_factor);
    let delay = delay.map(|(s, factor)| format!("{:.4} ms more, L times {factor:.4}", s * 1e3));
    let _ = writeln!(out, "  delay  {}", or_none(delay));
}

fn tolerances(out: &mut String, tolerances: &[Tolerance]) {
    if tolerances.is_empty() {
        return;
    }
    let _ = writeln!(out, "\nMay move alone, as a factor (value at the limit):");
    for &Tolerance { quantity, nominal, lower, upper } in tolerances {
        let (label, scale) = labelled(quantity);
        let limit = |limit: Option<Limit>, none: &str| {
            limit.map_or_else(|| none.to_owned(), |l| format!("{:.4} ({:.5})", l.factor, l.value * scale))
        };
        let (down, up) = (limit(lower, "any less"), limit(upper, "any more"));
        let _ = writeln!(out, "  {label:<15} {:<9.5} down to {down:<20} up to {up}", nominal * scale);
    }
}

/// A quantity by its letter and unit, and how many of that unit are in one of its own.
pub(super) fn labelled(quantity: Quantity) -> (&'static str, f64) {
    match quantity {
        Quantity::TorqueDelay => ("L, ms", 1e3),
        Quantity::FluidDelay => ("L_Q or T_Q, ms", 1e3),
        Quantity::Kp => ("K_P, N m/rad", 1.0),
        Quantity::Kd => ("K_D, N m s/rad", 1.0),
        Quantity::BothGains => ("K_P and K_D", 1.0),
        Quantity::Inertia => ("J, kg m2", 1.0),
        Quantity::Q1 => ("Q1, N m s/rad", 1.0),
    }
}

fn limit_cycles(out: &mut String, analysis: &Analysis) {
    let Some(models) = &analysis.limit_cycles else { return };
    let _ = writeln!(out, "\nLimit cycles by harmonic balance (friction, damper law and torque limit in place of Q):");
    for model in models {
        let cycles: Vec<String> = model
            .cycles
            .iter()
            .map(|cycle| {
                let kind = if cycle.stable { "lasting" } else { "dividing" };
                let (mrad, w) = (cycle.amplitude_rad * 1e3, cycle.frequency_rad_s);
                format!("{kind} {mrad:.3} mrad at {w:.1} rad/s")
            })
            .collect();
        let cycles = if cycles.is_empty() { "none".to_owned() } else { cycles.join(", ") };
        let left_mrad = model.simulated_amplitude_rad * 1e3;
        let _ = writeln!(out, "  {:<24} {cycles}; {left_mrad:.3} mrad left in a run", model.model);
    }
}
