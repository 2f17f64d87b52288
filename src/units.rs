//! Counts, codes and their scaling.

/// Pole pairs of the resolver (control.md section 1).
pub const POLE_PAIRS: i32 = 120;
/// Counts within one pole pair: the converter runs in its 12-bit mode.
pub const COUNTS_PER_POLE_PAIR: i32 = 4096;
/// Counts of one revolution, 491,520.
pub const COUNTS_PER_REV: i32 = POLE_PAIRS * COUNTS_PER_POLE_PAIR;
/// Radians of one count, 2 pi / 491,520.
pub const RAD_PER_COUNT: f32 = (core::f64::consts::TAU / COUNTS_PER_REV as f64) as f32;

/// A position in resolver counts, unwrapped across pole pairs; +-2^31 counts are +-4,369 revolutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Counts(pub i32);

impl Counts {
    /// The angle, rad, in double precision for hosts; the law itself keeps to counts up to the error.
    pub fn to_rad(self) -> f64 {
        f64::from(self.0) * (core::f64::consts::TAU / f64::from(COUNTS_PER_REV))
    }

    /// The nearest count to an angle, rad; saturates at the ends of the range, and NaN is 0.
    pub fn from_rad(angle_rad: f64) -> Self {
        let counts = angle_rad * (f64::from(COUNTS_PER_REV) / core::f64::consts::TAU);
        // `as` truncates toward zero and saturates; the half makes it round half away from zero.
        Self((counts + if counts < 0.0 { -0.5 } else { 0.5 }) as i32)
    }
}

/// Twelve-bit reading within one pole pair, 0 to 4095; higher bits are ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ResolverCode(pub u16);

impl ResolverCode {
    /// Signed way from `earlier` to `self`, counts, taken the short way round: -2048 to 2047.
    pub(crate) fn since(self, earlier: Self) -> i32 {
        let difference = (i32::from(self.0) - i32::from(earlier.0)) & (COUNTS_PER_POLE_PAIR - 1);
        if difference >= COUNTS_PER_POLE_PAIR / 2 { difference - COUNTS_PER_POLE_PAIR } else { difference }
    }
}

/// Twelve-bit reading of the field monitor: 0 to 4095 is 0 to 4 kV/mm (board.md, ADC1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MonitorCode(pub u16);

impl MonitorCode {
    /// Full scale of the monitor, kV/mm.
    pub const FULL_SCALE_KV_MM: f32 = 4.0;
    const KV_MM_PER_CODE: f32 = Self::FULL_SCALE_KV_MM / 4095.0;

    /// The field that acted, kV/mm.
    pub fn to_kv_mm(self) -> f32 {
        f32::from(self.0) * Self::KV_MM_PER_CODE
    }

    /// The nearest code to a field, kV/mm; saturates at 0 and full scale, and NaN is 0.
    pub fn from_kv_mm(field_kv_mm: f32) -> Self {
        // The cast saturates below zero and sends NaN to 0.
        Self(((field_kv_mm / Self::KV_MM_PER_CODE + 0.5) as u16).min(4095))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_count_is_12_8_microradians() {
        assert!((f64::from(RAD_PER_COUNT) - 1.278_317_3e-5).abs() < 1e-12);
        assert_eq!(Counts::from_rad(core::f64::consts::TAU), Counts(COUNTS_PER_REV));
        assert_eq!(Counts::from_rad(f64::NAN), Counts(0));
        assert_eq!(Counts::from_rad(Counts(-123_457).to_rad()), Counts(-123_457));
    }

    #[test]
    fn codes_unwrap_the_short_way() {
        let table = [(0, 0, 0), (1, 4095, 2), (4095, 0, -1), (2047, 0, 2047), (2048, 0, -2048), (0, 2049, 2047)];
        for (now, before, counts) in table {
            assert_eq!(ResolverCode(now).since(ResolverCode(before)), counts, "{before} -> {now}");
        }
    }

    #[test]
    fn monitor_round_trips() {
        for code in 0..4096 {
            assert_eq!(MonitorCode::from_kv_mm(MonitorCode(code).to_kv_mm()), MonitorCode(code));
        }
        assert_eq!(MonitorCode::from_kv_mm(-1.0), MonitorCode(0));
        assert_eq!(MonitorCode::from_kv_mm(9.0), MonitorCode(4095));
    }
}
