//! Time to read and to write ten minutes at 2 kHz: 1.2 million rows of seven columns.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use recording::{AxisKind, Mode, Recording};

const ROWS: usize = 1_200_000;

fn ten_minutes() -> Recording {
    let column = |of: fn(f64) -> f64| (0..ROWS).map(|k| of(k as f64 * 5e-4)).collect::<Vec<f64>>();
    Recording {
        name: "ten_minutes.csv".to_owned(),
        axis: AxisKind::Rotary,
        t_s: column(|t_s| t_s),
        position: column(f64::sin),
        effort_cmd: column(|t_s| 7.3 * t_s.cos()),
        reference: Some(column(|t_s| (0.3 * t_s).sin())),
        field_cmd_kv_mm: Some(column(|t_s| 3.0 * t_s.sin().abs())),
        mode: Some(vec![Mode::Damper; ROWS]),
        velocity: None,
        effort_meas: None,
        field_meas_kv_mm: None,
        temperature_c: None,
        seq: Some((0..ROWS as u64).collect()),
        fault: None,
        counts: None,
        gaps: Vec::new(),
        mended: Vec::new(),
        extra: Vec::new(),
    }
}

fn reading(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let recording = ten_minutes();
    let mut group = criterion.benchmark_group("ten minutes at 2 kHz");
    group.sample_size(10);
    for extension in ["csv", "parquet"] {
        let file = folder.path().join(format!("ten_minutes.{extension}"));
        group.bench_function(format!("write {extension}"), |bencher| bencher.iter(|| recording.write(&file).unwrap()));
        group.bench_function(format!("read {extension}"), |bencher| {
            bencher.iter(|| Recording::read(&file, Some(AxisKind::Rotary)).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, reading);
criterion_main!(benches);
