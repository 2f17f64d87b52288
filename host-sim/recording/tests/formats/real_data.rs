//! The real machines and recordings, where they are at hand.

use std::fs;
use std::path::{Path, PathBuf};

use recording::{AxisKind, Machine, Recording};

/// The folder of real recordings beside the repository; none, with the reason printed, where it is not there.
fn data() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    // A worktree may lie one folder deeper than the main one.
    let found =
        ["../shared/data", "../../shared/data"].map(|folder| root.join(folder)).into_iter().find(|f| f.is_dir());
    if found.is_none() {
        // On the machine that lands changes nothing may pass unseen.
        assert!(std::env::var_os("CI").is_none(), "the folder of real recordings, ../shared/data, is not there");
        println!("skipped: the folder of real recordings, ../shared/data, is not there");
    }
    found
}

fn recordings(data: &Path, machine: &str) -> Vec<Recording> {
    let machine = Machine::read(&data.join(machine).join("machine.toml")).unwrap();
    let folder = machine.file.parent().unwrap();
    let mut files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| {
        let name = file.file_name().unwrap().to_string_lossy();
        // `map_*.csv` is a table of holding torque, not a recording.
        name.ends_with(".csv") && !name.starts_with("map_")
    });
    files.sort();
    files.iter().map(|file| Recording::read(file, Some(machine.axis.kind)).unwrap()).collect()
}

#[test]
fn the_linear_axis_reads_without_gaps() {
    let Some(data) = data() else { return };
    let recordings = recordings(&data, "emps");
    assert_eq!(recordings.len(), 2);
    for recording in recordings {
        assert_eq!((recording.axis, recording.rows()), (AxisKind::Linear, 24_841));
        assert_eq!(recording.gaps, Vec::<usize>::new(), "{}", recording.name);
        assert!(recording.reference.is_some() && recording.extra.is_empty());
    }
}

#[test]
fn jittered_sampling_reads_with_few_gaps_and_only_at_long_steps() {
    let Some(data) = data() else { return };
    let recordings = recordings(&data, "odrive_cogging");
    assert_eq!(recordings.len(), 6);
    for recording in recordings {
        assert_eq!(recording.axis, AxisKind::Rotary);
        let steps: Vec<f64> = recording.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        println!("{}: {} gaps in {} steps", recording.name, recording.gaps.len(), steps.len());
        assert!(recording.gaps.len() * 500 <= steps.len(), "{}: {}", recording.name, recording.gaps.len());
        for gap in recording.gaps {
            // The rate itself changes from 2.3 to 1.5 ms and back, so what is long shows beside its neighbours only.
            let mut around = steps[gap.saturating_sub(15)..(gap + 16).min(steps.len())].to_vec();
            around.sort_by(f64::total_cmp);
            assert!(steps[gap] > 1.5 * around[around.len() / 2 - 1], "{}: {}", recording.name, steps[gap]);
        }
    }
}

#[test]
fn a_table_that_is_no_recording_is_refused_by_its_columns() {
    let Some(data) = data() else { return };
    let error = Recording::read(&data.join("odrive_cogging/map_a_4.csv"), None).unwrap_err();
    assert!(
        error.to_string().ends_with(
            "map_a_4.csv:1: t_s, torque_cmd_nm: required columns are missing; the file has `position_rad`, `holding_torque_nm`"
        ),
        "{error}"
    );
}
