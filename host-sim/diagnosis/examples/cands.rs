//! Candidates.
use std::path::Path;
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::{candidates, extend, nominal};
use recording::{Machine, Recording};
fn main() {
    let folder = std::env::args().nth(1).unwrap();
    let f = Path::new(&folder);
    let machine = Machine::read(&f.join("machine.toml")).unwrap();
    let rec = |n: &str| Recorded::new(&Recording::read(&f.join(n), Some(machine.axis.kind)).unwrap());
    let problem = Problem::new(Physics::nominal(&machine, &[]), vec![rec("a.csv"), rec("b.csv"), rec("c.csv")], 2, machine.axis.resolution, false);
    let at = nominal(&problem).unwrap();
    println!("{} {:?} res {}", at.log_likelihood, at.noise, machine.axis.resolution);
    let c = candidates(&problem, &at, &VOCABULARY);
    for one in c.iter().take(25) { println!("  {:22} {:8.1} {:?}", one.entry.effect.id, one.gain, one.entry.values); }
    for (one, _) in extend(&problem, &at, &c) { println!("  refit {:?} {:.1} {:?} {:?}", one.hypothesis.ids(), one.log_likelihood - at.log_likelihood, one.hypothesis.entries.last().unwrap().values, one.noise); }
}
