//! First step on cases: rank of the true effect.
use std::path::Path;
use std::time::Instant;
use diagnosis::effects::VOCABULARY;
use diagnosis::physics::Physics;
use diagnosis::problem::Problem;
use diagnosis::recorded::Recorded;
use diagnosis::search::{candidates, extend, nominal};
use recording::{Machine, Recording};

fn main() {
    for folder in std::env::args().skip(1) {
        let f = Path::new(&folder);
        let truth = std::fs::read_to_string(f.join("truth.json")).unwrap();
        let id: Vec<String> = truth.split("\"id\": \"").skip(1).map(|s| s.split('"').next().unwrap().to_owned()).collect();
        let machine = Machine::read(&f.join("machine.toml")).unwrap();
        let rec = |n: &str| Recorded::new(&Recording::read(&f.join(n), Some(machine.axis.kind)).unwrap());
        let problem = Problem::new(Physics::nominal(&machine), vec![rec("a.csv"), rec("b.csv"), rec("c.csv")], 2, machine.axis.resolution, false);
        let t = Instant::now();
        let mut at = nominal(&problem).unwrap();
        let mut line = String::new();
        for stage in 0..2 {
            let c = candidates(&problem, &at, &VOCABULARY);
            let t1 = t.elapsed().as_secs_f64();
            let found = extend(&problem, &at, &c, 5);
            if c.is_empty() { break; } line += &format!(" | {t1:.1}s {}:{:.0} ->", c[0].entry.effect.id, c[0].gain);
            for one in found.iter().take(3) {
                let e = one.hypothesis.entries.last().unwrap();
                line += &format!(" {}{:?}+{:.0}", e.effect.id, e.values.iter().map(|v| (v * 1e5).round() / 1e5).collect::<Vec<_>>(), one.log_likelihood - at.log_likelihood);
            }
            let Some(best) = found.into_iter().next() else { break };
            if best.log_likelihood - at.log_likelihood < 20.0 { break; }
            if stage == 0 { line += if best.hypothesis.entries[0].effect.id == id[0] { " OK" } else { " WRONG" }; }
            at = best;
        }
        println!("{} {:?} {:.1}s{line}", f.file_name().unwrap().to_string_lossy(), id, t.elapsed().as_secs_f64());
    }
}
