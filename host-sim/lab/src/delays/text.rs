//! The answer in words.

use std::fmt;

use super::{Answer, Candidate, Plan, Verdict};

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let left: Vec<&str> = self.candidates.iter().filter(|one| one.needed).map(|one| one.name).collect();
        match self.verdict {
            Verdict::Named => writeln!(f, "named: {}", left.join(", "))?,
            Verdict::Ambiguous => writeln!(f, "ambiguous: these recordings do not tell {} apart", left.join(", "))?,
        }
        writeln!(f, "\n{:16}{:>10}{:>10}{:18}values, ms (95 %)", "delay", "behind", "p", " ")?;
        for candidate in &self.candidates {
            writeln!(f, "{candidate}")?;
        }
        writeln!(
            f,
            "\nbehind: log-likelihood by which the first is better. Only these six compete: what else the model leaves\nout, `servo-lab diagnose` looks for."
        )?;
        if self.verdict == Verdict::Ambiguous {
            writeln!(f, "\nto tell them apart, by what the flashed law on the plant would record:")?;
            self.plans.iter().try_for_each(|plan| writeln!(f, "{plan}"))?;
        }
        Ok(())
    }
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let standing = match (self.needed, self.in_set) {
            (true, _) => "possible",
            (false, true) => "more than needed",
            (false, false) => "excluded",
        };
        let values: Vec<String> = self
            .values
            .iter()
            .map(|value| {
                let [own, low, high] = [value.value_s, value.low_s, value.high_s].map(|time_s| 1e3 * time_s);
                format!("{} {own:.3} ({low:.3} to {high:.3})", value.id)
            })
            .collect();
        let p_value = if self.behind == 0.0 { String::new() } else { format!("{:.2e}", self.p_value) };
        write!(f, "{:16}{:10.1}{p_value:>10}  {standing:18}{}", self.name, self.behind, values.join(", "))
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (truth, other) = self.pair;
        let separates = if self.separates { "separates" } else { "does not" };
        write!(
            f,
            "  {separates:10} {}: {:.1} between {truth} and {other}; servo-lab simulate {}",
            self.name, self.difference, self.flags
        )
    }
}
