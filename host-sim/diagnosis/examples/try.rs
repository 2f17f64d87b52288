//! Experiment.
use std::path::Path;
use std::time::Instant;
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::pipeline::diagnose;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use recording::{Machine, Recording};

fn one(machine: &Path, fit: &[String], hold: &[String], note: &str, without: &[String]) {
    let vocabulary: Vec<_> = VOCABULARY.iter().copied().filter(|e| !without.iter().any(|w| w == e.id)).collect();
    let machine = Machine::read(machine).unwrap();
    let read = |names: &[String]| names.iter().map(|n| Recorded::new(&Recording::read(Path::new(n), Some(machine.axis.kind)).unwrap())).collect::<Vec<_>>();
    let mut all = read(fit);
    let fitted = all.len();
    all.extend(read(hold));
    let linear = machine.axis.kind == recording::AxisKind::Linear;
    let t = Instant::now();
    let problem = Problem::new(Physics::nominal(&machine, &[]), all, fitted, machine.axis.resolution, linear);
    let n0 = diagnosis::search::first_noise(&problem); let Some(c) = diagnose(&problem, &vocabulary) else { println!("{note} NONE {n0:?} {:?}", diagnosis::search::nominal(&problem).map(|n| n.log_likelihood)); return };
    let mut s = format!("{note} {:.1}s {}M {:?}", t.elapsed().as_secs_f64(), problem.work() / 1000000, c.verdict);
    for e in &c.effects {
        s += &format!(" | {} {:?}", e.effect.id, e.standing);
        for i in &e.intervals { s += &format!(" {:.5}[{:.5},{:.5}]", i.value, i.low, i.high); }
        s += &format!(" p={:.0e} gain={:.3} alike={:?}", e.p_value, e.gain, e.equivalent.iter().map(|e| e.id).collect::<Vec<_>>());
    }
    if let Some(r) = &c.remainder {
        s += &format!(" || left {:.4} Nm:", r.torque_rms);
        for p in &r.predictors { s += &format!(" {} {:.3} p={:.0e} {:.4}Nm", p.channel, p.share, p.p_value, p.torque_rms); }
    }
    s += &format!(" || rejected {:?}", c.rejected.iter().map(|(e, g)| format!("{} {g:.0}", e.id)).collect::<Vec<_>>());
    println!("{s}");
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments[0] == "cases" {
        for folder in &arguments[1..] {
            let truth = std::fs::read_to_string(Path::new(folder).join("truth.json")).unwrap();
            let ids: Vec<String> = truth.split("\"id\": \"").skip(1).map(|s| s.split('"').next().unwrap().to_owned()).collect();
            let f = |n: &str| format!("{folder}/{n}");
            one(&Path::new(folder).join("machine.toml"), &[f("a.csv"), f("b.csv")], &[f("c.csv")], &format!("{folder} TRUE {ids:?}"), if folder.contains("/removed/") { &ids } else { &[] });
        }
        return;
    }
    let split = arguments.iter().position(|a| a == "--holdout").unwrap_or(arguments.len());
    one(Path::new(&arguments[0]), &arguments[1..split], arguments.get(split + 1..).unwrap_or(&[]), &arguments[0], &[]);
}
