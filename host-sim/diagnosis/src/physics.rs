//! The machine as an effect changes it.

use plant::{FieldResponse, FluidResponse, Model};

/// One external push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// Index of the recording it happens in.
    pub recording: usize,
    /// When, how long and how strong.
    pub pulse: plant::effects::Pulse,
}

/// A steady external sine; its phase is free in each recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tone {
    /// Hz.
    pub frequency_hz: f64,
    /// Amplitudes of sine and cosine of each recording, N m (N).
    pub phasors: Vec<(f64, f64)>,
}

/// Everything an effect can change: the plant's model, what differs from one recording to the next, and what belongs to the
/// log and not to the machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Physics {
    /// The machine.
    pub model: Model,
    /// Pushes, each in one recording.
    pub pushes: Vec<Push>,
    /// A sine from outside.
    pub tone: Option<Tone>,
    /// The position column lags the torque column by this, s; negative where it leads.
    pub skew_s: f64,
    /// The torque column is a measurement behind a first-order filter of this time constant, s.
    pub torque_filter_s: f64,
    /// The torque that acts is the mean of the commands of this time before, s.
    pub command_blur_s: f64,
    /// Share of wrong samples and their size, rad (m).
    pub glitch: Option<(f64, f64)>,
}

impl Physics {
    /// The machine and nothing else.
    pub fn new(model: Model) -> Self {
        Self {
            model,
            pushes: Vec::new(),
            tone: None,
            skew_s: 0.0,
            torque_filter_s: 0.0,
            command_blur_s: 0.0,
            glitch: None,
        }
    }

    /// The plant's model for one recording.
    pub fn model_of(&self, recording: usize) -> Model {
        let mut model = self.model.clone();
        model.pulses = self.pushes.iter().filter(|push| push.recording == recording).map(|push| push.pulse).collect();
        model.vibration = self.tone.as_ref().and_then(|tone| {
            let &(sine, cosine) = tone.phasors.get(recording)?;
            let (amplitude, phase_rad) = (sine.hypot(cosine), cosine.atan2(sine));
            Some(plant::effects::Vibration { frequency_hz: tone.frequency_hz, amplitude, phase_rad })
        });
        model
    }

    /// The response of the field, where the fluid's delay acts on it.
    pub fn field(&self) -> Option<FieldResponse> {
        match self.model.er.as_ref()?.response {
            FluidResponse::Field(field) => Some(field),
            _ => None,
        }
    }

    /// Changes the response of the field; nothing happens on a machine without one.
    pub fn with_field(&mut self, change: impl FnOnce(&mut FieldResponse)) {
        if let Some(er) = &mut self.model.er
            && let FluidResponse::Field(field) = &mut er.response
        {
            change(field);
        }
    }
}
