//! Any message of the link, for properties.

use er_servo::events::{Event, Restart};
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::{Answer, Command, Counters, Pace, Packet, ParameterSource, Refusal, Status, Target};
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
        Just(Bye),
        any::<bool>().prop_map(|autonomous| Enable { autonomous }),
        Just(Disable),
        Just(ClearFault),
        any::<i32>().prop_map(|counts| SetPosition { counts }),
        (any::<i32>(), any::<bool>(), any_float(), any_float(), any::<u8>()).prop_map(
            |(counts, absolute, speed_rad_s, acceleration_rad_s2, torque_bound_nm)| Reference {
                target: if absolute { Target::Absolute(counts) } else { Target::Relative(counts) },
                pace: Pace { speed_rad_s, acceleration_rad_s2 },
                torque_bound_nm,
            }
        ),
        any::<bool>().prop_map(|autonomous| Hold { autonomous }),
        (any_shape(), any_float(), any::<u8>(), any::<bool>()).prop_map(
            |(shape, duration_s, torque_bound_nm, autonomous)| Run {
                experiment: Experiment { shape, duration_s },
                torque_bound_nm,
                autonomous,
            }
        ),
        any::<u8>().prop_map(|index| ReadParameter { index }),
        (any::<u8>(), any_float()).prop_map(|(index, value)| WriteParameter { index, value }),
        any::<bool>().prop_map(|force| Apply { force }),
        Just(Defaults),
        Just(Load),
        Just(Save),
        any::<(u32, bool)>().prop_map(|(run, over_link)| StartRecording { run, over_link }),
        Just(StopRecording),
        Just(Status),
        any::<u8>().prop_map(|back| Event { back }),
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
        halves: [u16; 2], bytes: [u8; 3], recording: bool, homed: bool,
        parameters in proptest::sample::select(vec![
            ParameterSource::BuiltIn, ParameterSource::Flash, ParameterSource::Link, ParameterSource::Forced,
            ParameterSource::StoredForced, ParameterSource::Damaged, ParameterSource::RolledBack,
        ]),
    ) -> Status {
        let [tick, worst_cycles, packets, damaged, overlong, replayed, refused, faults, ..] = words;
        let counters = Counters { packets, damaged, overlong, replayed, refused };
        let ([monitor, lost], [state, resolver_faults, flags]) = (halves, bytes);
        Status {
            tick, state, faults, resolver_faults, flags, position, reference, torque_nm, field_kv_mm, monitor,
            worst_cycles, lost, recording, homed, parameters, counters,
        }
    }
}

prop_compose! {
    fn any_event()(
        words: [u32; 4], position: i32, speed_rad_s in any_float(), resolver_faults: u8, place: u16,
        restart in 0..6_usize,
    ) -> Event {
        let [number, faults, at_ms, worst_cycles] = words;
        let restarts = [
            None, Some(Restart::Watchdog), Some(Restart::Panic(place)), Some(Restart::HardFault),
            Some(Restart::ClockFailed), Some(Restart::Interrupt(place)),
        ];
        let restart = restarts[restart];
        Event { number, faults, at_ms, position, speed_rad_s, worst_cycles, resolver_faults, restart }
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
        Refusal::AmplifierNotReady,
        Refusal::NotReady,
        Refusal::NotHomed,
        Refusal::BeyondLimits,
        Refusal::Observer,
        Refusal::Unstable,
        Refusal::BuiltIn,
        Refusal::ParametersDamaged,
    ];
    prop_oneof![
        (any::<[u32; 2]>(), any::<bool>(), any::<u16>(), any::<u8>(), any::<u8>(), any::<[u8; 8]>()).prop_map(
            |([session, sample_to_output_ns], observer, protocol, frame_schema, parameters, build)| Answer::Hello {
                session,
                observer,
                protocol,
                frame_schema,
                parameters,
                build,
                sample_to_output_ns
            }
        ),
        Just(Answer::Done),
        proptest::sample::select(refusals.to_vec()).prop_map(Answer::Refused),
        any_float().prop_map(|value| Answer::Parameter { value }),
        any_status().prop_map(Answer::Status),
        proptest::option::of(any_event()).prop_map(Answer::Event),
    ]
}
