//! Any bytes, and any commands, at the drive's end of the link: what is no packet of the session carries nothing out, and
//! whatever is asked for, the law keeps its limits and parameters it accepts.
#![no_main]

// The tests of `lab` use what is left of each.
#[path = "../../lab/tests/device/drive.rs"]
#[allow(dead_code)]
mod drive;
#[path = "../../lab/tests/device/log.rs"]
// As above.
#[allow(dead_code)]
mod log;

use drive::Machine;
use er_servo::link::{Answer, Command, Drive, PACKET_BYTES, Packet, ParameterSource, Reply, Server, encode};
use er_servo::{Config, FIELD_CEILING_KV_MM, Faults, Params, TORQUE_CEILING_NM};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut machine = Machine::ready(None);
    let mut server = Server::new(Config::default(), ParameterSource::BuiltIn);
    let Some((kind, mut rest)) = bytes.split_first() else { return };
    if kind % 2 == 0 {
        let ends = rest.iter().filter(|byte| **byte == 0).count() as u32;
        for byte in rest {
            server.push(*byte, &mut machine);
        }
        let counters = server.counters();
        assert!(counters.damaged + counters.overlong + counters.packets + counters.replayed <= ends);
        return;
    }
    let mut packet = Packet { session: 0, sequence: 1, command: Command::Hello };
    while let Some(Reply { sequence, answer }) = ask(&mut server, &mut machine, &packet) {
        assert_eq!(sequence, packet.sequence);
        if let Answer::Hello { session, .. } = answer {
            packet.session = session;
        }
        machine.ticks(3);
        check(&mut machine);
        let Ok((command, behind)) = postcard::take_from_bytes(rest) else { return };
        (packet.command, rest) = (command, behind);
        packet.sequence += 1;
    }
    panic!("{packet:?} was not answered");
});

fn ask(server: &mut Server, machine: &mut Machine, packet: &Packet) -> Option<Reply> {
    let mut bytes = [0; PACKET_BYTES];
    let sent = encode(packet, &mut bytes).expect("every command fits a packet");
    let replies: Vec<Reply> = sent.iter().filter_map(|byte| server.push(*byte, machine)).collect();
    let [reply] = replies[..] else { return None };
    encode(&reply, &mut [0; PACKET_BYTES]).expect("every answer fits a packet");
    Some(reply)
}

fn check(machine: &mut Machine) {
    let outputs = machine.last_frame().expect("it has ticked").outputs;
    assert!(outputs.torque_nm.abs() <= TORQUE_CEILING_NM);
    assert!((0.0..=FIELD_CEILING_KV_MM).contains(&outputs.field_kv_mm));
    assert!(!outputs.supervisor.faults().contains(Faults::PARAMETERS));
    if let Ok(stored) = machine.load() {
        assert!(Params::new(&stored).is_ok());
    }
}
