//! Figures: small however long the recording, the same bytes each time, text as text.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use lab::plot::{Figure, Panel};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

fn busy_figure(rows: usize) -> Figure {
    let mut random = StdRng::seed_from_u64(1);
    let t_s: Vec<f64> = (0..rows).map(|k| k as f64 * 5e-4).collect();
    let noise: Vec<f64> = t_s.iter().map(|t| t.sin() + random.random_range(-0.1..0.1)).collect();
    let held: Vec<f64> = t_s.iter().map(|t| (3.0 * t).sin().signum()).collect();
    let mut broken = noise.clone();
    broken[rows / 3..rows / 2].fill(f64::NAN);
    Figure::new("A title with <, & and µ", "time", "s")
        .panel(Panel::new("position", "rad").line("measured", &t_s, &noise).line("model", &t_s, &broken))
        .panel(Panel::new("torque", "N m").step("commanded", &t_s, &held))
        .panel(Panel::new("residual", "rad").scatter("", &t_s, &noise).scatter("held-out", &noise, &t_s))
        .panel(Panel::new("orbit", "").line("", &noise, &held).scatter("none", &[], &[]))
}

#[test]
fn figures_stay_small_and_are_the_same_each_time() {
    for rows in [2, 100, 200_000] {
        let figure = busy_figure(rows);
        let svg = figure.to_svg().unwrap();
        assert!(svg.len() < 500_000, "{rows} rows: {} bytes", svg.len());
        assert_eq!(svg, figure.to_svg().unwrap());
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{rows} rows");
    }
}

#[test]
fn every_axis_title_and_legend_is_text() {
    let svg = busy_figure(100).to_svg().unwrap();
    for text in ["A title with &lt;, &amp; and µ", "time [s]", "position [rad]", "torque [N m]", "orbit", "held-out"] {
        assert!(svg.lines().any(|line| line.trim() == text), "{text}");
    }
    assert!(svg.contains("<text"));
}

#[test]
fn odd_figures_are_drawn_too() {
    let huge = [f64::MAX, f64::MIN, 1e300, -1e300, 5e-324];
    let figures = [
        Figure::new("nothing", "", ""),
        Figure::new("empty", "time", "s").panel(Panel::new("y", "")),
        Figure::new("constant", "time", "s").panel(Panel::new("y", "").line("", &[1.0, 1.0], &[2.0, 2.0])),
        Figure::new("tiny", "time", "s").panel(Panel::new("y", "").line("", &[1e6, 1e6 + 1e-9], &[1.0, 1.0 + 1e-15])),
        Figure::new("huge", "x", "").panel(Panel::new("y", "").line("a", &huge, &huge).step("b", &huge, &huge)),
        Figure::new("no numbers", "x", "").panel(Panel::new("y", "").scatter("a", &[f64::NAN], &[f64::INFINITY])),
    ];
    for figure in figures {
        let svg = figure.to_svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{figure:?}");
    }
}
