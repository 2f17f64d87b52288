//! What the codes on the two DAC channels mean.
//!
//! Channel A is the torque command: two's complement over -10 V..10 V, which is -30 N m..30 N m. Channel B is the field
//! command: straight binary over 0 V..10 V, which is 0 kV..2 kV at the amplifier and, over the 0.5 mm gap, 0..4 kV/mm.
//! Both channels have code 0 at 0 V, so a cleared register is the safe state.

/// Torque at full scale of channel A (10 V), N m; also the greatest torque of the motor.
pub const TORQUE_FULL_SCALE_NM: f32 = 30.0;
/// Field at full scale of channel B (10 V), kV/mm.
pub const FIELD_FULL_SCALE_KV_MM: f32 = 4.0;
/// The greatest field a code may ask for, kV/mm: 3.5 kV/mm is 1.75 kV over the gap. The control law has the same limit;
/// this one holds even if that is wrong.
pub const FIELD_LIMIT_KV_MM: f32 = 3.5;

const TORQUE_CODES_PER_NM: f32 = 32_768.0 / TORQUE_FULL_SCALE_NM;
const FIELD_CODES_PER_KV_MM: f32 = 65_536.0 / FIELD_FULL_SCALE_KV_MM;
const FIELD_LIMIT_CODE: u16 = (FIELD_LIMIT_KV_MM * FIELD_CODES_PER_KV_MM) as u16;

/// Code of channel A, two's complement, 1/32768 of 30 N m a count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TorqueCode(i16);

/// Code of channel B, straight binary, 1/65536 of 4 kV/mm a count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FieldCode(u16);

impl TorqueCode {
    /// 0 N m.
    pub const ZERO: Self = Self(0);

    /// The nearest code to a torque in N m, saturated at +-32767; NaN gives [`Self::ZERO`].
    pub fn from_torque_nm(torque_nm: f32) -> Self {
        // `as` truncates, saturates and takes NaN to 0. The lowest code is left out so that both signs reach alike.
        let rounded = (torque_nm * TORQUE_CODES_PER_NM + 0.5_f32.copysign(torque_nm)) as i16;
        Self(rounded.max(-i16::MAX))
    }

    /// The torque this code asks for, N m.
    pub fn torque_nm(self) -> f32 {
        f32::from(self.0) / TORQUE_CODES_PER_NM
    }

    /// The 16 bits that go to the part.
    pub fn bits(self) -> u16 {
        self.0.cast_unsigned()
    }
}

impl FieldCode {
    /// 0 kV/mm.
    pub const ZERO: Self = Self(0);

    /// The nearest code to a field in kV/mm, saturated at 0 and [`FIELD_LIMIT_KV_MM`]; NaN gives [`Self::ZERO`].
    pub fn from_field_kv_mm(field_kv_mm: f32) -> Self {
        Self(((field_kv_mm * FIELD_CODES_PER_KV_MM + 0.5) as u16).min(FIELD_LIMIT_CODE))
    }

    /// The field this code asks for, kV/mm.
    pub fn field_kv_mm(self) -> f32 {
        f32::from(self.0) / FIELD_CODES_PER_KV_MM
    }

    /// The 16 bits that go to the part.
    pub fn bits(self) -> u16 {
        self.0
    }
}
