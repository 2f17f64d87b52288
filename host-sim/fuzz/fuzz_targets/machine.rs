//! Any bytes as a machine file: a message or a machine that writes and reads back the same.
#![no_main]

use std::path::Path;

use recording::Machine;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let file = Path::new("fuzz.toml");
    if let Ok(machine) = Machine::from_bytes(file, bytes) {
        let text = machine.to_toml().expect("a machine that was read can be written");
        assert_eq!(Machine::from_bytes(file, text.as_bytes()).expect("what was written can be read"), machine);
    }
});
