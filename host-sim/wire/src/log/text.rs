//! The messages of the image's log as what they mean; their wording is that of the image's `log` module.

use er_servo::parameters::TABLE;
use er_servo::{Config, FRAME_SCHEMA, Frame, Params, State};

use super::{Begin, Build, Entry, Error};

/// How the message starts that begins a recording.
const BEGIN: &str = "recording run ";

/// A message as what it means; a frame or a begin that was damaged on the way is `None`.
///
/// # Errors
///
/// A recording of another release.
pub(super) fn entry(text: &str) -> Result<Option<Entry>, Error> {
    if let Some(bytes) = text.strip_prefix("frame ") {
        let frame = list(bytes).and_then(|bytes| Frame::decode(&bytes).ok());
        return Ok(frame.map(|frame| Entry::Frame(Box::new(frame))));
    }
    if text.starts_with(BEGIN) {
        return Ok(begin(text)?.map(|begin| Entry::Begin(Box::new(begin))));
    }
    Ok(Some(if text == "recording ended" { Entry::End } else { Entry::Event(text.to_owned()) }))
}

/// The build that the begin of a recording names; none in any other text.
pub(super) fn build_in(text: &str) -> Option<Build> {
    if text.starts_with(BEGIN) { list(field(text, "build")?)?.try_into().ok() } else { None }
}

/// What stands behind a name in the begin of a recording.
fn field<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(&format!("{name} "))?;
    let end = if rest.starts_with('[') { rest.find(']').map(|at| at + 1) } else { rest.find(' ') };
    rest.get(..end.unwrap_or(rest.len()))
}

fn number(text: &str, name: &str) -> Option<u32> {
    field(text, name)?.parse().ok()
}

fn begin(text: &str) -> Result<Option<Begin>, Error> {
    if let Some(schema) = number(text, "schema").filter(|schema| *schema != u32::from(FRAME_SCHEMA)) {
        return Err(Error::Schema(schema));
    }
    let Some(values) = field(text, "parameters").and_then(list) else { return Ok(None) };
    if values.len() != 4 * TABLE.len() {
        return Err(Error::Parameters { count: values.len() / 4 });
    }
    let mut config = Config::default();
    for (parameter, value) in TABLE.iter().zip(values.as_chunks::<4>().0) {
        (parameter.set)(&mut config, f32::from_le_bytes(*value));
    }
    // No drive runs with others.
    if Params::new(&config).is_err() {
        return Ok(None);
    }
    let state = field(text, "state").and_then(list).and_then(|bytes| State::decode(&bytes).ok());
    let (run, tick) = (number(text, "run"), number(text, "tick"));
    let (Some(run), Some(build), Some(tick), Some(state)) = (run, build_in(text), tick, state) else {
        return Ok(None);
    };
    Ok(Some(Begin { run, build, tick, state, config }))
}

/// `[1, 2, 3]` as bytes.
fn list(text: &str) -> Option<Vec<u8>> {
    let inner = text.strip_prefix('[')?.strip_suffix(']')?;
    inner.split(", ").map(|byte| byte.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_begin_of_a_recording_is_read_back() {
        let config = Config { kp_nm_rad: 300.0, ..Config::default() };
        let values: Vec<u8> = TABLE.iter().flat_map(|parameter| (parameter.get)(&config).to_le_bytes()).collect();
        let state = State::running_at(er_servo::Counts(5000));
        let text = format!(
            "recording run 7 schema {FRAME_SCHEMA} build [1, 2, 3, 4, 5, 6, 7, 8] tick 99 state {:?} parameters {:?}",
            state.encode(),
            values
        );
        let read = begin(&text).unwrap().unwrap();
        assert_eq!(read, Begin { run: 7, build: [1, 2, 3, 4, 5, 6, 7, 8], tick: 99, state, config });
        assert_eq!(begin(&text.replace(&format!("schema {FRAME_SCHEMA}"), "schema 9")), Err(Error::Schema(9)));
        assert_eq!(
            begin(&text.replace(" parameters [", " parameters [0, 0, 0, 0, ")),
            Err(Error::Parameters { count: TABLE.len() + 1 })
        );
        assert_eq!(begin(&text[..60]), Ok(None), "cut short");
        assert_eq!(begin(&text.replace("tick 99", "tick x")), Ok(None));
    }

    #[test]
    fn the_build_is_read_even_where_the_rest_cannot_be() {
        assert_eq!(
            build_in("recording run 7 schema 9 build [1, 2, 3, 4, 5, 6, 7, 8] tick"),
            Some([1, 2, 3, 4, 5, 6, 7, 8])
        );
        assert_eq!(build_in("er-servo 0.1.0, build [1, 2, 3, 4, 5, 6, 7, 8]"), None);
    }
}
