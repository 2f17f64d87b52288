//! Experiment.
use std::path::Path;
use std::time::Instant;
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::{candidates, extend, nominal};
use recording::{Machine, Recording};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let machine = Machine::read(Path::new(&arguments[0])).unwrap();
    let mut fit = Vec::new();
    let mut hold = Vec::new();
    let mut held = false;
    for name in &arguments[1..] {
        if name == "--holdout" { held = true; continue; }
        let r = Recording::read(Path::new(name), Some(machine.axis.kind)).unwrap();
        if held { hold.push(Recorded::new(&r)); held = false; } else { fit.push(Recorded::new(&r)); }
    }
    let fitted = fit.len();
    fit.extend(hold);
    let physics = Physics::nominal(&machine);
    let linear = machine.axis.kind == recording::AxisKind::Linear;
    let problem = Problem::new(physics, fit, fitted, machine.axis.resolution, linear);
    let t = Instant::now();
    let mut at = nominal(&problem).unwrap();
    println!("{:.2}s nominal ll {:.1} noise {:?}", t.elapsed().as_secs_f64(), at.log_likelihood, at.noise);
    for _ in 0..5 {
        let c = candidates(&problem, &at, &VOCABULARY);
        println!("{:.2}s scored {}", t.elapsed().as_secs_f64(), c.len());
        let mut seen = Vec::new();
        for one in &c {
            if seen.contains(&one.entry.effect.id) || seen.len() > 7 { continue; }
            seen.push(one.entry.effect.id);
            println!("    {:22} {:10.1} {:?}", one.entry.effect.id, one.gain, one.entry.values);
        }
        let found = extend(&problem, &at, &c, 5);
        for one in &found {
            let last = one.hypothesis.entries.last().unwrap();
            println!("  {:.2}s refit {:22} +{:.1} {:?}", t.elapsed().as_secs_f64(), last.effect.id, one.log_likelihood - at.log_likelihood, last.values);
        }
        let Some(best) = found.into_iter().next() else { break };
        if best.log_likelihood - at.log_likelihood < 20.0 { break; }
        at = best;
        println!("=> {:?} noise {:?}", at.hypothesis.entries.iter().map(|e| (e.effect.id, e.values.clone())).collect::<Vec<_>>(), at.noise);
    }
    println!("{:.2}s end", t.elapsed().as_secs_f64());
}
