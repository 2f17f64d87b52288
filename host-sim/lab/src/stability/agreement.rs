//! The four methods against each other on seeded random loops.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rand::{Rng, SeedableRng, rngs::StdRng};
use rayon::prelude::*;

use super::case::{Fluid, Gains, Loop, NormalisedGains, Plant};
use super::{argument, curves, sampled, spectrum};

const SEED: u64 = 20_050_814;
const CASES: usize = 2000;

fn random_loop(rng: &mut StdRng) -> Loop {
    let torque_delay_s = rng.random_range(1e-3..10e-3);
    let delay_s = rng.random_range(0.0..10e-3);
    let fluid = match rng.random_range(0..3) {
        0 => Fluid::None,
        1 => Fluid::DeadTime { l_q_s: delay_s },
        _ => Fluid::Lag { t_q_s: delay_s },
    };
    let plant = Plant {
        inertia_kg_m2: rng.random_range(0.03..0.15),
        torque_delay_s,
        q0_nm_s_rad: rng.random_range(0.0..1.0),
        q1_nm_s_rad: 60.0 * rng.random::<f64>().powi(2),
        fluid,
    };
    let gains = NormalisedGains { kp: 1.6 * rng.random::<f64>().powi(3), kd: rng.random_range(0.0..1.6) };
    Loop::new(plant, gains.physical(plant.inertia_kg_m2, torque_delay_s)).unwrap()
}

#[test]
fn probe() {
    let mut rng = StdRng::seed_from_u64(SEED);
    let loops: Vec<Loop> = (0..CASES).map(|_| random_loop(&mut rng)).collect();
    let timed = |name: &str, f: &(dyn Fn(&Loop) -> i64 + Sync)| {
        let t = std::time::Instant::now();
        let r: Vec<i64> = loops.par_iter().map(f).collect();
        println!("{name} {:?}", t.elapsed());
        r
    };
    let a = timed("curves", &|l| curves::unstable_roots(l) as i64);
    let b = timed("argument", &|l| argument::unstable_roots(l).map_or(-1, |n| n as i64));
    let c = timed("spectrum", &|l| spectrum::rightmost_roots(l).map_or(-2, |r| spectrum::unstable_roots(&r) as i64));
    let d = timed("sampled", &|l| i64::from(sampled::spectral_radius(l, 0.5e-3).map_or(9.0, |r| r) >= 1.0));
    let e = timed("held", &|l| sampled::held_equivalent(l, 0.5e-3).map_or(-3, |l| curves::unstable_roots(&l) as i64));
    println!("stable {}", a.iter().filter(|&&n| n == 0).count());
    println!(
        "a!=b {} b!=c {}",
        (0..CASES).filter(|&k| a[k] != b[k]).count(),
        (0..CASES).filter(|&k| b[k] != c[k]).count()
    );
    println!("bad {} {}", b.iter().filter(|&&n| n < 0).count(), c.iter().filter(|&&n| n < 0).count());
    println!(
        "d!=a {} d!=e {}",
        (0..CASES).filter(|&k| (a[k] != 0) != (d[k] != 0)).count(),
        (0..CASES).filter(|&k| (e[k] != 0) != (d[k] != 0)).count()
    );
    for k in (0..CASES).filter(|&k| a[k] != b[k] || b[k] != c[k]).take(10) {
        println!("{} {} {} {:?} {:?}", a[k], b[k], c[k], loops[k], loops[k].normalised_gains());
    }
}
