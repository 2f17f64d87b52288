//! What is written reads back the same, to the bit.

use std::fs;
use std::path::PathBuf;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use recording::Error;
use recording::vocabulary::{Allowed, EFFECTS, LARGEST, Occurs, SMALLEST};
use recording::{Axis, AxisKind, EffectEntry, ErElectrode, ErFluid, ErNominal, Machine, Mode, PlantNominal, Recording};

fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![any::<f64>().prop_filter("finite", |value| value.is_finite()), -10.0..10.0, Just(-0.0), Just(5e-324)]
}

fn axis_kind() -> impl Strategy<Value = AxisKind> {
    prop_oneof![Just(AxisKind::Rotary), Just(AxisKind::Linear)]
}

prop_compose! {
    fn recording()(rows in 1..20_usize, axis in axis_kind())(
        axis in Just(axis),
        steps in vec(1e-9..10.0, rows),
        reals in vec(vec(finite(), rows), 8),
        modes in vec(prop_oneof![Just(Mode::Off), Just(Mode::Damper), Just(Mode::Brake)], rows),
        seqs in vec(1..u64::MAX / 32, rows),
        faults in vec(any::<u32>(), rows),
        counts in vec(any::<i64>(), rows),
        texts in vec("[a-z,\"\n é]{0,5}[a-z]", rows),
        there in vec(any::<bool>(), 10),
    ) -> Recording {
        let rising = |sum: &mut f64, step: f64| { *sum += step; Some(*sum) };
        let t_s: Vec<f64> = steps.into_iter().scan(-5.0, |sum, step| rising(sum, step)).collect();
        let seq = seqs.into_iter().scan(0, |sum, step| { *sum += step; Some(*sum) }).collect();
        let mut reals = reals.into_iter();
        let mut real = || reals.next().unwrap();
        Recording {
            name: "r".to_owned(), axis, t_s, position: real(), effort_cmd: real(),
            reference: there[0].then(&mut real), field_cmd_kv_mm: there[1].then(&mut real),
            velocity: there[2].then(&mut real), effort_meas: there[3].then(&mut real),
            field_meas_kv_mm: there[4].then(&mut real), temperature_c: there[5].then(&mut real),
            mode: there[6].then_some(modes), seq: there[7].then_some(seq), fault: there[8].then_some(faults),
            counts: there[9].then_some(counts), gaps: Vec::new(), mended: Vec::new(), extra: vec![("note".to_owned(), texts)],
        }
    }
}

fn written_and_read(recording: &Recording, extension: &str) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("r.{extension}"));
    recording.write(&file).unwrap();
    let back = Recording::read(&file, Some(recording.axis)).unwrap();
    Recording { name: recording.name.clone(), gaps: recording.gaps.clone(), ..back }
}

/// Bits of the numbers: `-0.0 == 0.0`, but their bits differ.
fn bits(recording: &Recording) -> String {
    format!("{recording:?}")
}

/// A case that drawing found once: sequence numbers that end beyond 2^53, steps of a nanosecond, a negative zero, and texts of quotes and
/// line ends beside them.
#[test]
fn a_case_that_was_lost_once_reads_back() {
    let texts = ["w", "fé\"\ne", " s", " ,o", "\"\"ééée", " é,n", "\n p\nk", "\n\"m"];
    let rows = texts.len();
    let seq = vec![
        1 << 11,
        2 << 11,
        3 << 11,
        7597 << 11,
        315_646_516_577_181_339,
        519_055_976_586_757_193,
        976_543_164_816_128_397,
        u64::MAX / 2,
    ];
    let recording = Recording {
        name: "r".to_owned(),
        t_s: (1..=rows).map(|row| -5.0 + 1e-9 * row as f64).collect(),
        position: vec![0.0; rows],
        effort_cmd: vec![0.0; rows],
        mode: Some(vec![Mode::Off; rows]),
        velocity: Some(vec![-0.0; rows]),
        temperature_c: Some((0..rows).map(|row| if row == 2 { -0.0 } else { 0.0 }).collect()),
        seq: Some(seq),
        fault: Some((0..rows as u32).map(|row| u32::MAX - row).collect()),
        extra: vec![("note".to_owned(), texts.map(str::to_owned).to_vec())],
        ..Recording::empty(AxisKind::Linear)
    };
    for extension in ["csv", "parquet"] {
        assert_eq!(bits(&written_and_read(&recording, extension)), bits(&recording), "{extension}");
    }
    let seq = recording.seq.as_ref().map(|seq| seq.iter().map(|value| value >> 11).collect());
    let in_json = Recording { seq, ..recording };
    assert_eq!(bits(&written_and_read(&in_json, "mcap")), bits(&in_json));
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 200,
        rng_seed: RngSeed::Fixed(20_250_611),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]
    #[test]
    fn a_recording_reads_back_to_the_bit(recording in recording()) {
        for extension in ["csv", "parquet"] {
            let back = written_and_read(&recording, extension);
            prop_assert_eq!(&back, &recording, "{}", extension);
            prop_assert_eq!(bits(&back), bits(&recording), "{}", extension);
        }
    }

    #[test]
    fn a_recording_reads_back_from_mcap(recording in recording()) {
        // JSON has no whole numbers beyond 2^53.
        let recording = Recording {
            seq: recording.seq.map(|seq| seq.into_iter().map(|value| value >> 11).collect()),
            counts: recording.counts.map(|counts| counts.into_iter().map(|value| value >> 11).collect()),
            ..recording
        };
        let back = written_and_read(&recording, "mcap");
        prop_assert_eq!(bits(&back), bits(&recording));
    }

    #[test]
    fn a_machine_reads_back_to_the_bit(machine in machine()) {
        let text = machine.to_toml().unwrap();
        let back = Machine::from_bytes(&machine.file, text.as_bytes());
        prop_assert_eq!(back.unwrap(), machine, "{}", text);
    }
}

/// Any number that a machine file may hold.
fn of_a_machine() -> impl Strategy<Value = f64> {
    prop_oneof![-LARGEST..LARGEST, -10.0..10.0, Just(-0.0), Just(5e-324)]
}

fn allowed(allowed: Allowed) -> BoxedStrategy<f64> {
    match allowed {
        Allowed::Finite => of_a_machine().boxed(),
        Allowed::AtLeastZero => of_a_machine().prop_map(f64::abs).boxed(),
        Allowed::AboveZero => (SMALLEST..LARGEST).boxed(),
        Allowed::Between(low, high) => (low..=high).boxed(),
        Allowed::AboveZeroUpTo(high) => (1e-9..=high).boxed(),
    }
}

/// One entry of every effect of the vocabulary.
fn effects(axis: AxisKind) -> impl Strategy<Value = Vec<EffectEntry>> {
    let entries: Vec<_> = EFFECTS
        .iter()
        .map(|effect| {
            let values: Vec<_> = effect.parameters.iter().map(|parameter| allowed(parameter.allowed)).collect();
            (values, any::<bool>()).prop_map(move |(values, named)| EffectEntry {
                id: effect.id.to_owned(),
                recording: (named || effect.occurs == Occurs::InNamedRecording).then(|| "a \"b\".csv".to_owned()),
                parameters: effect.parameters.iter().map(|p| p.id(axis).to_owned()).zip(values).collect(),
            })
        })
        .collect();
    entries
}

fn fluid() -> impl Strategy<Value = ErFluid> {
    let flow = (0.0..9.0, 0.0..9.0, 0.1..=1.0, 0.0..=2.0, 0.0..=2.0);
    let temperature = (-200.0..=200.0, -1.0..=1.0, -1.0..=1.0);
    let electrode = proptest::option::of((1e-12..1e-3, 1e-9..1.0, 1e-6..0.1));
    (flow, temperature, electrode).prop_map(|(flow, temperature, electrode)| ErFluid {
        consistency: flow.0,
        consistency_per_kv_mm: flow.1,
        flow_exponent: flow.2,
        rise_exponent: flow.3,
        fall_exponent: flow.4,
        above_reference_k: temperature.0,
        yield_per_k: temperature.1,
        viscosity_per_k: temperature.2,
        electrode: electrode.map(|(capacitance_f, current_a, gap_m)| ErElectrode { capacitance_f, current_a, gap_m }),
    })
}

fn machine() -> impl Strategy<Value = Machine> {
    let plant = (
        (1e-9..1e9, allowed(Allowed::AtLeastZero), allowed(Allowed::AtLeastZero), 1e-3..1e3),
        (of_a_machine(), proptest::option::of(1e-9..1e9), 0.0..=1.0, 0.0..=1.0),
        proptest::option::of((0.0..9.0, 0.0..9.0, 0.0..=1.0, 0.0..=1.0, proptest::option::of(fluid()))),
    );
    let plant =
        plant.prop_map(|((inertia, coulomb, viscous, gain), (offset, limit, to_output, delay), er)| PlantNominal {
            inertia,
            coulomb,
            viscous,
            torque_gain: gain,
            torque_offset: offset,
            torque_limit: limit,
            sample_to_output_s: to_output,
            torque_delay_s: delay,
            er: er.map(|(a, b, dead_time_s, lag_s, fluid)| ErNominal { a, b, dead_time_s, lag_s, fluid }),
        });
    let axis = (axis_kind(), 1e-9..=1.0, 0.0..1.0).prop_map(|(kind, sample_period_s, resolution)| Axis {
        kind,
        sample_period_s,
        resolution,
    });
    (axis, plant, "[a-z\\\\\"é]{1,9}").prop_flat_map(|(axis, plant, name)| {
        effects(axis.kind).prop_map(move |effects| Machine {
            file: PathBuf::from("m.toml"),
            name: name.clone(),
            axis: axis.clone(),
            plant: plant.clone(),
            controller: None,
            columns: Default::default(),
            effects,
        })
    })
}

fn three_rows() -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    fs::write(&file, "t_s,position_rad,torque_cmd_nm\n0,0,0\n1,0.1,0\n2,0.3,0\n").unwrap();
    Recording::read(&file, None).unwrap()
}

#[test]
fn a_failed_output_leaves_the_file_before_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out.txt");
    fs::write(&file, "before").unwrap();
    let failing = recording::output::write(&file, |to| {
        std::io::Write::write_all(to, b"half of")?;
        Err(std::io::Error::other("the disk is full"))
    });
    let error = failing.unwrap_err();
    assert_eq!(error.to_string(), format!("{}: cannot write: the disk is full", file.display()));
    assert_eq!(error.exit_code(), 2);
    assert_eq!(fs::read_to_string(&file).unwrap(), "before");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    recording::output::write_text(&file, "after").unwrap();
    assert_eq!(fs::read_to_string(&file).unwrap(), "after");
}

#[test]
fn outputs_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let recording = three_rows();
    for name in ["out.txt", "out"] {
        let refused = recording.write(&folder.path().join(name));
        assert!(matches!(refused, Err(Error::Output { .. })), "{name}: {refused:?}");
    }
    fs::create_dir(folder.path().join("folder.csv")).unwrap();
    let error = recording.write(&folder.path().join("folder.csv")).unwrap_err();
    assert!(error.to_string().ends_with("folder.csv: cannot write: it is a folder"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn written_recordings_carry_the_mark_and_others_do_not() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out.csv", "new/out.parquet"] {
        let file = folder.path().join(name);
        three_rows().write(&file).unwrap();
        assert!(recording::output::mark::is_marked(&file).unwrap(), "{name}");
        assert_eq!(Recording::read(&file, None).unwrap().position, [0.0, 0.1, 0.3]);
    }
    let other = folder.path().join("other.csv");
    fs::write(&other, "t_s,position_rad,torque_cmd_nm\n0,0,0\n").unwrap();
    assert!(!recording::output::mark::is_marked(&other).unwrap());
}

#[cfg(unix)]
#[test]
fn a_link_stays_and_a_device_is_written_into() {
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file.csv"), folder.path().join("link.csv"));
    fs::write(&file, "before").unwrap();
    std::os::unix::fs::symlink(&file, &link).unwrap();
    three_rows().write(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(fs::read_to_string(&file).unwrap().starts_with("t_s,"));
    recording::output::write_text(std::path::Path::new("/dev/null"), "gone").unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}
