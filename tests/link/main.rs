//! The drive's side of the command link: every message, sessions, refusals, and bytes that are none of its own.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bench;
mod messages;

use bench::Bench;
use er_servo::experiment::{Experiment, Shape};
use er_servo::link::{
    Answer, Command, PACKET_BYTES, PROTOCOL, Pace, Packet, ParameterSource, Receiver, Refusal, Reply, Server, Status,
    Target, encode,
};
use er_servo::{Config, Faults, InputFlags, Params, Request, SAMPLE_TO_OUTPUT_NS, parameters};
use messages::{any_answer, any_command, any_packet};
use proptest::prelude::*;

/// A server with an open session, and the drive it acts on.
struct Linked {
    server: Server,
    drive: Bench,
    session: u32,
    sequence: u32,
}

fn bytes(message: &impl serde::Serialize) -> Vec<u8> {
    encode(message, &mut [0; PACKET_BYTES]).unwrap().to_vec()
}

impl Linked {
    fn to(drive: Bench) -> Self {
        let mut linked =
            Self { server: Server::new(Config::default(), ParameterSource::BuiltIn), drive, session: 0, sequence: 0 };
        linked.hello();
        linked
    }

    fn feed(&mut self, bytes: &[u8]) -> Vec<Reply> {
        bytes.iter().filter_map(|byte| self.server.push(*byte, &mut self.drive)).collect()
    }

    fn hello(&mut self) {
        let packet = Packet { session: 0, sequence: 9, command: Command::Hello };
        match self.feed(&bytes(&packet))[..] {
            [Reply { sequence: 9, answer: Answer::Hello { session, protocol, build, sample_to_output_ns, .. } }] => {
                assert_eq!((protocol, build), (PROTOCOL, *b"er-servo"));
                assert_eq!(sample_to_output_ns, SAMPLE_TO_OUTPUT_NS);
                (self.session, self.sequence) = (session, 0);
            }
            ref other => panic!("{other:?}"),
        }
    }

    fn packet(&mut self, command: Command) -> Packet {
        self.sequence += 1;
        Packet { session: self.session, sequence: self.sequence, command }
    }

    fn ask(&mut self, command: Command) -> Answer {
        let packet = self.packet(command);
        match self.feed(&bytes(&packet))[..] {
            [Reply { sequence, answer }] if sequence == packet.sequence => answer,
            ref other => panic!("{command:?}: {other:?}"),
        }
    }

    fn refused(&mut self, command: Command, refusal: Refusal) {
        assert_eq!(self.ask(command), Answer::Refused(refusal), "{command:?}");
    }

    fn done(&mut self, command: Command) {
        assert_eq!(self.ask(command), Answer::Done, "{command:?}");
    }

    fn status(&mut self) -> Status {
        match self.ask(Command::Status) {
            Answer::Status(status) => status,
            other => panic!("{other:?}"),
        }
    }
}

fn experiment(amplitude_rad: f32) -> Command {
    let experiment = Experiment { shape: Shape::Step { amplitude_rad }, duration_s: 1.0 };
    Command::Run { experiment, torque_bound_nm: 0, autonomous: false }
}

fn refer(target: Target) -> Command {
    Command::Reference { target, pace: Pace::default(), torque_bound_nm: 0 }
}

const ENABLE: Command = Command::Enable { autonomous: false };
const APPLY: Command = Command::Apply { force: false };

fn received<T: for<'de> serde::Deserialize<'de>>(bytes: &[u8]) -> Option<T> {
    let mut receiver = Receiver::default();
    bytes.iter().find_map(|byte| receiver.push(*byte)?.ok())
}

/// Runs of bytes that a zero ends: what the server can see of them.
fn runs(bytes: &[u8]) -> u32 {
    bytes.split_inclusive(|byte| *byte == 0).filter(|run| run.len() > 1 && run.ends_with(&[0])).count() as u32
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn every_message_goes_through(packet in any_packet(), sequence: u32, answer in any_answer()) {
        prop_assert_eq!(received::<Packet>(&bytes(&packet)), Some(packet));
        let reply = Reply { sequence, answer };
        prop_assert_eq!(received::<Reply>(&bytes(&reply)), Some(reply));
    }

    #[test]
    fn any_bytes_are_counted_and_carry_nothing_out(noise in proptest::collection::vec(any::<u8>(), 0..2000)) {
        let mut linked = Linked::to(Bench::running());
        let asked = linked.drive.asked.len();
        prop_assert!(linked.feed(&noise).is_empty());
        let counters = linked.server.counters();
        prop_assert_eq!(counters.damaged + counters.overlong, runs(&noise));
        prop_assert_eq!(linked.drive.asked.len(), asked);
        // And what follows is understood.
        linked.feed(&[0]);
        linked.done(Command::Disable);
    }

    #[test]
    fn damaged_packets_carry_nothing_out(
        command in any_command(), flips in proptest::collection::vec((0..PACKET_BYTES, 1..=255_u8), 1..4), cut in 0..2_usize,
    ) {
        let mut linked = Linked::to(Bench::running());
        let good = bytes(&linked.packet(command));
        let mut bad = good.clone();
        for (at, flip) in flips {
            let at = at % (bad.len() - 1);
            bad[at] ^= flip;
        }
        bad.drain(..cut);
        prop_assume!(bad != good);
        linked.drive.asked.clear();
        bad.push(0);
        prop_assert!(linked.feed(&bad).is_empty());
        let counters = linked.server.counters();
        prop_assert_eq!(counters.damaged + counters.overlong, runs(&bad));
        prop_assert!(linked.drive.asked.is_empty());
    }

    #[test]
    fn any_commands_whatever_leave_parameters_the_law_accepts(
        commands in proptest::collection::vec(any_command(), 1..60), state in 0..3,
    ) {
        let mut linked = Linked::to(match state { 0 => Bench::new(), 1 => Bench::ready(), _ => Bench::running() });
        for command in commands {
            if command == Command::Hello { linked.hello() } else { linked.ask(command); }
            linked.drive.ticks(1, Request::None, Faults::empty());
            prop_assert!(!linked.drive.state.supervisor().faults().contains(Faults::PARAMETERS));
            if let Some(stored) = linked.drive.stored {
                prop_assert!(Params::new(&stored).is_ok());
            }
        }
    }
}

#[test]
fn a_packet_sent_again_is_answered_again_and_not_carried_out_again() {
    let mut linked = Linked::to(Bench::ready());
    let packet = bytes(&linked.packet(Command::StartRecording { run: 5, over_link: false }));
    let first = linked.feed(&packet);
    linked.drive.asked.clear();
    assert_eq!(linked.feed(&packet), first);
    assert_eq!(first[0].answer, Answer::Done);
    assert!(linked.drive.asked.is_empty(), "a replay does not keep the link alive");
    // Once the host has gone on, the packet is of the past.
    linked.status();
    assert_eq!(linked.feed(&packet), []);
    assert_eq!((linked.server.counters().packets, linked.server.counters().replayed), (2, 2));
}

#[test]
fn packets_of_an_earlier_session_are_refused() {
    let mut linked = Linked::to(Bench::ready());
    let old = bytes(&linked.packet(ENABLE));
    let before = linked.session;
    linked.hello();
    assert_ne!(linked.session, before);
    assert_eq!(linked.feed(&old)[0].answer, Answer::Refused(Refusal::Session));
    assert_eq!((linked.server.counters().replayed, linked.drive.asked.len()), (1, 0));
}

#[test]
fn without_a_session_nothing_is_carried_out() {
    let mut linked = Linked {
        server: Server::new(Config::default(), ParameterSource::BuiltIn),
        drive: Bench::ready(),
        session: 0,
        sequence: 0,
    };
    linked.refused(ENABLE, Refusal::Session);
    assert!(linked.drive.asked.is_empty());
}

#[test]
fn refusals_say_why() {
    let mut booting = Linked::to(Bench::new());
    booting.refused(ENABLE, Refusal::Booting);
    booting.refused(Command::Status, Refusal::Booting);

    let mut ready = Linked::to(Bench::ready());
    ready.refused(Command::ClearFault, Refusal::NoFault);
    for command in [refer(Target::Relative(1)), Command::Hold { autonomous: false }, experiment(0.1)] {
        ready.refused(command, Refusal::NotRunning);
    }
    ready.refused(experiment(100.0), Refusal::Value);
    ready.refused(Command::Load, Refusal::NothingStored);
    ready.refused(experiment(f32::NAN), Refusal::Value);
    ready.drive.flags = InputFlags::empty();
    ready.drive.ticks(1, Request::None, Faults::empty());
    ready.refused(ENABLE, Refusal::InterlockOpen);
    ready.drive.flags = InputFlags::INTERLOCK_CLOSED | InputFlags::STOP_PRESSED;
    ready.drive.ticks(1, Request::None, Faults::empty());
    ready.refused(ENABLE, Refusal::StopPressed);

    ready.drive.flags = InputFlags::INTERLOCK_CLOSED;
    ready.drive.ticks(1, Request::None, Faults::empty());
    ready.refused(ENABLE, Refusal::AmplifierNotReady);

    let mut running = Linked::to(Bench::running());
    running.refused(Command::SetPosition { counts: 0 }, Refusal::NotReady);
    running.refused(APPLY, Refusal::Running);
    running.refused(Command::Save, Refusal::Running);
    assert_eq!(running.status().counters.refused, 3);

    let mut faulty = Linked::to(Bench::ready());
    faulty.drive.ticks(1, Request::None, Faults::OUTPUT_BUS);
    faulty.refused(ENABLE, Refusal::Fault);
    faulty.drive.chips_fail = true;
    faulty.refused(Command::ClearFault, Refusal::Hardware);
    faulty.drive.chips_fail = false;
    assert!(!faulty.drive.asked.contains(&"make room"), "not for a clear that was refused");
    faulty.done(Command::ClearFault);
    assert!(faulty.drive.asked.contains(&"make room"), "for the next fault");
    assert_eq!(faulty.status().state, 0);
}

#[test]
fn parameters_act_when_applied_and_a_new_session_forgets_what_was_staged() {
    let mut linked = Linked::to(Bench::ready());
    let kp = parameters::TABLE.iter().position(|parameter| parameter.name == "kp_nm_rad").unwrap() as u8;
    let default = Answer::Parameter { value: Config::default().kp_nm_rad };
    linked.refused(Command::WriteParameter { index: kp, value: -1.0 }, Refusal::Value);
    linked.refused(Command::WriteParameter { index: kp, value: f32::NAN }, Refusal::Value);
    linked.refused(Command::WriteParameter { index: 200, value: 1.0 }, Refusal::Index);
    linked.refused(Command::ReadParameter { index: 200 }, Refusal::Index);
    linked.done(Command::WriteParameter { index: kp, value: 270.0 });
    linked.hello();
    assert_eq!(linked.ask(Command::ReadParameter { index: kp }), default, "not applied: forgotten");

    linked.done(Command::WriteParameter { index: kp, value: 270.0 });
    linked.done(APPLY);
    linked.done(Command::Save);
    let applied = Config { kp_nm_rad: 270.0, ..Config::default() };
    assert_eq!(linked.drive.params, Params::new(&applied).unwrap());
    linked.done(Command::Defaults);
    linked.done(APPLY);
    linked.done(Command::Load);
    linked.done(APPLY);
    assert_eq!(linked.drive.params, Params::new(&applied).unwrap());
}

#[test]
fn a_recording_knows_its_run_and_forbids_other_parameters() {
    let mut linked = Linked::to(Bench::ready());
    linked.done(Command::StartRecording { run: 7, over_link: false });
    assert_eq!(linked.drive.recording, Some((7, Config::default())));
    linked.refused(Command::StartRecording { run: 8, over_link: false }, Refusal::Recording);
    linked.refused(APPLY, Refusal::Recording);
    assert!(linked.status().recording);
    linked.done(Command::StopRecording);
    linked.done(APPLY);
}

#[test]
fn while_one_client_moves_the_drive_another_may_read_and_stop_it_and_no_more() {
    let mut owner = Linked::to(Bench::running());
    let (session, sequence) = (owner.session, owner.sequence);
    owner.hello();
    assert_ne!(owner.session, session, "the observer has a session of its own");
    owner.drive.asked.clear();
    assert_eq!(owner.status().state, 2);
    let numbers = [0, 1, 2].map(|back| match owner.ask(Command::Event { back }) {
        Answer::Event(event) => event.map(|event| event.number),
        other => panic!("{other:?}"),
    });
    assert_eq!(numbers, [Some(1), Some(0), None]);
    owner.ask(Command::ReadParameter { index: 1 });
    for command in [ENABLE, refer(Target::Relative(5)), experiment(0.1), APPLY, Command::ClearFault] {
        owner.refused(command, Refusal::Observer);
    }
    assert!(owner.drive.asked.is_empty(), "it neither commands nor keeps the link alive: {:?}", owner.drive.asked);
    owner.done(Command::Disable);
    assert_eq!(owner.drive.asked, ["request"]);
    // The first client goes on.
    (owner.session, owner.sequence) = (session, sequence);
    owner.done(ENABLE);
    // Once it is silent, or has said good-bye, the next one commands.
    owner.drive.alive = false;
    owner.hello();
    owner.done(Command::Hold { autonomous: false });
    owner.drive.alive = true;
    owner.done(Command::Bye);
    owner.refused(Command::Hold { autonomous: false }, Refusal::Observer);
    owner.hello();
    owner.done(Command::Hold { autonomous: false });
}

#[test]
fn absolute_references_need_a_homed_axis_and_keep_to_its_limits() {
    let mut linked = Linked::to(Bench::ready());
    let far = Config { position_min_rad: -1.0, position_max_rad: 1.0, ..Config::default() };
    linked.drive.params = Params::new(&far).unwrap();
    linked.done(ENABLE);
    linked.refused(refer(Target::Absolute(10)), Refusal::NotHomed);
    linked.done(refer(Target::Relative(10)));
    linked.done(Command::Disable);
    linked.drive.ticks(1, Request::None, Faults::empty());
    linked.done(Command::SetPosition { counts: 500 });
    assert!(linked.status().homed);
    linked.done(ENABLE);
    linked.done(refer(Target::Absolute(10)));
    linked.refused(refer(Target::Absolute(491_520)), Refusal::BeyondLimits);
    linked.refused(refer(Target::Relative(-491_520)), Refusal::BeyondLimits);
    let slow = Pace { speed_rad_s: f32::NAN, acceleration_rad_s2: 1.0 };
    linked.refused(Command::Reference { target: Target::Relative(1), pace: slow, torque_bound_nm: 0 }, Refusal::Value);
    let strong = Command::Reference { target: Target::Relative(1), pace: Pace::default(), torque_bound_nm: 31 };
    linked.refused(strong, Refusal::Value);
}

fn index(name: &str) -> u8 {
    parameters::TABLE.iter().position(|parameter| parameter.name == name).unwrap() as u8
}

#[test]
fn what_would_be_unstable_is_refused_unless_forced_and_what_is_built_in_always() {
    let mut linked = Linked::to(Bench::ready());
    linked.done(Command::WriteParameter { index: index("kd_nm_s_rad"), value: 0.0 });
    linked.refused(APPLY, Refusal::Unstable);
    linked.done(Command::Apply { force: true });
    assert_eq!((linked.status().parameters, linked.drive.last_asked()), (ParameterSource::Forced, "forced"));
    // Saved, it is still one that was forced, also when it is loaded again.
    linked.done(Command::Save);
    assert_eq!(linked.status().parameters, ParameterSource::StoredForced);
    linked.done(Command::Load);
    linked.refused(APPLY, Refusal::Unstable);
    linked.done(Command::Apply { force: true });
    assert_eq!(linked.status().parameters, ParameterSource::StoredForced);
    linked.done(Command::Defaults);
    linked.done(Command::Apply { force: true });
    assert_eq!((linked.status().parameters, linked.drive.last_asked()), (ParameterSource::BuiltIn, "set"));
    linked.done(Command::Save);
    assert_eq!(linked.status().parameters, ParameterSource::Flash);
    for (name, value) in [("period_s", 0.002), ("speed_from_converter", 1.0)] {
        linked.done(Command::Defaults);
        linked.done(Command::WriteParameter { index: index(name), value });
        linked.refused(APPLY, Refusal::BuiltIn);
        linked.refused(Command::Apply { force: true }, Refusal::BuiltIn);
    }
}

#[test]
fn damaged_stored_parameters_are_no_silent_defaults() {
    let mut linked = Linked::to(Bench::new());
    linked.server = Server::new(Config::default(), ParameterSource::Damaged);
    linked.hello();
    linked.drive.ticks(100, Request::None, Faults::PARAMETERS);
    let status = linked.status();
    assert_eq!((status.state, status.parameters), (3, ParameterSource::Damaged));
    linked.refused(Command::ClearFault, Refusal::ParametersDamaged);
    linked.done(Command::Defaults);
    linked.done(APPLY);
    linked.done(Command::ClearFault);
    assert_eq!(linked.status().parameters, ParameterSource::BuiltIn);
}
