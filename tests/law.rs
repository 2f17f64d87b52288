//! For any input whatever: finite, within limits, no panic, and safe unless running.
#![allow(clippy::unwrap_used)]

use er_servo::{
    Config, Counts, FRAME_BYTES, Faults, Frame, InputFlags, Inputs, MonitorCode, Outputs, Params, Request,
    ResolverCode, ResolverSample, STATE_BYTES, State, Supervisor, Timing, parameters, step,
};
use proptest::prelude::*;

prop_compose! {
    fn any_config()(draws in proptest::collection::vec(0.0..=1.0_f32, parameters::TABLE.len())) -> Config {
        let mut config = Config::default();
        for (parameter, draw) in parameters::TABLE.iter().zip(draws) {
            let value = parameter.min + draw * (parameter.max - parameter.min);
            (parameter.set)(&mut config, if parameter.unit == "flag" { value.round() } else { value });
        }
        config
    }
}

prop_compose! {
    fn any_inputs()(
        code: u16, fault_byte in prop_oneof![9 => Just(0_u8), 1 => any::<u8>()], speed_bits: u32, flags: u8,
        reference: i32, request in 0..5_u8, torque_bound_nm in 0..32_u8, monitor: u16,
        reported in prop_oneof![9 => Just(0_u32), 1 => any::<u32>()],
    ) -> Inputs {
        Inputs {
            resolver: ResolverSample { code: ResolverCode(code), fault_byte, speed_rad_s: f32::from_bits(speed_bits) },
            flags: InputFlags::from_bits_truncate(flags),
            reference: Counts(reference),
            request: [
                Request::None,
                Request::Enable,
                Request::Disable,
                Request::ClearFault,
                Request::SetPosition,
            ][usize::from(request)],
            torque_bound_nm,
            field_monitor: MonitorCode(monitor),
            reported: Faults::from_bits_truncate(reported),
        }
    }
}

fn assert_sound(outputs: &Outputs) {
    assert!(outputs.torque_nm.abs() <= 30.0, "{outputs:?}");
    assert!((0.0..=3.5).contains(&outputs.field_kv_mm), "{outputs:?}");
    assert!(outputs.speed_rad_s.is_finite(), "{outputs:?}");
    if !matches!(outputs.supervisor, Supervisor::Running | Supervisor::Stopping { .. }) {
        assert_eq!((outputs.torque_nm, outputs.field_kv_mm, outputs.hv_enable), (0.0, 0.0, false));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_parameters_state_and_inputs_give_sound_outputs(
        config in any_config(),
        mut snapshot in proptest::collection::vec(any::<u8>(), STATE_BYTES),
        tags in (0..3_u8, 0..5_u8),
        inputs in proptest::collection::vec(any_inputs(), 1..40),
    ) {
        let Ok(params) = Params::new(&config) else { return Ok(()) };
        (snapshot[0], snapshot[1]) = tags;
        let mut state = State::decode(&snapshot).unwrap();
        for inputs in &inputs {
            let outputs = step(&params, &mut state, inputs);
            assert_sound(&outputs);
            let frame = Frame { seq: 1, lost: 0, inputs: *inputs, outputs, timing: Timing::default() };
            let decoded = Frame::decode(&frame.encode()).unwrap();
            prop_assert_eq!(decoded.outputs.torque_nm.to_bits(), outputs.torque_nm.to_bits());
            prop_assert_eq!(decoded.inputs.reference, inputs.reference);
        }
    }

    #[test]
    fn a_state_survives_its_snapshot(inputs in proptest::collection::vec(any_inputs(), 1..40)) {
        let params = Params::new(&Config::default()).unwrap();
        let mut state = State::running_at(Counts(0));
        for inputs in &inputs {
            let mut copy = State::decode(&state.encode()).unwrap();
            let outputs = step(&params, &mut state, inputs);
            prop_assert_eq!(step(&params, &mut copy, inputs), outputs);
            prop_assert_eq!(copy, state);
        }
    }

    #[test]
    fn any_bytes_are_a_frame_or_an_error(bytes in proptest::collection::vec(any::<u8>(), 0..64)) {
        let _ = Frame::decode(&bytes);
    }

    #[test]
    fn a_damaged_frame_is_refused(flip in 0..FRAME_BYTES * 8, inputs in any_inputs()) {
        let params = Params::new(&Config::default()).unwrap();
        let outputs = step(&params, &mut State::running_at(Counts(0)), &inputs);
        let mut bytes = Frame { seq: 7, lost: 0, inputs, outputs, timing: Timing::default() }.encode();
        bytes[flip / 8] ^= 1 << (flip % 8);
        prop_assert!(Frame::decode(&bytes).is_err());
    }
}

/// Running, at rest at 0 counts, nothing wrong.
fn healthy() -> Inputs {
    Inputs { flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE, ..Inputs::default() }
}

#[test]
fn each_cause_stops_the_drive_in_the_tick_it_is_seen() {
    let from_link = healthy().flags | InputFlags::REFERENCE_FROM_LINK;
    let with_flags = |flags| Inputs { flags, ..healthy() };
    let reported = |reported| Inputs { reported, ..healthy() };
    let resolver = |resolver| Inputs { resolver, ..healthy() };
    let far = ResolverSample { code: ResolverCode(2000), ..ResolverSample::default() };
    let lost = ResolverSample { fault_byte: 0x08, ..ResolverSample::default() };
    let causes = [
        (with_flags(InputFlags::empty()), Faults::INTERLOCK_OPEN),
        (with_flags(healthy().flags | InputFlags::STOP_PRESSED), Faults::STOP_PRESSED),
        (with_flags(from_link - InputFlags::LINK_ALIVE), Faults::LINK_LOST),
        (with_flags(healthy().flags | InputFlags::RESOLVER_UNREAD), Faults::RESOLVER_BUS),
        (resolver(lost), Faults::RESOLVER_CHIP),
        (resolver(far), Faults::RESOLVER_JUMP),
        (Inputs { field_monitor: MonitorCode(4000), ..healthy() }, Faults::FIELD_OVER),
        (reported(Faults::TICK_OVERRUN), Faults::TICK_OVERRUN),
        (reported(Faults::OUTPUT_BUS), Faults::OUTPUT_BUS),
    ];
    let params = Params::new(&Config::default()).unwrap();
    for (mut inputs, fault) in causes {
        let mut state = State::running_at(Counts(0));
        let before = step(&params, &mut state, &Inputs { reference: Counts(9000), ..healthy() });
        assert!(before.torque_nm > 0.0);
        inputs.reference = Counts(9000);
        let outputs = step(&params, &mut state, &inputs);
        assert_eq!(outputs.supervisor, Supervisor::Fault { faults: fault });
        assert_sound(&outputs);
    }
}

#[test]
fn a_frozen_resolver_is_found_under_torque_and_only_then() {
    let params = Params::new(&Config::default()).unwrap();
    let first_fault = |reference| {
        let mut state = State::running_at(Counts(0));
        let inputs = Inputs { reference: Counts(reference), ..healthy() };
        (0..2000).find(|_| step(&params, &mut state, &inputs).supervisor != Supervisor::Running)
    };
    // 9,000 counts ask for 27.6 N m; 1,000 for 3.07 N m, which friction and field together can hold.
    assert_eq!(first_fault(9000), Some(41));
    assert_eq!(first_fault(1000), None);
}
