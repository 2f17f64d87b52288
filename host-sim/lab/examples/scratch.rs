//! scratch
#![allow(clippy::unwrap_used, missing_docs)]
use diagnosis::effects::find;
use diagnosis::hypothesis::{Hypothesis, refit};
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::{first_noise, nominal};
use lab::read::{AxisKind, Machine, Recording};
use std::path::Path;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let dir = Path::new(&args[1]);
    let machine = Machine::read(&dir.join("machine.toml")).unwrap();
    let files: Vec<Recording> =
        ["a.csv", "b.csv", "c.csv"].iter().map(|f| Recording::of(&dir.join(f), &machine).unwrap()).collect();
    let names: Vec<&str> = files.iter().map(|f| f.name.as_str()).collect();
    let physics = Physics::nominal(&machine, &names);
    let problem = Problem::new(
        physics,
        files.iter().map(Recorded::new).collect(),
        2,
        machine.axis.resolution,
        machine.axis.kind == AxisKind::Linear,
    )
    .sampled(machine.axis.sample_period_s);
    let problem = if std::env::var("CMD").is_ok() {
        println!("as commands {}", problem.as_commands().is_some());
        problem.as_commands().unwrap_or(problem)
    } else {
        problem
    };
    println!(
        "measured {} early {:?} excitation torque {:.4} speed {:.3} travel {:.3}",
        !problem.motions.is_empty(),
        0,
        problem.excitation.torque_rms,
        0.0,
        problem.excitation.travel
    );
    println!("first noise {:?}", first_noise(&problem)[0]);
    let base = nominal(&problem).unwrap();
    println!("nominal ll {:.2} noise {:?}", base.log_likelihood, base.noise);
    // effect:value,value;effect:...
    let mut hypothesis = Hypothesis::default();
    for one in args[2].split(';').filter(|one| !one.is_empty()) {
        let (id, values) = one.split_once(':').unwrap();
        let values = values.split(',').map(|v| v.parse().unwrap()).collect();
        hypothesis = hypothesis.with(find(id).unwrap(), values);
    }
    if std::env::var("SCAN").is_ok() {
        for (name, h) in [("nominal", Hypothesis::default()), ("given", hypothesis.clone())] {
            for exponent in -16..4 {
                let mut noise = base.noise.clone();
                noise.iter_mut().for_each(|n| {
                    n.torque_density = 10f64.powf(f64::from(exponent) / 2.0);
                    n.sensor_sd =
                        problem.least_sensor_sd.max(1e-12) * std::env::var("SD").map_or(1.0, |s| s.parse().unwrap());
                });
                let Some(found) = refit(&problem, &h, &noise, 0) else {
                    println!("none");
                    continue;
                };
                println!(
                    "{name} density {:.1e}: {:?}",
                    noise[0].torque_density,
                    found.evaluation.blocks.iter().map(|b| b.iter().sum::<f64>().round()).collect::<Vec<_>>()
                );
            }
        }
    }
    let nominal_step = diagnosis::confidence_set::Step::new(&problem, base.clone()).unwrap();
    for rounds in [10] {
        let found = refit(&problem, &hypothesis, &base.noise, rounds).unwrap();
        if std::env::var("GAP").is_ok() && rounds == 10 {
            for k in -12..=12 {
                let mut h = found.hypothesis.clone();
                h.entries[0].values[0] *= 1.05f64.powi(k);
                println!(
                    "   gap {:.6} ll {:.1}",
                    h.entries[0].values[0],
                    refit(&problem, &h, &found.noise, 0).unwrap().log_likelihood
                );
            }
        }
        println!("rounds {rounds} ll {:.2} noise {:?}", found.log_likelihood, found.noise[0]);
        if let Some(step) = diagnosis::confidence_set::Step::new(&problem, found.clone()) {
            if std::env::var("BLOCKS").is_ok() {
                for r in 0..3 {
                    println!("   rec {r} noise {:?}", step.assessed.refitted.noise[r]);
                    let e = &step.assessed.refitted.evaluation;
                    let n = &nominal_step.assessed.refitted.evaluation;
                    println!(
                        "   blocks {:?}",
                        e.blocks[r].iter().zip(&n.blocks[r]).map(|(a, b)| (a - b).round()).collect::<Vec<_>>()
                    );
                }
            }
            println!(
                "   windows gain {:.4}  blocks total {:.1} vs {:.1}; rms {:?} {:?} judged {:?}",
                step.windows.gain_over(&nominal_step.windows, &problem),
                step.assessed.total(),
                nominal_step.assessed.total(),
                [0, 1].map(|h| (0..3)
                    .map(|r| (nominal_step.windows.rms(r..r + 1, h), nominal_step.windows.expected_rms(r..r + 1, h)))
                    .collect::<Vec<_>>()),
                [0, 1].map(|h| (0..3)
                    .map(|r| (step.windows.rms(r..r + 1, h), step.windows.expected_rms(r..r + 1, h)))
                    .collect::<Vec<_>>()),
                problem.judged()
            );
        }
        for entry in &found.hypothesis.entries {
            println!("   {} {:?}", entry.effect.id, entry.values);
        }
    }
}
