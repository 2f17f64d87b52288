//! The command link from a user's command line to the law, and what neither side may be disturbed by.

use std::io::{BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use er_servo::Faults;
use er_servo::link::{Answer, Command, PACKET_BYTES, PROTOCOL, Pace, Packet, Receiver, Reply, Target, encode};
use lab::line::Line;
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use wire::client::Client;
use wire::connection::LinkError;

use crate::far::Far;
use crate::{fails, lab, printed};

const HERE: &str = ".";

fn done(far: &Far, action: &str) -> String {
    printed(Path::new(HERE), &far.line(action))
}

fn refused(far: &Far, action: &str, code: i32) -> String {
    fails(Path::new(HERE), &far.line(action), code)
}

#[test]
fn every_command_is_carried_out() {
    let far = Far::start(None);
    let status = done(&far, "status");
    assert!(status.contains("state        ready\ninterlock    closed\n"), "{status}");
    // The stand-in's build id, "er-servo".
    assert!(status.contains("image        65722d736572766f\n"), "{status}");
    assert_eq!(done(&far, "enable --for-s 0.1"), "running\nstopped\n");
    assert_eq!(done(&far, "enable --autonomous"), "running\n");
    for experiment in ["step", "steps", "multisine", "chirp", "ramp"] {
        let text = done(&far, &format!("run {experiment} --duration-s 0.1"));
        assert_eq!(text, "runs for 0.1 s\n", "{experiment}");
    }
    done(&far, "hold --autonomous");
    assert!(done(&far, "status --json").contains("\"state\": \"running\""));
    assert!(refused(&far, "reference --deg -5 --for-s 0.5", 3).contains("the axis is not homed"));
    assert_eq!(done(&far, "disable"), "stopped\n");
    done(&far, "home");
    done(&far, "enable --autonomous");
    let text = done(&far, "reference --deg -5 --speed 2 --accel 50 --max-torque-nm 10 --for-s 1.5");
    assert!(text.starts_with("reference -0.087271 rad, position ") && text.ends_with("stopped\n"), "{text}");
    assert_eq!(done(&far, "run step --enable --duration-s 0.1"), "running\nruns for 0.1 s\nstopped\n");

    let unstable = refused(&far, "set kd_nm_s_rad=0", 2);
    assert!(unstable.contains("margins too small: phase"), "{unstable}");
    done(&far, "set kd_nm_s_rad=0 --force");
    assert!(done(&far, "status").contains("forced against the stability margins"));
    done(&far, "defaults");
    done(&far, "set kp_nm_rad=270 hold=true");
    done(&far, "save");
    let held = "kp_nm_rad = 270 # N m/rad, 0 to 5000\nhold = true\n";
    assert_eq!(done(&far, "get hold kp_nm_rad"), held);
    done(&far, "defaults");
    assert_ne!(done(&far, "get hold kp_nm_rad"), held);
    done(&far, "load");
    assert_eq!(done(&far, "get hold kp_nm_rad"), held);
    assert_eq!(done(&far, "get").lines().count(), er_servo::parameters::TABLE.len());

    done(&far, "start-recording 7");
    assert!(refused(&far, "set kp_nm_rad=200", 3).ends_with("the drive refused: a recording runs: stop it first"));
    done(&far, "stop-recording");
}

#[test]
fn parameters_come_back_from_a_file() {
    let far = Far::start(None);
    let folder = tempfile::tempdir().unwrap();
    let there = |line: &str| printed(folder.path(), &far.line(line));
    // One of every kind: a number, a flag, and gains that need the force they were set with.
    there("set kp_nm_rad=200 er_q0=3.3 hold=true kd_nm_s_rad=0.1 --force");
    let before = there("get");
    std::fs::write(folder.path().join("before.toml"), &before).unwrap();
    there("defaults");
    assert_ne!(there("get"), before);
    let unstable = fails(folder.path(), &far.line("set --from before.toml"), 2);
    assert!(unstable.contains("margins too small"), "{unstable}");
    there("set --from before.toml --force");
    assert_eq!(there("get"), before);

    // Of a machine file its law, and only what it names.
    let machine = "schema = 1\nname = \"m\"\n[controller]\nkd_nm_s_rad = 8\n[plant]\ninertia = 1.0\n";
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    there("set --from machine.toml");
    let changed = before.replace("kd_nm_s_rad = 0.1 ", "kd_nm_s_rad = 8 ");
    assert_eq!(there("get"), changed);

    for (file, text, message) in [
        ("typo.toml", "hold = true\nkp_nm_rd = 1\n", "typo.toml:2: kp_nm_rd: unknown key"),
        ("wide.toml", "torque_limit_nm = 31\n", "torque_limit_nm: 31 N m is not allowed, 0 to 30 is"),
        ("other.toml", "period_s = 0.001\n", "period_s: built into the image, only 0.0005 is allowed"),
        ("lawless.toml", "schema = 1\n", "section [controller] is missing"),
    ] {
        std::fs::write(folder.path().join(file), text).unwrap();
        let said = fails(folder.path(), &far.line(&format!("set --from {file}")), 2);
        assert!(said.contains(message), "{file}: {said}");
    }
    assert!(fails(folder.path(), &far.line("set --from missing.toml"), 2).contains("missing.toml: cannot be read"));
    assert_eq!(there("get"), changed, "all or none");
}

#[test]
fn what_cannot_be_is_said_with_what_can() {
    let far = Far::start(None);
    let cases = [
        ("set kp_nm_rd=1", 2, "there is no parameter `kp_nm_rd`; the nearest is `kp_nm_rad`"),
        ("get torque_limt_nm", 2, "the nearest is `torque_limit_nm`"),
        ("set torque_limit_nm=31", 2, "torque_limit_nm: 31 N m is not allowed, 0 to 30 is"),
        ("set torque_limit_nm=nan", 2, "torque_limit_nm: NaN N m is not allowed"),
        ("set kp_nm_rad=200 near_rad=0.0001", 2, "near_rad: 0.0001 rad is not allowed at this gain"),
        ("reference --rad 1e9 --duration-s 1", 2, "reference: 1000000000 rad is not allowed"),
        ("run chirp --to-hz 1000", 2, "--to-hz: 1000 is not allowed, 0 to 100 is"),
        ("reference --rad 0 --for-s 1", 3, "the drive is not running: enable it first"),
        ("run step", 3, "the drive is not running: enable it first"),
        ("hold", 3, "the drive is not running: enable it first"),
        ("clear", 3, "there is no fault to clear"),
        ("load", 3, "the flash holds no parameters, or none that this image can use"),
    ];
    for (action, code, message) in cases {
        let said = refused(&far, action, code);
        assert!(said.contains(message), "{action}: {said}");
    }
    assert!(!done(&far, "get kp_nm_rad").contains("= 200"), "all or none");
    far.strings.interlock_open.store(true, Ordering::Relaxed);
    thread::sleep(Duration::from_millis(100));
    assert!(refused(&far, "enable", 3).contains("the high-voltage interlock is open: close it"));
}

#[test]
fn nobody_there_exits_with_4() {
    for (line, message) in [
        ("link --tcp 127.0.0.1:1 status", "127.0.0.1:1: "),
        ("link --tcp no.such.host.invalid:1 status", "no.such.host.invalid:1: "),
        ("link --tcp nonsense status", "nonsense: "),
        ("link --port /dev/no-such-port status", "/dev/no-such-port: "),
    ] {
        // Checked before the drive is asked.
        assert!(
            fails(Path::new(HERE), &line.replace("status", "set hold=2"), 2).contains("hold: 2 flag is not allowed")
        );
        let said = fails(Path::new(HERE), line, 4);
        assert!(said.contains(message), "{line}: {said}");
    }
    for line in ["link status", "link --tcp 127.0.0.1:1 --port x status", "link --tcp 127.0.0.1:1 fly"] {
        assert_eq!(lab(Path::new(HERE), line).status.code(), Some(2), "{line}");
    }
}

#[test]
fn another_machine_is_refused_before_a_byte_is_sent_to_it() {
    // Addresses for documentation (RFC 5737, RFC 3849), at which nobody answers: a connection would take 5 s to fail.
    for address in ["192.0.2.1:4000", "[2001:db8::1]:4000"] {
        let start = Instant::now();
        let said = fails(Path::new(HERE), &format!("link --tcp {address} status"), 2);
        assert!(said.contains("tunnel it (ssh -L 4000:127.0.0.1:4000 HOST) and connect to 127.0.0.1:4000"), "{said}");
        assert!(start.elapsed() < Duration::from_secs(4), "nothing was connected: {:?}", start.elapsed());
    }
}

#[test]
fn lost_answers_are_asked_for_again_and_nothing_is_done_twice() {
    let far = Far::start(None);
    let mut connection = Line::Tcp(far.link.to_string()).connect().unwrap();
    far.strings.lose_answers.store(3, Ordering::Relaxed);
    // A second start would be refused.
    connection.tell(Command::StartRecording { run: 1, over_link: false }).unwrap();
    let status = connection.status().unwrap();
    assert_eq!((status.counters.packets, status.counters.replayed, status.counters.refused), (2, 3, 0));
    // A hello whose answer was lost opens two sessions; the last one holds.
    far.strings.lose_answers.store(1, Ordering::Relaxed);
    let mut connection = Line::Tcp(far.link.to_string()).connect().unwrap();
    assert!(connection.status().unwrap().recording);
}

#[test]
fn a_session_that_falls_silent_is_a_fault_while_the_reference_comes_from_it() {
    let far = Far::start(None);
    let line = Line::Tcp(far.link.to_string());
    let mut connection = line.connect().unwrap();
    connection.tell(Command::Enable { autonomous: true }).unwrap();
    while connection.status().unwrap().state != 2 {}
    let target = Target::Relative(0);
    connection.tell(Command::Reference { target, pace: Pace::default(), torque_bound_nm: 0 }).unwrap();
    let start = Instant::now();
    thread::sleep(Duration::from_millis(1500));
    let status = connection.status().unwrap();
    assert_eq!(status.faults, Faults::LINK_LOST.bits(), "after {:?}", start.elapsed());
    let text = done(&far, "status");
    assert!(text.contains("state        fault\n             command link lost: reconnect, then clear\n"), "{text}");
    assert!(refused(&far, "enable", 3).contains("a fault is latched"));
    assert!(done(&far, "events").contains("command link lost: reconnect, then clear\n"));
    assert_eq!(done(&far, "clear"), "cleared\n");
}

#[test]
fn a_clear_that_costs_the_axis_its_position_says_so() {
    let far = Far::start(None);
    for log_is_full in [false, true] {
        done(&far, "home");
        done(&far, "enable --autonomous");
        far.strings.interlock_open.store(true, Ordering::Relaxed);
        thread::sleep(Duration::from_millis(100));
        far.strings.interlock_open.store(false, Ordering::Relaxed);
        far.strings.log_is_full.store(log_is_full, Ordering::Relaxed);
        thread::sleep(Duration::from_millis(100));
        let told = if log_is_full { "has lost its position: home it\n" } else { "cleared\n" };
        let said = done(&far, "clear");
        assert!(said.starts_with("cleared\n") && said.ends_with(told), "{said}");
        while !done(&far, "status").starts_with("state        ready") {}
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_reference_and_leaves_no_drive_on_a_dead_link() {
    use std::process::{Command, Stdio};
    let far = Far::start(None);
    done(&far, "home");
    done(&far, "enable --autonomous");
    let address = far.link.to_string();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("servo-lab"));
    let child = command.args(["link", "--tcp", &address, "reference", "--deg", "1"]).stdout(Stdio::piped()).spawn();
    let child = child.unwrap();
    // More than the drive's patience, which is a second here.
    thread::sleep(Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert!(String::from_utf8(output.stdout).unwrap().ends_with("stopped\n"));
    assert!(done(&far, "status").starts_with("state        ready\n"));
}

fn packet(session: u32, sequence: u32, command: Command) -> Vec<u8> {
    encode(&Packet { session, sequence, command }, &mut [0; PACKET_BYTES]).unwrap().to_vec()
}

/// Bytes that are no packets of the session: noise, packets cut short, a flood without an end, packets of another session.
fn hostile(random: &mut StdRng) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..20_000).map(|_| random.random()).collect();
    for _ in 0..200 {
        let whole = packet(random.random(), random.random(), Command::Disable);
        bytes.extend(&whole[..random.random_range(1..whole.len())]);
        bytes.push(0);
        bytes.extend(&whole);
    }
    bytes.extend(vec![0x55; 200_000]);
    bytes.push(0);
    bytes
}

#[test]
fn hostile_bytes_are_counted_and_the_drive_runs_on() {
    let far = Far::start(None);
    done(&far, "enable --autonomous");
    let mut before = Line::Tcp(far.link.to_string()).connect().unwrap();
    before.tell(Command::Hold { autonomous: true }).unwrap();
    drop(before);
    let mut stream = TcpStream::connect(far.link).unwrap();
    // The server answers packets of another session; nobody reads that here.
    let mut sink = stream.try_clone().unwrap();
    let reader = thread::spawn(move || while sink.read(&mut [0; 4096]).is_ok_and(|count| count > 0) {});
    let seed = 11;
    stream.write_all(&hostile(&mut StdRng::seed_from_u64(seed))).unwrap();
    stream.shutdown(std::net::Shutdown::Write).unwrap();
    reader.join().unwrap();
    let status = Line::Tcp(far.link.to_string()).connect().unwrap().status().unwrap();
    println!("seed {seed}: {:?}", status.counters);
    assert_eq!((status.state, status.faults), (2, 0), "running as before");
    assert!(status.counters.damaged >= 200 && status.counters.overlong >= 1 && status.counters.replayed >= 200);
}

#[test]
fn a_recorded_conversation_played_again_does_nothing() {
    let far = Far::start(None);
    let mut stream = TcpStream::connect(far.link).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let mut client = Client::new();
    let mut ask = |stream: &mut TcpStream, command| {
        let (sequence, bytes) = client.send(command);
        stream.write_all(&bytes).unwrap();
        loop {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            match client.receive(byte[0]) {
                Some(reply) if reply.sequence == sequence => return (reply.answer, bytes),
                _ => {}
            }
        }
    };
    ask(&mut stream, Command::Hello);
    let (answer, enable) = ask(&mut stream, Command::Enable { autonomous: true });
    assert_eq!(answer, Answer::Done);
    ask(&mut stream, Command::Disable);
    for _ in 0..50 {
        stream.write_all(&enable).unwrap();
    }
    let (Answer::Status(status), _) = ask(&mut stream, Command::Status) else { panic!("no status") };
    assert_eq!((status.state, status.counters.packets, status.counters.replayed), (1, 3, 50));
}

/// A far end that does `act` with the first connection.
fn stranger(act: impl FnOnce(TcpStream) + Send + 'static) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || act(listener.accept().unwrap().0));
    address
}

#[test]
fn strangers_at_the_far_end_are_told_from_a_drive() {
    let silent = stranger(|stream| {
        thread::sleep(Duration::from_secs(5));
        drop(stream);
    });
    let closing = stranger(drop);
    let flooding = stranger(|mut stream| while stream.write_all(&[0x55; 4096]).is_ok() {});
    let babbling = stranger(|mut stream| {
        let mut random = StdRng::seed_from_u64(1);
        let noise: Vec<u8> = (0..4096).map(|_| random.random_range(0..20)).collect();
        while stream.write_all(&noise).is_ok() {}
    });
    let other_version = stranger(|mut stream| {
        let mut receiver = Receiver::default();
        for byte in BufReader::new(stream.try_clone().unwrap()).bytes() {
            if let Some(Ok(Packet { sequence, .. })) = receiver.push(byte.unwrap()) {
                let (frame_schema, parameters, build) = (1, 22, [0; 8]);
                let (session, sample_to_output_ns) = (1, 0);
                let (protocol, observer) = (PROTOCOL + 1, false);
                let answer =
                    Answer::Hello { session, observer, protocol, frame_schema, parameters, build, sample_to_output_ns };
                stream.write_all(encode(&Reply { sequence, answer }, &mut [0; PACKET_BYTES]).unwrap()).unwrap();
                return;
            }
        }
    });
    let other = format!("the drive speaks version {} of the link, this tool {PROTOCOL}", PROTOCOL + 1);
    for (address, message) in [
        (silent, "no answer to 6 attempts, not a byte"),
        // Closed, or reset, as the system sees it.
        (closing, "connection"),
        (flooding, "no answer to 6 attempts"),
        (babbling, "no answer to 6 attempts"),
        (other_version, other.as_str()),
    ] {
        let start = Instant::now();
        let said = fails(Path::new(HERE), &format!("link --tcp {address} status"), 4);
        assert!(said.contains(message), "{said}");
        assert!(start.elapsed() < Duration::from_secs(10), "{message}: {:?}", start.elapsed());
    }
}

#[test]
fn a_drive_that_stops_answering_is_given_up() {
    let far = Far::start(None);
    let mut connection = Line::Tcp(far.link.to_string()).connect().unwrap();
    far.strings.lose_answers.store(u32::MAX, Ordering::Relaxed);
    match connection.status() {
        Err(LinkError::Silent { attempts: 6, bytes: 0, .. }) => {}
        other => panic!("{other:?}"),
    }
}

/// A pseudo-terminal as the serial port: what the tool writes to it reaches the drive over TCP, and back.
#[cfg(unix)]
#[test]
fn a_serial_port_is_as_good_as_tcp() {
    use serialport::{SerialPort, TTYPort};
    let far = Far::start(None);
    let (mut master, slave) = TTYPort::pair().unwrap();
    master.set_timeout(Duration::from_millis(2)).unwrap();
    let port = slave.name().unwrap();
    let mut drive = TcpStream::connect(far.link).unwrap();
    drive.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
    let bridge = thread::spawn(move || {
        let start = Instant::now();
        let mut buffer = [0; 256];
        // The tool is done long before.
        while start.elapsed() < Duration::from_secs(4) {
            if let Ok(count) = master.read(&mut buffer) {
                drive.write_all(&buffer[..count]).unwrap();
            }
            if let Ok(count) = drive.read(&mut buffer) {
                master.write_all(&buffer[..count]).unwrap();
            }
        }
    });
    let text = printed(Path::new(HERE), &format!("link --port {port} get kp_nm_rad"));
    assert!(text.starts_with("kp_nm_rad = "), "{text}");
    bridge.join().unwrap();
    drop(slave);
}
