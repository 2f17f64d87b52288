//! Any bytes as a telemetry frame: an error, or a frame that encodes to the same bytes.
#![no_main]

use er_servo::{FRAME_BYTES, Frame};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(frame) = Frame::decode(bytes) {
        assert_eq!(bytes.len(), FRAME_BYTES);
        assert!(frame.outputs.torque_nm.is_finite() && frame.outputs.field_kv_mm.is_finite());
        assert_eq!(Frame::decode(&frame.encode()), Ok(frame));
    }
});
