//! The truth, closed away under its hash until the answers are in.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::Error;
use crate::plan::{Arm, Decoy};

/// A concealed effect with its values in the machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Concealed {
    /// Identifier; of the vocabulary, or of this crate for an effect outside it.
    pub id: String,
    /// Whether the vocabulary knows it.
    pub in_vocabulary: bool,
    /// Fraction of the clear size in the fixed plan, multiple of the detectable size in the drawn one, 1.
    pub size: f64,
    /// How far its leading parameter is from having no effect, in that parameter's unit, or one over it where small
    /// values are strong.
    pub strength: f64,
    /// Values by parameter.
    pub parameters: Vec<(String, f64)>,
}

/// What is true of a drawn machine and its log; SI units of its axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachineTruth {
    /// Linear and not rotary.
    pub linear: bool,
    /// Control period, s.
    pub period_s: f64,
    /// kg m2 or kg.
    pub inertia: f64,
    /// Root mean square of the drive's torque, N m or N.
    pub torque_rms: f64,
    /// Root mean square of the speed while moving.
    pub speed_rms: f64,
    /// Half the way between the ends of the motion.
    pub travel: f64,
    /// Of the position.
    pub step: f64,
    /// Whether it has a damper.
    pub fluid: bool,
    /// Whether the machine file has the law that ran.
    pub flashed_law: bool,
    /// Whether the torque column was measured.
    pub measured_torque: bool,
    /// Its stamps are later than the torque by this, s.
    pub skew_s: f64,
    /// Families of the effects outside the vocabulary.
    pub families: Vec<String>,
    /// Effects that stand for what belongs to the log or the noise: they need not be named, and are not wrong.
    pub beside: Vec<String>,
    /// Order over the position of the noise's ripple; none without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ripple_order: Option<f64>,
}

/// What is true of one case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Of the case.
    pub seed: u64,
    /// Kind of question.
    pub arm: Arm,
    /// How the log or the machine file misleads.
    pub decoy: Option<Decoy>,
    /// What was concealed; nothing for a clean machine.
    pub effects: Vec<Concealed>,
    /// Standard deviations of the torque noise, N m, and of the sensor noise, rad.
    pub torque_noise_nm: f64,
    /// See above.
    pub sensor_noise_rad: f64,
    /// The machine, where it was drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineTruth>,
    /// Drawn, so that the hash cannot be found by trying truths.
    pub salt: String,
}

impl Truth {
    /// The seal's text and its SHA-256, hexadecimal.
    ///
    /// # Errors
    /// A number JSON cannot write.
    pub fn seal(&self) -> Result<(String, String), Error> {
        let text = serde_json::to_string_pretty(self)?;
        let hash = hash(text.as_bytes());
        Ok((text, hash))
    }
}

/// SHA-256, hexadecimal.
pub fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
