//! Times of rise and fall that depend on the field: to E the field rises in rise / E^p, from E it falls in fall / E^q, E in kV/mm
//! and at least 0.1; p and q are the exponents, rise and fall the lags at 1 kV/mm.

use plant::er_fluid::Kinetics;

use super::{Effect, PLAIN, free, shown, with_field};

/// Fields that differ by less than this share are one level: it is about what a converter of eight bits rounds off at a tenth of
/// its range, and changes a time constant by a tenth at most.
const SAME_LEVEL: f64 = 0.05;

/// The entry of the vocabulary. Without a lag, nominal or found, there is nothing that could depend on the field.
pub static EFFECT: Effect = Effect {
    id: "field_kinetics",
    sentence: "Strong fields build up and fall at another pace than weak ones: particles are drawn into chains by forces that grow with the field.",
    parameters: &[free(0.0, 2.0, 0.1), free(0.0, 2.0, 0.1)],
    applies: |p, e| with_field(p, e) && e.field_peak > (1.0 + SAME_LEVEL) * e.field_least,
    starts: |p, _| {
        if p.field().is_none_or(|field| field.rise_s <= 0.0 && field.fall_s <= 0.0) {
            return Vec::new();
        }
        let powers = [0.0, 0.5, 1.0, 2.0];
        let all = powers.iter().flat_map(|&rise| powers.map(|fall| vec![rise, fall]));
        all.skip(1).collect()
    },
    put: |p, v| {
        p.with_field(|field| field.kinetics = Kinetics { rise_exponent: v[0], fall_exponent: v[1] });
    },
    leading: &[0, 1],
    example: shown(|f| vec![f, f]),
    ..PLAIN
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Excitation;
    use crate::physics::Physics;
    use plant::{Er, Model};

    #[test]
    fn it_takes_several_levels_and_a_lag() {
        let physics = |lag_s| Physics::new(Model { er: Some(Er::new(0.07, 0.47, 0.002, lag_s)), ..Model::new(0.075) });
        let levels = |field_least, field_peak| Excitation { field_least, field_peak, ..Excitation::default() };
        let applies = |excitation| (EFFECT.applies)(&physics(0.003), &excitation);
        assert!(applies(levels(1.0, 3.0)));
        assert!(!applies(levels(3.0, 3.0)) && !applies(levels(0.0, 0.0)));
        let starts = |lag_s| (EFFECT.starts)(&physics(lag_s), &levels(1.0, 3.0)).len();
        assert_eq!((starts(0.003), starts(0.0)), (15, 0));
    }
}
