//! Time of one tick of the control law on the host, in each mode: `cargo bench --bench step`.
#![allow(clippy::unwrap_used, missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use er_servo::{Config, Counts, InputFlags, Inputs, Mode, Params, ResolverCode, ResolverSample, State, step};

/// Inputs that hold the law in one mode: the speed comes with them.
fn inputs(reference: i32, speed_rad_s: f32) -> Inputs {
    Inputs {
        resolver: ResolverSample { code: ResolverCode(0), fault_byte: 0, speed_rad_s },
        flags: InputFlags::INTERLOCK_CLOSED | InputFlags::LINK_ALIVE,
        reference: Counts(reference),
        ..Inputs::default()
    }
}

fn one_step(c: &mut Criterion) {
    let params = Params::new(&Config { speed_from_converter: true, ..Config::default() }).unwrap();
    let mut group = c.benchmark_group("step");
    // Errors whose torque stays below the one under which counts that stand still are a fault.
    for (name, mode, inputs) in [
        ("off", Mode::Off, inputs(2500, 1.6)),
        ("damper", Mode::Damper, inputs(1000, 0.3)),
        ("brake", Mode::Brake, inputs(1000, -0.05)),
    ] {
        let mut state = State::running_at(Counts(0));
        assert_eq!(step(&params, &mut state, &inputs).mode, mode);
        group.bench_function(name, |b| b.iter(|| step(black_box(&params), &mut state, black_box(&inputs))));
        let last = step(&params, &mut state, &inputs);
        assert_eq!((last.mode, last.hv_enable), (mode, true), "no fault on the way");
    }
    group.finish();
}

criterion_group!(benches, one_step);
criterion_main!(benches);
