//! The control beyond the paper's law: what it is compared by, and that the paper's law is in it as it is.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use analysis::beyond::{LINES, MODES, compare};
use analysis::paper::case::{Case, Fluid, Speed};

#[test]
fn the_first_mode_is_the_flashed_law_and_every_mode_has_all_its_figures() {
    let comparison = compare().unwrap();
    assert_eq!(comparison.entries.len(), MODES.len());
    let paper = &comparison.entries[0];
    let flashed = Case { fluid: Fluid::EDead2Lag3, speed: Speed::Counts, ..Case::PAPER };
    let settling_s = flashed.response(&flashed.run().unwrap()).unwrap().settling_s.unwrap();
    assert!((paper.nominal.0[0] - 1e3 * settling_s).abs() < 1e-3, "{:?}, {settling_s} s", paper.nominal);
    assert!((paper.nominal.0[4] / 3.18 - 1.0).abs() < 0.1, "rests near u: {:?}", paper.nominal);
    for entry in &comparison.entries {
        for (line, name) in LINES.iter().enumerate() {
            let (nominal, worst) = (entry.nominal.0[line], entry.worst.0[line]);
            assert!(nominal.is_finite() && nominal >= 0.0 && worst >= nominal, "{}: {name}", entry.mode.name);
        }
    }
    let text = comparison.markdown();
    println!("{text}");
    assert!(LINES.iter().all(|line| text.contains(line)));
    assert!(text.contains("predictor, lead, gains x 1.25: no worse on any line"));
    assert!(comparison.figure().unwrap().to_svg().unwrap().contains("<polyline"));
}
