//! The page holds what the answer says, as text, and loads nothing.
#![allow(clippy::unwrap_used)]

use super::data::{Fit, RecordingPlot, Samples};
use super::maps::{Band, MapPlot};
use super::whiteness::Curve;
use super::*;
use crate::output::{Input, Provenance};
use crate::report::{
    AlternativeAnswer, AlternativeEffect, AlternativeValue, CorrelationAnswer, EffectAnswer, Evidence, Experiment,
    FitAnswer, Interval, Location, PredictorAnswer, Region, Rejected, RemainderAnswer,
};
use crate::report::{Verdict, html};

const HOSTILE: &str = "</script><script>alert(1)</script> & \"a' <b>.csv";

/// An answer in which every text is hostile.
fn answer(verdict: Verdict) -> Answer {
    let hostile = HOSTILE.to_owned();
    let effect = EffectAnswer {
        id: "coulomb_friction".to_owned(),
        text: hostile.clone(),
        equivalent: vec![hostile.clone()],
        nuisances: vec![hostile.clone()],
        parameters: vec![Interval {
            id: "coulomb_nm".to_owned(),
            value: 0.9501,
            low: 0.9482,
            high: 0.9523,
            unit: "N m".to_owned(),
            nominal: Some(0.9),
        }],
        evidence: Evidence { heldout_gain: 0.6, p_value: 0.0, excess_explained: 0.99 },
        recording: Some(hostile.clone()),
    };
    Answer {
        schema: 2,
        verdict,
        effects: vec![effect],
        fit: FitAnswer {
            before_rms: 2e-4,
            after_rms: 1e-5,
            heldout_before_rms: 2e-4,
            heldout_after_rms: 5e-5,
            noise_floor_rms: 9e-6,
            heldout_floor_rms: 9e-6,
            excess_explained: 0.99,
            unit: "rad".to_owned(),
            horizon_s: 0.05,
        },
        locations: vec![Location {
            recording: hostile.clone(),
            start_s: 1.0,
            end_s: 1.5,
            share: 0.3,
            share_low: 0.1,
            share_high: 0.5,
            text: hostile.clone(),
        }],
        regions: vec![Region {
            channel: hostile.clone(),
            low: 0.0,
            high: 0.2,
            share: 0.8,
            share_low: 0.7,
            share_high: 0.9,
        }],
        rejected: vec![Rejected { id: hostile.clone(), heldout_gain: Some(0.01), why: hostile.clone() }],
        experiment: Some(Experiment {
            text: hostile.clone(),
            separates: vec![hostile.clone()],
            reference_csv: Some(hostile.clone()),
        }),
        remainder: Some(RemainderAnswer {
            effort_rms: 0.3,
            unit: hostile.clone(),
            unnamed: vec![hostile.clone()],
            predictors: vec![PredictorAnswer {
                channel: hostile.clone(),
                share: 0.4,
                p_value: 1e-9,
                effort_rms: Some(0.2),
            }],
        }),
        alternatives: vec![AlternativeAnswer {
            effects: vec![AlternativeEffect {
                id: "viscous_friction".to_owned(),
                parameters: vec![AlternativeValue { id: hostile.clone(), value: 0.123_456, unit: hostile.clone() }],
                recording: Some(hostile.clone()),
            }],
        }],
        correlation: Some(CorrelationAnswer {
            values: vec![hostile.clone(), "b".to_owned()],
            matrix: vec![vec![1.0, -0.95], vec![-0.95, 1.0]],
        }),
        warnings: vec![hostile],
    }
}

/// Three recordings of 16,000 rows with digits that do not repeat.
fn plot() -> PlotData {
    let samples = |most: f64, step: f64| Samples {
        step,
        at: (0..16_000).map(|row| Some(((f64::from(row) * 0.37).sin() * most / step) as i64)).collect(),
    };
    let recording = RecordingPlot {
        name: HOSTILE.to_owned(),
        held_out: false,
        rows: 16_000,
        t_s: Samples { step: 1e-6, at: (0..16_000).map(|row| Some(row * 500)).collect() },
        recorded: samples(0.9, 1e-7),
        before: samples(900.0, 1e-2),
        after: Some(samples(90.0, 1e-3)),
        effort: samples(9.0, 1e-4),
        field_kv_mm: Some(samples(3.0, 1e-4)),
        spans: vec![(1.0, 1.5)],
        noise: 20.0,
        fit: Fit { nominal: 0.5, improved: Some(0.9987), noise: 0.999 },
    };
    let band = Band { mean: vec![0.2, 0.3], half: vec![Some(0.01), None] };
    let map = MapPlot {
        title: HOSTILE.to_owned(),
        x_label: "speed (rad/s)".to_owned(),
        y_label: "residual torque (N m)".to_owned(),
        x: vec![-1.0, 1.0],
        before: band.clone(),
        after: Some(band),
    };
    PlotData {
        position_unit: "rad",
        residual_unit: "\u{b5}rad".to_owned(),
        effort_name: "torque",
        effort_unit: "N m",
        recordings: vec![recording.clone(), recording.clone(), RecordingPlot { held_out: true, ..recording }],
        maps: vec![map],
        left: vec![Curve {
            title: "Autocorrelation",
            x_label: "lag (ms)",
            y_label: "correlation (1)",
            log: false,
            x: vec![1.0, 2.0],
            low: vec![-0.1, -0.1],
            high: vec![0.1, 0.1],
            nominal: vec![0.9, 0.8],
            improved: Some(vec![0.05, -0.2]),
        }],
        first: 2,
        equation: vec![HOSTILE.to_owned()],
        window_s: 0.05,
    }
}

/// What made it, hostile too.
fn made() -> Provenance {
    Provenance {
        command: HOSTILE.to_owned(),
        inputs: vec![Input { file: HOSTILE.to_owned(), sha256: Some("0f".to_owned()) }],
        ..Provenance::without_inputs(Some(7))
    }
}

fn written(verdict: Verdict) -> String {
    html::page(HOSTILE, &answer(verdict), &plot(), &made()).unwrap()
}

#[test]
fn the_page_says_the_answer() {
    let page = written(Verdict::Named);
    for part in [
        "The model lacks coulomb friction (0.9501\u{a0}N\u{a0}m)",
        "on data the fit never saw is 75.0 % less",
        "0.9482 to 0.9523",
        "What is left",
        "What was rejected",
        "What to record next",
        "Before you believe this",
        "The nominal model predicts 50 % of the motion, the improved one 99.87 %",
        "Alternative 1: viscous friction in place of coulomb friction",
        "<td>0.1235</td><td>not in it</td>",
        "<strong>-0.95</strong>",
        "Equation of the improved model",
        "Is what is left noise?",
        "-0.20 at 2 ms",
        "cargo install --path host-sim/lab",
        "1.00 to 1.50",
        "coulomb_nm",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(written(Verdict::None).contains("Nothing is missing from the model"));
    assert!(written(Verdict::Unknown).contains("nothing in the vocabulary explains it"));
    assert!(written(Verdict::Controller).contains("no physics is named"));
    assert!(written(Verdict::Ambiguous).contains("cannot tell which"));
}

#[test]
fn effects_are_what_is_missing() {
    for verdict in [Verdict::Named, Verdict::Partial, Verdict::Ambiguous] {
        assert!(written(verdict).contains(">What is missing</h2>"), "{verdict:?}");
    }
}

#[test]
fn names_are_text_wherever_they_stand() {
    let page = written(Verdict::Unknown);
    assert!(!page.contains("<script>alert") && !page.contains("<b>.csv"));
    // Only the page's own scripts: data, uPlot, the page's.
    assert_eq!((page.matches("<script").count(), page.matches("</script").count()), (3, 3));
    assert!(page.contains("&lt;b&gt;.csv"));
}

#[test]
fn nothing_is_loaded() {
    let page = written(Verdict::Named);
    assert!(page.contains("default-src 'none'"));
    assert_eq!(page.matches(" href=").count(), page.matches(" href=\"#").count(), "links within the page only");
    for load in [" src=", "url(", "@import", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!page.contains(load), "{load}");
    }
    // The address in the notice of uPlot is the only one, in a comment.
    let addresses = page.match_indices("://").count();
    assert_eq!(addresses, page.matches("/*! https://github.com/leeoniya/uPlot").count());
}

#[test]
fn three_recordings_of_16_000_rows_stay_under_5_mb() {
    let page = written(Verdict::Named);
    assert!(page.len() < 5_000_000, "{}", page.len());
}

#[test]
fn data_reads_back() {
    let page = written(Verdict::Named);
    let start = page.find("id=\"plot\">").unwrap() + "id=\"plot\">".len();
    let data = &page[start..start + page[start..].find("</script").unwrap()];
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    assert_eq!(data["recordings"][0]["name"], HOSTILE);
    assert_eq!(data["recordings"][2]["held_out"], true);
    assert_eq!(data["recordings"][1]["t_s"]["at"].as_array().unwrap().len(), 16_000);
}
