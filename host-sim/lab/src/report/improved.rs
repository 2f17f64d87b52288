//! The improved model, as a machine file.

use std::fmt::Write;

use super::{Answer, Verdict};

/// The text of the nominal machine file with an `[[effects]]` entry for each effect of the answer. Nothing is added where
/// the answer is not about physics.
pub fn improved_machine(nominal: &str, answer: &Answer) -> String {
    let mut text = nominal.trim_end().to_owned();
    text.push('\n');
    if answer.verdict == Verdict::Controller {
        return text;
    }
    for effect in &answer.effects {
        // Writing to a string cannot fail.
        let _ = write_entry(&mut text, effect);
    }
    text
}

fn write_entry(text: &mut String, effect: &super::EffectAnswer) -> std::fmt::Result {
    writeln!(text, "\n[[effects]]\nid = \"{}\"", effect.id)?;
    if let Some(recording) = &effect.recording {
        writeln!(text, "recording = {}", toml::Value::String(recording.clone()))?;
    }
    for parameter in &effect.parameters {
        writeln!(text, "{} = {:?}", parameter.id, parameter.value)?;
    }
    Ok(())
}
