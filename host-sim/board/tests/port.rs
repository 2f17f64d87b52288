//! The board behind a TCP port, with a client or an emulator that a busy machine does not let run.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::Duration;

use board::tcp::{Pace, Port};
use common::{Run, events, firmware, log, ms, world};
use er_servo::Faults;
use er_servo::link::{Command, Status};
use wire::connection::{Connection, Persistence};

/// The chips are up and the drive is ready after this, ms.
const READY_MS: f64 = 100.0;
/// Longer than everything takes, ms.
const END_MS: f64 = 60_000.0;
/// Longer than the drive listens to silence (0.25 s), and than a client asks by default (0.6 s).
const ABSENT: Duration = Duration::from_millis(900);
/// States, as [`Status::state`] has them.
const RUNNING: u8 = 2;
const FAULT: u8 = 3;

/// A board behind a port whose time keeps step with its client.
struct Drive {
    address: std::net::SocketAddr,
    ended: Arc<AtomicBool>,
    run: JoinHandle<Run>,
}

impl Drive {
    /// Ready; the emulator stands still for [`ABSENT`] at some instants of the board, ms.
    fn start(absent_at_ms: &[f64]) -> Self {
        let firmware = firmware();
        let port = Port::open(0, Pace::Client).unwrap();
        let address = port.address().unwrap();
        let mut world = world(&firmware, END_MS);
        let (ended, ready) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        (world.port, world.ended) = (Some(port), ended.clone());
        let is_ready = ready.clone();
        world.at(ms(READY_MS), move |_, _, _, _| is_ready.store(true, Ordering::Relaxed));
        for at_ms in absent_at_ms {
            world.at(ms(*at_ms), |_, _, _, _| sleep(ABSENT));
        }
        let run = spawn(move || firmware.run(world).unwrap());
        while !ready.load(Ordering::Relaxed) {
            assert!(!run.is_finished(), "the board ended");
            sleep(Duration::from_millis(5));
        }
        Self { address, ended, run }
    }

    fn connect(&self) -> Connection<TcpStream> {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
        stream.set_nodelay(true).unwrap();
        Connection::open(stream, Persistence { patience: Duration::from_secs(10), attempts: 6 }).unwrap()
    }

    fn end(self) -> Run {
        self.ended.store(true, Ordering::Relaxed);
        self.run.join().unwrap()
    }
}

/// Enabled, as long as its client lives.
fn running(connection: &mut Connection<TcpStream>) -> Status {
    connection.tell(Command::Enable { autonomous: false }).unwrap();
    loop {
        let status = connection.status().unwrap();
        assert_ne!(status.state, FAULT, "{status:?}");
        if status.state == RUNNING {
            return status;
        }
    }
}

#[test]
fn a_client_that_is_not_let_run_is_not_taken_for_one_that_has_gone() {
    let drive = Drive::start(&[]);
    let mut connection = drive.connect();
    let before = running(&mut connection);
    sleep(ABSENT);
    let after = connection.status().unwrap();
    println!("{} ticks in {} ms", after.tick - before.tick, ABSENT.as_millis());
    assert_eq!((after.state, after.faults), (RUNNING, 0), "{after:?}");
    // A tenth of a second, and what the two answers took.
    assert!(after.tick - before.tick < 400, "{before:?} {after:?}");
    drive.end();
}

#[test]
fn a_client_that_has_gone_is_missed_within_a_quarter_of_a_second() {
    let drive = Drive::start(&[]);
    let mut first = drive.connect();
    running(&mut first);
    drop(first);
    sleep(ABSENT);
    let mut second = drive.connect();
    let faults = loop {
        let status = second.status().unwrap();
        // The emulator may be slower than the clock.
        if status.state != RUNNING {
            break status.faults;
        }
    };
    assert_eq!(faults, Faults::LINK_LOST.bits());
    let run = drive.end();
    assert!(events(&log(&run)).iter().any(|event| event.contains("command link lost")));
}

#[test]
fn an_emulator_that_is_not_let_run_is_waited_for_and_loses_no_tick() {
    let drive = Drive::start(&[300.0, 500.0, 700.0]);
    let mut connection = drive.connect();
    let begin = running(&mut connection).tick;
    let before = connection.status().unwrap();
    // To 0.8 s of the board.
    while connection.status().unwrap().tick - begin < 1_500 {}
    let after = connection.status().unwrap();
    assert_eq!((after.state, after.faults), (RUNNING, 0), "{after:?}");
    assert_eq!(after.lost, before.lost);
    drive.end();
}
