//! The table of claims: Markdown for a file, and text for a terminal.

use std::fmt::Write;

use super::Reproduction;
use super::case::Fluid;
use super::claims::{RARELY, Verdict, trim_zeros};
use super::scan::{GAINS_DELAYS_S, SLOWNESSES, STEPS_RAD};

impl Verdict {
    /// The verdict in two or three words.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::InPart(_) => "holds in part",
            Self::Rarely(_) => "rarely",
            Self::DoesNotHold(_) => "does not hold",
            Self::NotTestable(_) => "cannot be tested",
        }
    }

    /// Where, or why not; empty for a claim that holds.
    #[must_use]
    pub fn detail(&self) -> &str {
        match self {
            Self::Holds => "",
            Self::InPart(detail) | Self::Rarely(detail) | Self::DoesNotHold(detail) | Self::NotTestable(detail) => {
                detail
            }
        }
    }
}

/// How the paper was reproduced, over which range.
#[must_use]
pub fn preamble(paper: &Reproduction) -> String {
    let list = |values: &[f64], scale: f64| {
        let texts = values.iter().map(|value| trim_zeros(&format!("{:.4}", scale * value)));
        texts.collect::<Vec<_>>().join(", ")
    };
    format!(
        "Verdicts follow one rule: \"holds\" at every place asked, \"holds in part\" at some, \"rarely\" at less than {:.0} % of \
         them, \"does not hold\" at none; the share and the places stand beside it. The law is the one that is flashed, the \
         plant has true stiction. Unless a line says otherwise the law is given the true speed and its brake has no \
         dead-band, as the equations of the paper assume; \"speed from counts\" is what the firmware has (difference of \
         counts, 1 ms low-pass, dead-band of one count a sample). A delayed viscosity gives at most the torque of 3.5 kV/mm, \
         2.51 N m, \"as a fluid can\"; \"as printed\", (6) and (7) have no bound and give up to 571 N m. L is not in the paper; \
         it is scanned: {} ms, times steps of {} rad, times plants {} times as slow as the gains assume, times true speed, \
         true speed with a brake that also holds at rest, and counts, times {} delay models, those of Q in both readings, \
         and all without friction: {} runs. Left out are {} places where friction holds the rotor against the whole step. \
         u = c / K_P is the error dry friction can hold. Settling is into 2 % of the step, or 1.5 u where that is more; a dip \
         is a fall and rise of the speed by 0.02 rad/s. Measured curves are not available: what the paper says of its \
         experiment cannot be tested.",
        100.0 * RARELY,
        list(&GAINS_DELAYS_S, 1e3),
        list(&STEPS_RAD, 1.0),
        list(&SLOWNESSES, 1.0),
        Fluid::ALL.len(),
        paper.runs,
        paper.held
    )
}

/// The whole table as Markdown.
#[must_use]
pub fn markdown(paper: &Reproduction) -> String {
    let mut text = format!("# The paper's claims\n\n{}\n\n", preamble(paper));
    text.push_str("| paper | claim | test | range | figures | verdict |\n|---|---|---|---|---|---|\n");
    for claim in &paper.claims {
        let verdict = match claim.verdict.detail() {
            "" => format!("**{}**", claim.verdict.name()),
            detail => format!("**{}**: {detail}", claim.verdict.name()),
        };
        let cells = [claim.section, claim.statement, claim.test, &claim.range, &claim.figures.join("<br>"), &verdict];
        // Writing to a string cannot fail. A bar or a star would end a cell or start bold text.
        let _ = writeln!(text, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
    }
    text
}

/// The table as paragraphs, verdict first.
#[must_use]
pub fn plain(paper: &Reproduction) -> String {
    let mut text = format!("{}\n\n", preamble(paper));
    for claim in &paper.claims {
        let verdict = claim.verdict.name().to_uppercase();
        let _ = writeln!(text, "{verdict:<17} {} ({})", claim.statement, claim.section);
        if !claim.verdict.detail().is_empty() {
            let _ = writeln!(text, "  where/why  {}", claim.verdict.detail());
        }
        let _ = writeln!(text, "  test       {}\n  range      {}", claim.test, claim.range);
        for figure in &claim.figures {
            let _ = writeln!(text, "  - {figure}");
        }
        text.push('\n');
    }
    text
}
