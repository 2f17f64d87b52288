//! A board whose crystal does not start: the unmodified image must not wait for it for ever.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{events, firmware, log, ms, world};

/// The image waits for the crystal by then, ms: what comes before takes it microseconds.
const WAITS_MS: f64 = 5.0;
/// What the image gives the watchdog for the start, ms.
const WATCHDOG_MS: f64 = 2000.0;
/// The chips are up this long after a boot.
const UP_MS: f64 = 55.0;

#[test]
fn the_watchdog_runs_before_the_crystal_is_waited_for() {
    let firmware = firmware();
    let ended_ms = WATCHDOG_MS + WAITS_MS;
    let mut world = world(&firmware, ended_ms + UP_MS);
    world.hand.kill_crystal(true);
    // Two seconds of looking at one bit are half a minute of emulation, and are left out: the watchdog counts on.
    world.at(ms(WAITS_MS), |_, _, host, _| host.hold(true));
    world.at(ms(ended_ms), |world, _, host, _| {
        world.hand.kill_crystal(false);
        host.hold(false);
    });
    let run = firmware.run(world).unwrap();
    let resets = run.session.resets();
    assert_eq!(resets.len(), 1, "nothing ends the wait for a crystal that does not start: {resets:?}");
    assert!(resets[0].at >= ms(WATCHDOG_MS) && resets[0].at < ms(ended_ms), "{resets:?}");
    assert!(run.driver.commands.iter().all(|command| !command.hv_enable), "the outputs stay off");
    // With a crystal again it comes up, and says what happened.
    let events = events(&log(&run));
    assert!(events.iter().any(|event| event.contains("watchdog")), "{events:?}");
}
