//! The ER damper made linear: which field gives the wanted viscosity.

use crate::Params;
use crate::config::EQUATION_5;
use crate::maths;

/// Wanted coefficient of viscosity at a speed, N m s/rad, equation (5) as printed; a fit for 0 to 1.5 rad/s.
pub fn viscosity_nm_s_rad(speed_rad_s: f32) -> f32 {
    viscosity(EQUATION_5, speed_rad_s)
}

fn viscosity([q0, q1, q2]: [f32; 3], speed_rad_s: f32) -> f32 {
    let w = speed_rad_s.abs();
    maths::exp((q2 * w + q1) * w + q0)
}

impl Params {
    /// Wanted coefficient of viscosity at a speed with the parameters' own coefficients of (5), N m s/rad.
    pub fn viscosity_nm_s_rad(&self, speed_rad_s: f32) -> f32 {
        viscosity(self.exponent, speed_rad_s)
    }
}

/// Field whose torque over the zero-field drag is Q |w|, kV/mm, equation (4), before any limit.
///
/// Written as x/(h + sqrt(h^2 + x)) with x = Q |w|/a and h = b/2a, which equals (4) and loses no digits near rest.
pub fn field_for_damping_kv_mm(params: &Params, speed_rad_s: f32) -> f32 {
    let torque_nm = params.viscosity_nm_s_rad(speed_rad_s) * speed_rad_s.abs();
    let x = torque_nm * params.inverse_a;
    let h = params.half_b_over_a;
    let denominator = h + maths::sqrt(h * h + x);
    // Only b = 0 at rest gives 0/0, and no field is wanted there.
    if denominator > 0.0 { x / denominator } else { 0.0 }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Config;

    fn exact_field(w: f64) -> f64 {
        let (a, b) = (0.0704, 0.470);
        let q = (3.675 * w * w - 9.277 * w + 4.010).exp();
        -b / (2.0 * a) + ((b * b / (4.0 * a) + q * w) / a).sqrt()
    }

    #[test]
    fn follows_the_double_precision_equations_on_a_dense_grid() {
        let params = Params::new(&Config::default()).unwrap();
        let (mut worst, mut peak) = (0.0_f64, (0.0_f64, 0.0_f64));
        for i in 0..=1_500_000 {
            let w = f64::from(i) * 1e-6;
            let field = f64::from(field_for_damping_kv_mm(&params, w as f32));
            worst = worst.max((field - exact_field(f64::from(w as f32))).abs());
            if field > peak.0 {
                peak = (field, w);
            }
        }
        assert!(worst < 1e-4, "worst {worst:e} kV/mm");
        // Control.md section 2.
        assert!((peak.0 - 3.2725).abs() < 1e-4 && (peak.1 - 0.11902).abs() < 5e-4, "{peak:?}");
    }

    #[test]
    fn any_coefficients_within_their_ranges_give_a_field_that_is_a_number() {
        for (q0, q1, q2) in [(12.0, 8.0, 8.0), (-20.0, -20.0, -8.0), (12.0, -20.0, 8.0), (4.6, 0.0, 0.0)] {
            let config =
                Config { er_q0: q0, er_q1_s_rad: q1, er_q2_s2_rad2: q2, er_a: 1e-3, er_b: 0.0, ..Config::default() };
            let params = Params::new(&config).unwrap();
            for i in 0..=150 {
                let field = field_for_damping_kv_mm(&params, i as f32 * 0.01);
                assert!(field.is_finite() && field >= 0.0, "{config:?}: {field}");
            }
        }
    }

    #[test]
    fn has_the_values_of_the_specification() {
        let params = Params::new(&Config::default()).unwrap();
        for (w, q) in [(0.0, 55.147), (1.262_18, 0.158_09), (1.5, 0.194_61)] {
            assert!((viscosity_nm_s_rad(w) - q).abs() < 1e-4 * q.max(0.1), "Q({w})");
        }
        assert_eq!(field_for_damping_kv_mm(&params, 0.0), 0.0);
        assert!((field_for_damping_kv_mm(&params, 1.5) - 0.572).abs() < 5e-4);
    }
}
