//! Any message of the link, for properties.

use er_servo::experiment::{Experiment, Shape};
use er_servo::link::{Answer, Command, Counters, Packet, Refusal, Status};
use proptest::prelude::*;

pub fn any_float() -> impl Strategy<Value = f32> {
    // Not NaN, which equals nothing; the infinities are in.
    any::<u32>().prop_map(f32::from_bits).prop_filter("a number", |value| !value.is_nan())
}

pub fn any_shape() -> impl Strategy<Value = Shape> {
    let three = || (any_float(), any_float(), any_float());
    prop_oneof![
        any_float().prop_map(|amplitude_rad| Shape::Step { amplitude_rad }),
        (any_float(), any_float(), any::<u32>()).prop_map(|(amplitude_rad, dwell_s, seed)| Shape::Steps {
            amplitude_rad,
            dwell_s,
            seed
        }),
        (three(), any::<u8>()).prop_map(|((amplitude_rad, low_hz, high_hz), tones)| Shape::Multisine {
            amplitude_rad,
            low_hz,
            high_hz,
            tones
        }),
        three().prop_map(|(amplitude_rad, from_hz, to_hz)| Shape::Chirp { amplitude_rad, from_hz, to_hz }),
        (any_float(), any_float()).prop_map(|(speed_rad_s, travel_rad)| Shape::Ramp { speed_rad_s, travel_rad }),
    ]
}

pub fn any_command() -> impl Strategy<Value = Command> {
    use Command::*;
    prop_oneof![
        Just(Hello),
        Just(Enable),
        Just(Disable),
        Just(ClearFault),
        any::<i32>().prop_map(|counts| Reference { counts }),
        Just(Hold),
        (any_shape(), any_float()).prop_map(|(shape, duration_s)| Run(Experiment { shape, duration_s })),
        any::<u8>().prop_map(|index| ReadParameter { index }),
        (any::<u8>(), any_float()).prop_map(|(index, value)| WriteParameter { index, value }),
        Just(Apply),
        Just(Defaults),
        Just(Load),
        Just(Save),
        any::<u32>().prop_map(|run| StartRecording { run }),
        Just(StopRecording),
        Just(Status),
    ]
}

prop_compose! {
    pub fn any_packet()(session: u32, sequence: u32, command in any_command()) -> Packet {
        Packet { session, sequence, command }
    }
}

prop_compose! {
    fn any_status()(
        words: [u32; 9], position: i32, reference: i32, torque_nm in any_float(), field_kv_mm in any_float(),
        halves: [u16; 3], bytes: [u8; 3], recording: bool,
    ) -> Status {
        let [tick, worst_cycles, packets, damaged, overlong, replayed, refused, ..] = words;
        let counters = Counters { packets, damaged, overlong, replayed, refused };
        let ([faults, monitor, lost], [state, resolver_faults, flags]) = (halves, bytes);
        Status {
            tick, state, faults, resolver_faults, flags, position, reference, torque_nm, field_kv_mm, monitor,
            worst_cycles, lost, recording, counters,
        }
    }
}

pub fn any_answer() -> impl Strategy<Value = Answer> {
    let refusals = [
        Refusal::Session,
        Refusal::NotRunning,
        Refusal::Running,
        Refusal::Recording,
        Refusal::Index,
        Refusal::Value,
        Refusal::NothingStored,
        Refusal::Storage,
        Refusal::Hardware,
        Refusal::Booting,
        Refusal::Fault,
        Refusal::NoFault,
        Refusal::InterlockOpen,
        Refusal::StopPressed,
    ];
    prop_oneof![
        (any::<u32>(), any::<u16>(), any::<u8>(), any::<u8>(), any::<[u8; 8]>()).prop_map(
            |(session, protocol, frame_schema, parameters, build)| Answer::Hello {
                session,
                protocol,
                frame_schema,
                parameters,
                build
            }
        ),
        Just(Answer::Done),
        proptest::sample::select(refusals.to_vec()).prop_map(Answer::Refused),
        any_float().prop_map(|value| Answer::Parameter { value }),
        any_status().prop_map(Answer::Status),
    ]
}
