//! The real drivers against the simulated chips, byte for byte.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::cell::Cell;
use std::convert::Infallible;
use std::f64::consts::TAU;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::ErrorKind;
use er_servo::drivers::ad2s1210::{self, Faults, Register, Settings};
use er_servo::drivers::dac::{self, Load, Part, When};
use er_servo::drivers::scaling::{FIELD_LIMIT_KV_MM, FieldCode, TorqueCode};
use plant::chips::ad2s1210::{COUNTS_PER_REV, Pin as ResolverPin};
use plant::chips::dac::{Part as ChipPart, Pin as DacPin};
use plant::chips::hal::{ChipPin, Socket, SpiPort};
use plant::chips::{Ad2s1210 as ResolverChip, BusFault, Chip, Dac as DacChip};
use proptest::prelude::*;

type Pin<C> = ChipPin<C>;
type Resolver = ad2s1210::Ad2s1210<
    SpiPort<ResolverChip>,
    Pin<ResolverChip>,
    Pin<ResolverChip>,
    Pin<ResolverChip>,
    Pin<ResolverChip>,
>;
type Commands = dac::Dac<SpiPort<DacChip>, Pin<DacChip>, Pin<DacChip>>;

fn resolver() -> (Socket<ResolverChip>, Resolver) {
    let socket = Socket::new(ResolverChip::new());
    let pins = ad2s1210::Pins {
        sample: socket.pin(ResolverPin::Sample),
        a0: socket.pin(ResolverPin::A0),
        a1: socket.pin(ResolverPin::A1),
        reset: socket.pin(ResolverPin::Reset),
    };
    let driver = Resolver::new(socket.spi(), pins);
    (socket, driver)
}

fn ready_resolver() -> (Socket<ResolverChip>, Resolver) {
    let (socket, mut driver) = resolver();
    driver.init(&Settings::default(), &mut socket.delay()).unwrap();
    (socket, driver)
}

fn sample(socket: &Socket<ResolverChip>, driver: &mut Resolver) -> ad2s1210::Reading {
    driver.latch().unwrap();
    socket.delay().delay_ns(ad2s1210::SAMPLE_TO_READ_NS);
    driver.read().unwrap()
}

fn commands(part: Part) -> (Socket<DacChip>, Commands) {
    let chip_part = if part == Part::Quad { ChipPart::Quad } else { ChipPart::Dual };
    let socket = Socket::new(DacChip::new(chip_part));
    let pins = dac::Pins { ldac: socket.pin(DacPin::Ldac), clear: socket.pin(DacPin::Clear) };
    let driver = Commands::new(socket.spi(), pins, part);
    (socket, driver)
}

#[test]
fn start_up_configures_twelve_bit_and_reads_back() {
    let (socket, _driver) = ready_resolver();
    socket.with(|chip| {
        assert_eq!(chip.register(0x92), Some(0x7D));
        assert_eq!(chip.register(0x91), Some(40));
        assert_eq!(chip.register(0x88), Some(58));
        assert!(!chip.is_wedged());
    });
}

#[test]
fn every_count_of_a_pole_pair_is_read() {
    let (socket, mut driver) = ready_resolver();
    for count in -5000..5000_i32 {
        // Half a count in, so that rounding of the angle cannot move it over an edge.
        let angle_rad = (f64::from(count) + 0.5) * TAU / f64::from(COUNTS_PER_REV);
        socket.with(|chip| chip.set_motion(angle_rad, 0.0));
        let reading = sample(&socket, &mut driver);
        assert_eq!(i32::from(reading.counts), count.rem_euclid(4096));
        assert_eq!(reading.faults, Faults::empty());
    }
}

#[test]
fn the_position_is_that_of_the_latch_not_of_the_read() {
    let (socket, mut driver) = ready_resolver();
    let one_count = TAU / f64::from(COUNTS_PER_REV);
    socket.with(|chip| chip.set_motion(100.5 * one_count, 0.0));
    driver.latch().unwrap();
    socket.with(|chip| chip.set_motion(200.5 * one_count, 0.0));
    socket.delay().delay_ns(ad2s1210::SAMPLE_TO_READ_NS);
    assert_eq!(driver.read().unwrap().counts, 100);
    // Read too soon, it is still the one before.
    driver.latch().unwrap();
    socket.delay().delay_ns(700);
    assert_eq!(driver.read().unwrap().counts, 100);
    assert_eq!(sample(&socket, &mut driver).counts, 200);
}

#[test]
fn every_fault_bit_is_reported_says_a_sentence_and_clears_only_when_cleared() {
    let (socket, mut driver) = ready_resolver();
    for bit in 0..8 {
        let fault = Faults::from_bits_retain(1 << bit);
        socket.with(|chip| chip.raise_faults(fault.bits()));
        assert_eq!(sample(&socket, &mut driver).faults, fault);
        assert_eq!(fault.sentences().count(), 1);
        assert!(fault.sentences().all(|sentence| sentence.len() > 20));
        socket.with(|chip| chip.raise_faults(0));
        assert_eq!(sample(&socket, &mut driver).faults, fault, "the register keeps what it saw");
        assert_eq!(driver.clear_faults(&mut socket.delay()).unwrap(), fault);
        assert_eq!(sample(&socket, &mut driver).faults, Faults::empty());
    }
}

#[test]
fn a_fault_that_stays_fails_the_start() {
    let (socket, mut driver) = resolver();
    socket.with(|chip| chip.raise_faults(Faults::LOSS_OF_SIGNAL.bits()));
    let error = driver.init(&Settings::default(), &mut socket.delay()).unwrap_err();
    assert_eq!(error, ad2s1210::Error::Faulty(Faults::LOSS_OF_SIGNAL));
    assert!(error.to_string().contains("broken wire"));
}

#[test]
fn over_speed_is_flagged_beyond_the_tracking_rate() {
    let (socket, mut driver) = ready_resolver();
    // 1000 electrical rev/s are 52.36 rad/s.
    socket.with(|chip| chip.set_motion(0.1, 52.0));
    assert_eq!(sample(&socket, &mut driver).faults, Faults::empty());
    socket.with(|chip| chip.set_motion(0.1, 53.0));
    assert_eq!(sample(&socket, &mut driver).faults, Faults::OVER_SPEED);
}

#[test]
fn spoilt_register_is_a_parity_fault_and_a_parity_error() {
    let (socket, mut driver) = ready_resolver();
    assert_eq!(driver.read_register(Register::TrackingHigh), Ok(89));
    socket.with(|chip| chip.corrupt_register(0x8D, 0x01));
    assert_eq!(sample(&socket, &mut driver).faults, Faults::CONFIG_PARITY);
    assert_eq!(
        driver.read_register(Register::TrackingHigh),
        Err(ad2s1210::Error::Parity { register: Register::TrackingHigh })
    );
    assert_eq!(sample(&socket, &mut driver).faults, Faults::CONFIG_PARITY, "back in position mode");
}

#[test]
fn dead_and_stuck_buses_fail_the_start() {
    for fault in [BusFault::AllZeros, BusFault::AllOnes, BusFault::Garbage] {
        let (socket, mut driver) = resolver();
        socket.with(|chip| chip.set_bus_fault(fault, 7));
        let error = driver.init(&Settings::default(), &mut socket.delay()).unwrap_err();
        assert!(
            matches!(error, ad2s1210::Error::ReadBack { .. } | ad2s1210::Error::Parity { .. }),
            "{fault:?} gave {error:?}"
        );
    }
}

#[test]
fn spi_errors_are_values_and_sample_goes_back() {
    let (socket, mut driver) = ready_resolver();
    socket.fail_spi(Some(ErrorKind::Overrun));
    driver.latch().unwrap();
    assert_eq!(driver.read(), Err(ad2s1210::Error::Bus(ErrorKind::Overrun)));
    socket.fail_spi(None);
    socket.with(|chip| chip.set_motion(0.01, 0.0));
    assert_eq!(i64::from(sample(&socket, &mut driver).counts), socket.with(|chip| chip.true_counts()));
}

#[test]
fn settings_out_of_range_are_refused_before_they_are_sent() {
    let (socket, mut driver) = resolver();
    for (settings, register) in [
        (Settings { loss_of_signal: 0, ..Settings::default() }, Register::LossOfSignal),
        (Settings { tracking_low: 128, ..Settings::default() }, Register::TrackingLow),
        (Settings { excitation: 7, ..Settings::default() }, Register::Excitation),
    ] {
        let error = driver.init(&settings, &mut socket.delay()).unwrap_err();
        assert!(matches!(error, ad2s1210::Error::Setting { register: at, .. } if at == register));
        assert!(!socket.with(|chip| chip.is_wedged()));
    }
}

#[test]
fn a_zero_byte_wedges_the_chip_and_a_reset_frees_it() {
    let (socket, mut driver) = ready_resolver();
    socket.with(|chip| {
        chip.set_pin(ResolverPin::A0, true);
        chip.set_pin(ResolverPin::A1, true);
        for byte in [0x92, 0x00] {
            chip.select();
            chip.transfer(byte);
            chip.deselect();
        }
        assert!(chip.is_wedged());
    });
    driver.init(&Settings::default(), &mut socket.delay()).unwrap();
}

#[test]
fn frozen_and_jumping_positions() {
    let (socket, mut driver) = ready_resolver();
    let at = |counts: f64| (counts + 0.5) * TAU / f64::from(COUNTS_PER_REV);
    socket.with(|chip| {
        chip.set_motion(at(10.0), 0.0);
        chip.freeze(true);
        chip.set_motion(at(20.0), 0.0);
    });
    assert_eq!(sample(&socket, &mut driver).counts, 10);
    socket.with(|chip| {
        chip.freeze(false);
        chip.jump(-100);
    });
    assert_eq!(sample(&socket, &mut driver).counts, 4096 - 80);
}

#[test]
fn both_parts_start_at_zero_and_follow_commands() {
    for part in [Part::Quad, Part::Dual] {
        let (socket, mut driver) = commands(part);
        driver.init(&mut socket.delay()).unwrap();
        assert_eq!(socket.with(|chip| chip.volts()), [0.0, 0.0]);
        driver.write(TorqueCode::from_torque_nm(-12.5), FieldCode::from_field_kv_mm(3.0), When::Now).unwrap();
        socket.with(|chip| {
            assert!((chip.torque_nm() + 12.5).abs() < 0.5 * 30.0 / 32_768.0);
            assert!((chip.field_kv_mm() - 3.0).abs() < 0.5 * 4.0 / 65_536.0);
        });
        driver.clear().unwrap();
        assert_eq!(socket.with(|chip| chip.volts()), [0.0, 0.0]);
    }
}

#[test]
fn output_faults_are_told_apart() {
    for part in [Part::Quad, Part::Dual] {
        let (socket, mut driver) = commands(part);
        driver.init(&mut socket.delay()).unwrap();
        assert!(driver.status().unwrap().is_ok());
        socket.with(|chip| chip.overload([true, false]));
        assert_eq!(driver.status().unwrap(), dac::Status { over_current_a: true, ..dac::Status::default() });
        socket.with(|chip| chip.overload([false, true]));
        assert_eq!(driver.status().unwrap(), dac::Status { over_current_b: true, ..dac::Status::default() });
        socket.with(|chip| {
            chip.overload([false, false]);
            chip.overheat(true);
        });
        assert_eq!(driver.status().unwrap(), dac::Status { thermal_shutdown: true, ..dac::Status::default() });
    }
}

#[test]
fn dead_dac_buses_are_seen() {
    for fault in [BusFault::AllZeros, BusFault::AllOnes, BusFault::Garbage] {
        let (socket, mut driver) = commands(Part::Quad);
        socket.with(|chip| chip.set_bus_fault(fault, 3));
        let error = driver.init(&mut socket.delay()).unwrap_err();
        assert!(matches!(error, dac::Error::ReadBack { .. }), "{fault:?} gave {error:?}");
        assert_eq!(socket.with(|chip| chip.volts()), [0.0, 0.0]);
    }
}

#[test]
fn a_failed_write_clears_both_outputs() {
    let (socket, mut driver) = commands(Part::Quad);
    driver.init(&mut socket.delay()).unwrap();
    let (torque, field) = (TorqueCode::from_torque_nm(20.0), FieldCode::from_field_kv_mm(2.0));
    driver.write(torque, field, When::Now).unwrap();
    socket.fail_spi(Some(ErrorKind::ModeFault));
    assert_eq!(driver.write(torque, field, When::OnTime), Err(dac::Error::Bus(ErrorKind::ModeFault)));
    assert_eq!(socket.with(|chip| chip.volts()), [0.0, 0.0]);
}

/// LDAC as a timer drives it: its instant comes when the test says so.
struct Timed {
    pin: Pin<DacChip>,
    high: Rc<Cell<bool>>,
    past: Rc<Cell<bool>>,
}

impl Load for Timed {
    type Error = Infallible;

    fn loaded(&mut self) -> Result<bool, Infallible> {
        Ok(!self.high.get())
    }

    fn hold(&mut self) -> Result<(), Infallible> {
        self.high.set(true);
        self.pin.set_high()
    }

    fn load(&mut self) -> Result<(), Infallible> {
        self.high.set(false);
        self.pin.set_low()
    }

    fn load_on_time(&mut self) -> Result<bool, Infallible> {
        if self.past.get() { self.load().map(|()| false) } else { Ok(true) }
    }
}

#[test]
fn a_pair_waits_for_its_instant_and_outputs_that_did_not_take_it_are_cleared() {
    let socket = Socket::new(DacChip::new(ChipPart::Quad));
    let (high, past) = (Rc::new(Cell::new(false)), Rc::new(Cell::new(false)));
    let ldac = Timed { pin: socket.pin(DacPin::Ldac), high: high.clone(), past: past.clone() };
    let pins = dac::Pins { ldac, clear: socket.pin(DacPin::Clear) };
    let mut driver = dac::Dac::new(socket.spi(), pins, Part::Quad);
    driver.init(&mut socket.delay()).unwrap();
    let pair = |torque_nm, field| (TorqueCode::from_torque_nm(torque_nm), FieldCode::from_field_kv_mm(field));
    let outputs = || socket.with(|chip| chip.codes());
    let fall = || {
        high.set(false);
        socket.with(|chip| chip.set_pin(DacPin::Ldac, false));
    };

    let (torque, field) = pair(10.0, 1.0);
    assert_eq!(driver.write_and_ask(torque, field, When::OnTime), Ok(true));
    assert_eq!(outputs(), [0, 0], "written, and waiting");
    fall();
    assert_eq!(outputs(), [torque.bits(), field.bits()]);
    // Too late: whole, at once, and said. What was asked for is answered meanwhile.
    past.set(true);
    let (torque, field) = pair(-5.0, 2.0);
    assert_eq!(driver.write(torque, field, When::OnTime), Ok(false));
    assert_eq!(outputs(), [torque.bits(), field.bits()]);
    past.set(false);
    // A zero waits for nothing.
    assert_eq!(driver.write(TorqueCode::ZERO, FieldCode::ZERO, When::Now), Ok(true));
    assert_eq!(outputs(), [0, 0]);
    // LDAC that does not fall leaves the outputs as they were: found with the next pair, cleared by the other pin.
    driver.write(torque, field, When::Now).unwrap();
    assert_eq!(driver.write(TorqueCode::ZERO, FieldCode::ZERO, When::OnTime), Ok(true));
    assert_eq!(outputs(), [torque.bits(), field.bits()]);
    assert_eq!(driver.write(TorqueCode::ZERO, FieldCode::ZERO, When::OnTime), Err(dac::Error::NotLoaded));
    assert_eq!(outputs(), [0, 0]);
    driver.init(&mut socket.delay()).unwrap();
}

#[test]
fn codes_saturate_and_nan_is_zero() {
    assert_eq!(TorqueCode::from_torque_nm(f32::NAN), TorqueCode::ZERO);
    assert_eq!(FieldCode::from_field_kv_mm(f32::NAN), FieldCode::ZERO);
    assert_eq!(TorqueCode::from_torque_nm(f32::INFINITY).bits(), 0x7FFF);
    assert_eq!(TorqueCode::from_torque_nm(f32::NEG_INFINITY).bits(), 0x8001);
    assert_eq!(FieldCode::from_field_kv_mm(f32::INFINITY).field_kv_mm(), FIELD_LIMIT_KV_MM);
    assert_eq!(FieldCode::from_field_kv_mm(f32::NEG_INFINITY), FieldCode::ZERO);
}

proptest! {
    #[test]
    fn torque_survives_the_round_trip(torque_nm in -29.999_f32..29.999) {
        let back_nm = TorqueCode::from_torque_nm(torque_nm).torque_nm();
        prop_assert!((back_nm - torque_nm).abs() <= 0.501 * 30.0 / 32_768.0);
        prop_assert_eq!(TorqueCode::from_torque_nm(-torque_nm).torque_nm(), -back_nm);
    }

    #[test]
    fn field_survives_the_round_trip(field_kv_mm in 0.0_f32..3.5) {
        let back_kv_mm = FieldCode::from_field_kv_mm(field_kv_mm).field_kv_mm();
        prop_assert!((back_kv_mm - field_kv_mm).abs() <= 0.501 * 4.0 / 65_536.0);
    }

    #[test]
    fn no_float_whatever_leaves_the_limits(bits in any::<u32>()) {
        let value = f32::from_bits(bits);
        prop_assert!(TorqueCode::from_torque_nm(value).torque_nm().abs() <= 30.0);
        prop_assert!((0.0..=FIELD_LIMIT_KV_MM).contains(&FieldCode::from_field_kv_mm(value).field_kv_mm()));
    }

    #[test]
    fn any_bytes_in_any_order_leave_the_chips_standing(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let resolver = Socket::new(ResolverChip::new());
        let dac = Socket::new(DacChip::new(ChipPart::Dual));
        for byte in bytes {
            resolver.with(|chip| {
                chip.set_pin(ResolverPin::A0, byte & 1 == 0);
                chip.set_pin(ResolverPin::A1, byte & 2 == 0);
                chip.select();
                chip.transfer(byte);
                chip.deselect();
                chip.advance(1e-3);
            });
            dac.with(|chip| {
                if byte & 3 == 0 { chip.deselect(); chip.select(); }
                chip.transfer(byte);
                chip.set_pin(DacPin::Ldac, byte & 4 == 0);
            });
            prop_assert!(dac.with(|chip| chip.volts()).iter().all(|volts| volts.abs() <= 10.8));
        }
    }
}
