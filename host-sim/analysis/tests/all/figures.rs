//! Figures: small however long the recording, the same bytes each time, text as text.

use analysis::plot::{Figure, Ink, Mark, Panel, Series};
use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};

fn busy_figure(rows: usize) -> Figure {
    let mut random = StdRng::seed_from_u64(1);
    let t_s: Vec<f64> = (0..rows).map(|k| k as f64 * 5e-4).collect();
    let noise: Vec<f64> = t_s.iter().map(|t| t.sin() + random.random_range(-0.1..0.1)).collect();
    let held: Vec<f64> = t_s.iter().map(|t| (3.0 * t).sin().signum()).collect();
    let mut broken = noise.clone();
    broken[rows / 3..rows / 2].fill(f64::NAN);
    let series = |name, mark, x: &[f64], y: &[f64]| Series::new(name, mark, x.iter().copied().zip(y.iter().copied()));
    let position = vec![series("measured", Mark::Line, &t_s, &noise), series("model", Mark::Line, &t_s, &broken)];
    let torque = vec![series("commanded", Mark::Step, &t_s, &held)];
    let clouds = vec![series("", Mark::Points, &t_s, &noise), series("held-out", Mark::Points, &noise, &t_s)];
    let orbit = vec![series("", Mark::Line, &noise, &held), series("none", Mark::Points, &[], &[])];
    figure(
        "A title with <, & and µ",
        vec![
            Panel::new("time (s)", "position (rad)", position),
            Panel::new("time (s)", "torque (N m)", torque),
            Panel::new("residual (rad)", "count (1)", clouds),
            Panel::new("orbit (rad)", "speed (rad/s)", orbit),
        ],
    )
}

fn figure(title: &str, panels: Vec<Panel>) -> Figure {
    Figure { title: title.to_owned(), panels }
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
    let texts =
        ["A title with &lt;, &amp; and µ", "time (s)", "position (rad)", "orbit (rad)", "held-out", "commanded"];
    for text in texts {
        assert!(svg.lines().any(|line| line.trim() == text), "{text}");
    }
    assert!(svg.contains("<text"));
    assert_eq!(svg.matches("time (s)").count(), 1, "two panels share one axis of time");
}

#[test]
fn a_legend_has_the_colour_of_its_line_and_bars_have_ends() {
    let line = Series::new("after", Mark::Line, [(0.0, 0.0), (1.0, 1.0)]).inked(Ink::Improved);
    let bars = Series::bars("95 %", [(0.5, 0.2, 0.8)]).inked(Ink::Nominal);
    let svg = figure("inks", vec![Panel::new("x (1)", "y (1)", vec![line, bars])]).to_svg().unwrap();
    // The line and its sample; the bar with two ends, and the same in the legend.
    for (colour, times) in [("#0072B2", 2), ("#D55E00", 6)] {
        assert_eq!(svg.matches(&format!("stroke=\"{colour}\"")).count(), times, "{colour}: {svg}");
    }
}

#[test]
fn odd_figures_are_drawn_too() {
    let one = |mark, points: &[(f64, f64)]| {
        figure("odd", vec![Panel::new("x (1)", "y (1)", vec![Series::new("a", mark, points.iter().copied())])])
    };
    let huge = [f64::MAX, f64::MIN, 1e300, -1e300, 5e-324].map(|value| (value, value));
    let figures = [
        figure("nothing", vec![]),
        figure("empty", vec![Panel::new("", "", vec![])]),
        one(Mark::Line, &[(1.0, 2.0), (1.0, 2.0)]),
        one(Mark::Line, &[(1e6, 1.0), (1e6 + 1e-9, 1.0 + 1e-15)]),
        one(Mark::Line, &huge),
        one(Mark::Step, &huge),
        one(Mark::Points, &huge),
        one(Mark::Bars, &huge),
        one(Mark::Bars, &[(1.0, f64::NAN), (1.0, 2.0)]),
        one(Mark::Points, &[(f64::NAN, f64::INFINITY)]),
        one(Mark::Line, &[(-5e-324, 5e-324), (5e-324, -5e-324)]),
    ];
    for figure in figures {
        let svg = figure.to_svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{figure:?}");
    }
}
