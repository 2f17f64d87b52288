//! The control beyond the paper's law: what it is compared by, and that the paper's law is in it as it is.

use analysis::beyond::{LINES, MODES, Mode, compare, find, is_told, run};
use analysis::paper::case::{Case, Fluid, Speed};
use analysis::simulate::Setup;
use er_servo::{Config, Counts};

use crate::common::{field, paper, setup};

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
    // What won is drawn, beside its parts alone; the gain's own share is one of them.
    let winner = comparison.winner().unwrap().mode;
    assert_eq!(winner.key, "predictor-lead-gains-1.25");
    let figure = comparison.figure().unwrap();
    for panel in &figure.panels {
        let names: Vec<&str> = panel.series.iter().map(|series| series.name.as_str()).collect();
        assert_eq!(names, ["the paper's law", "gains x 1.25", "field lead", "predictor", winner.name]);
    }
    assert!(figure.to_svg().unwrap().contains("<polyline"));
    assert!(text.contains("--mode predictor-lead-gains-1.25"));
}

#[test]
fn the_gain_alone_costs_where_the_predictor_with_it_does_not() {
    let comparison = compare().unwrap();
    let of = |key: &str| comparison.entries.iter().find(|entry| entry.mode.key == key).unwrap().nominal.0;
    let (paper, gain) = (of("paper"), of("gains-1.25"));
    assert!(gain[4] < 0.9 * paper[4], "a stiffer loop rests nearer: {gain:?} {paper:?}");
    let verdicts = comparison.verdicts();
    let gain = verdicts.iter().find(|line| line.starts_with("gains x 1.25: ")).unwrap();
    assert!(gain.contains("worse on: "), "{gain}");
}

#[test]
fn keys_find_their_modes_and_a_mode_changes_a_run() {
    for mode in &MODES {
        assert_eq!(find(mode.key), Some(mode));
    }
    assert_eq!(find("none"), None);
    let setup = |response| setup(paper(response), Config::default());
    let told = setup(field(0.002, 0.003));
    assert!(is_told(&told.model) && !is_told(&setup(field(0.002, 0.004)).model));
    let at = |mode: &Mode, setup: &Setup| run(mode, setup, std::iter::repeat_n(Counts::from_rad(0.05), 400));
    let fields =
        |mode: &Mode| -> Vec<f32> { at(mode, &told).unwrap().iter().map(|row| row.outputs.field_kv_mm).collect() };
    assert_ne!(fields(&MODES[0]), fields(find("lead").unwrap()));
    let late_viscosity = setup(plant::FluidResponse::ViscosityLag { lag_s: 0.005, torque_limit: 2.5 });
    assert!(at(&MODES[0], &late_viscosity).unwrap_err().to_string().contains("delays a viscosity"));
}
