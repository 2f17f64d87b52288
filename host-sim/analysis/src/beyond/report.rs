//! The comparison as a table and a picture.

use std::fmt::Write;

use super::measure::{Figures, LINES, runs};
use super::{Comparison, Mode, UNCERTAINTY};
use crate::plot::{Figure, Mark, Panel, Series, Stroke};
use crate::simulate::Row;
use recording::Error;

/// Figures within this of each other are the same: 1 %, or two counts, half a tick and what else is finer than a run tells.
fn worse(figure: f64, paper: f64) -> bool {
    figure > 1.01 * paper + 0.03
}

impl Comparison {
    /// Lines on which a mode is worse than the paper's law, nominal and worst, and on how many better.
    pub(super) fn against_paper(&self, nominal: Figures, worst: Figures) -> (Vec<&'static str>, usize) {
        let Some(paper) = self.entries.first() else { return (Vec::new(), 0) };
        let (mut lost, mut won) = (Vec::new(), 0);
        for (line, name) in LINES.iter().enumerate() {
            let pairs = [(nominal.0[line], paper.nominal.0[line]), (worst.0[line], paper.worst.0[line])];
            if pairs.iter().any(|(figure, paper)| worse(*figure, *paper)) {
                lost.push(*name);
            }
            won += usize::from(pairs.iter().all(|(figure, paper)| worse(*paper, *figure)));
        }
        (lost, won)
    }

    /// Each mode against the paper's law, in words.
    #[must_use]
    pub fn verdicts(&self) -> Vec<String> {
        let one = |entry: &super::Entry| {
            let (lost, won) = self.against_paper(entry.nominal, entry.worst);
            let verdict = match lost[..] {
                [] if won > 0 => format!("no worse on any line and better on {won}"),
                [] => "the same".to_owned(),
                _ => format!("better on {won} lines, worse on: {}", lost.join(", ")),
            };
            format!("{}: {verdict}", entry.mode.name)
        };
        self.entries.iter().skip(1).map(one).collect()
    }

    /// The table, one column a mode, as Markdown: nominal / worst in each cell.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# Beyond the paper's law\n\nThe machine is E dead 2 + lag 3 ms, L 5 ms, speed from counts; steps of 30 degrees and \
             50 mrad, 8 N m for 50 ms at rest. Each cell: with the delays the mode was told / the worst with every delay off by \
             +-{:.0} %, alone and together (27 machines). The modes run beside the flashed step and are not in the firmware. \
             u = c / K_P = 3.18 mrad with the paper's gains; settling into 2 % or 1.5 u; 800 ms is not within the run.\n\n",
            100.0 * UNCERTAINTY
        );
        let names: Vec<&str> = self.entries.iter().map(|entry| entry.mode.name).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
        for (line, name) in LINES.iter().enumerate() {
            let cell = |entry: &super::Entry| format!("{:.1} / {:.1}", entry.nominal.0[line], entry.worst.0[line]);
            let cells: Vec<String> = self.entries.iter().map(cell).collect();
            let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        }
        text.push('\n');
        if let Some(entry) = self.winner() {
            let _ = writeln!(text, "Won: {} (`servo-lab simulate --mode {}`).\n", entry.mode.name, entry.mode.key);
        }
        text += &self.verdicts().iter().map(|line| format!("- {line}\n")).collect::<String>();
        text
    }

    /// The paper's law, each part of the winner alone, and the winner; without a winner every part.
    fn shown(&self) -> Vec<&Mode> {
        let winner = self.winner().map(|entry| entry.mode);
        let shown = |mode: &&Mode| match winner {
            _ if mode.parts() == 0 => true,
            Some(winner) => **mode == winner || (mode.parts() == 1 && winner.has(mode)),
            None => mode.parts() == 1,
        };
        self.entries.iter().map(|entry| &entry.mode).filter(shown).collect()
    }

    /// Error of both steps and under the push, and the field, of the paper's law, of each part of the winner and of the winner.
    ///
    /// # Errors
    /// A value the law or the plant does not take.
    pub fn figure(&self) -> Result<Figure, Error> {
        let shown = self.shown();
        let all: Vec<(&Mode, [Vec<Row>; 3])> =
            shown.into_iter().map(|mode| Ok((mode, runs(mode, [1.0; 3])?))).collect::<Result<_, Error>>()?;
        let won = self.winner().map(|entry| entry.mode);
        let stroke = |index: usize, mode: &Mode| match index {
            _ if won == Some(*mode) => Stroke::Solid,
            0 => Stroke::Dotted,
            _ => [Stroke::Dashed, Stroke::DashDot][index % 2],
        };
        let panel = |label: &str, run: usize, until_s: f64, value: fn(&Row) -> f64| {
            let series = all.iter().enumerate().map(|(index, (mode, runs))| {
                let stroke = stroke(index, mode);
                let rows = runs[run].iter().filter(|row| row.t_s <= until_s);
                Series::new(mode.name, Mark::Line, rows.map(|row| (row.t_s, value(row)))).with(stroke)
            });
            Panel::new("time (s)", label, series.collect())
        };
        let error = |row: &Row| 1e3 * (row.reference.to_rad() - row.truth.position);
        let near = |row: &Row| {
            let error = 1e3 * (row.reference.to_rad() - row.truth.position);
            if error.abs() < 40.0 { error } else { f64::NAN }
        };
        let field = |row: &Row| f64::from(row.outputs.field_kv_mm);
        let panels = vec![
            panel("30 degrees, error (mrad)", 0, 0.3, near),
            panel("its field (kV/mm)", 0, 0.3, field),
            panel("50 mrad, error (mrad)", 1, 0.3, error),
            panel("its field (kV/mm)", 1, 0.3, field),
            panel("8 N m at 0.1 s, error (mrad)", 2, 0.3, error),
            panel("its field (kV/mm)", 2, 0.3, field),
        ];
        Ok(Figure {
            title: "Beyond the paper's law: E dead 2 + lag 3 ms, L 5 ms, speed from counts".to_owned(),
            panels,
        })
    }
}
