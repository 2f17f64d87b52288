//! Everything `servo-lab stability` says about one loop.

use er_servo::Config;
use nalgebra::Complex;

use super::case::{Fluid, Gains, Loop, LoopError, NormalisedGains, Plant};
use super::describing::{ModelCycles, Search, cycles_by_model};
use super::limits::{Margins, Tolerance, margins, tolerances};
use super::region::{Region, Window, stable_region};
use super::{argument, curves, sampled, spectrum};

/// A root of the characteristic function.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Root {
    /// Real part, 1/s.
    pub re_per_s: f64,
    /// Imaginary part, rad/s.
    pub im_rad_s: f64,
}

/// The answers of the four methods.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Methods {
    /// Unstable roots by what a path in the plane of the gains crosses.
    pub curves_unstable_roots: usize,
    /// Unstable roots by the argument principle; none with a root on the axis.
    pub argument_unstable_roots: Option<usize>,
    /// Unstable roots of the Chebyshev discretisation; none where it does not resolve the loop.
    pub spectrum_unstable_roots: Option<usize>,
    /// From the right.
    pub rightmost_roots: Vec<Root>,
    /// Of one control period of the sampled loop; stable below 1. None for delays of too many periods.
    pub sampled_spectral_radius: Option<f64>,
    /// Its verdict. It may differ from the others near the boundary, being half a period later.
    pub sampled_stable: Option<bool>,
    /// Control period, s.
    pub sampled_period_s: f64,
    /// Whether the continuous loop with the sampled one's delays is stable; what `sampled_stable` is to be held against.
    pub held_equivalent_stable: bool,
    /// Of those that answered, the continuous methods agree with each other, and the sampled one with its continuous
    /// equivalent.
    pub agree: bool,
    /// Why a method did not answer.
    pub unanswered: Vec<String>,
}

/// A region of the plane of the gains.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct RegionArea {
    /// Delay model of the fluid.
    pub fluid: Fluid,
    /// In units of K_p* K_d*, within the window.
    pub area: f64,
    /// Whether the gains are in it.
    pub inside: bool,
    /// The region goes on beyond the window, which then cuts the area.
    pub leaves_window: bool,
}

/// The whole answer.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Analysis {
    /// The plant.
    pub plant: Plant,
    /// The gains in N m.
    pub gains: Gains,
    /// The gains scaled with the plant's own delay and inertia, the point of the plot.
    pub normalised_gains: NormalisedGains,
    /// Whether the gains are in the stable region.
    pub inside: bool,
    /// By each method.
    pub methods: Methods,
    /// None (null) for an unstable loop.
    pub margins: Option<Margins>,
    /// How far each quantity may move alone; empty for an unstable loop.
    pub tolerances: Vec<Tolerance>,
    /// Area of the region of the chosen model within the window.
    pub area: f64,
    /// First-quadrant window of all areas.
    pub window: Window,
    /// The region without delay of the fluid, with a dead time and with a lag of the same length.
    pub regions: Vec<RegionArea>,
    /// Limit cycles of the nonlinear loop by harmonic balance under each delay model of the fluid; none (null) if the
    /// control law does not allow these gains.
    pub limit_cycles: Option<Vec<ModelCycles>>,
    /// Where they were searched.
    pub limit_cycle_search: Search,
}

/// What the analysis needs besides the loop.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Part of the plane that is looked at.
    pub window: Window,
    /// Delay of the fluid in the models the loop itself does not have, s.
    pub field_delay_s: f64,
    /// Dry friction for the limit cycles, N m.
    pub coulomb_nm: f64,
    /// Parameters of the law for the limit cycles.
    pub control: Config,
}

/// Analyses one loop, and returns the regions of the three delay models for a plot.
///
/// # Errors
/// [`LoopError`] if a method cannot carry the loop.
pub fn analyse(closed: &Loop, setting: &Setting) -> Result<(Analysis, Vec<Region>), LoopError> {
    let plant = *closed.plant();
    let (mut areas, mut regions) = (Vec::new(), Vec::new());
    for fluid in
        [Fluid::None, Fluid::DeadTime { l_q_s: setting.field_delay_s }, Fluid::Lag { t_q_s: setting.field_delay_s }]
    {
        let plant = Plant { fluid, ..plant };
        let region = stable_region(&plant, setting.window)?;
        let inside = curves::is_inside(&Loop::new(plant, closed.gains())?);
        areas.push(RegionArea { fluid, area: region.area(), inside, leaves_window: region.leaves_window() });
        regions.push(region);
    }
    let own = match areas.iter().find(|region| region.fluid == plant.fluid) {
        Some(region) => region.area,
        None => stable_region(&plant, setting.window)?.area(),
    };
    let analysis = Analysis {
        plant,
        gains: closed.gains(),
        normalised_gains: closed.normalised_gains(),
        inside: curves::is_inside(closed),
        methods: methods(closed, sampled::PERIOD_S)?,
        margins: margins(closed),
        tolerances: tolerances(closed),
        area: own,
        window: setting.window,
        regions: areas,
        limit_cycles: cycles_by_model(closed, &setting.control, setting.coulomb_nm, Search::SERVO).ok(),
        limit_cycle_search: Search::SERVO,
    };
    Ok((analysis, regions))
}

/// Every method's answer; only the curves and the argument principle answer for every checked loop.
fn methods(closed: &Loop, period_s: f64) -> Result<Methods, LoopError> {
    let mut unanswered = Vec::new();
    let mut unanswer = |error: LoopError| unanswered.push(error.to_string());
    let roots = spectrum::rightmost_roots(closed).map_err(&mut unanswer).ok();
    let sampled_spectral_radius = sampled::spectral_radius(closed, period_s).map_err(&mut unanswer).ok();
    let curves_unstable_roots = curves::unstable_roots(closed);
    let argument_unstable_roots = argument::unstable_roots(closed);
    let spectrum_unstable_roots = roots.as_deref().map(spectrum::unstable_roots);
    let sampled_stable = sampled_spectral_radius.map(|radius| radius < 1.0);
    let held_equivalent_stable = curves::is_inside(&sampled::held_equivalent(closed, period_s)?);
    let root = |s: Complex<f64>| Root { re_per_s: s.re, im_rad_s: s.im };
    Ok(Methods {
        curves_unstable_roots,
        argument_unstable_roots,
        spectrum_unstable_roots,
        rightmost_roots: roots.into_iter().flatten().map(root).collect(),
        sampled_spectral_radius,
        sampled_stable,
        sampled_period_s: period_s,
        held_equivalent_stable,
        agree: argument_unstable_roots == Some(curves_unstable_roots)
            && spectrum_unstable_roots.is_none_or(|count| count == curves_unstable_roots)
            && sampled_stable.is_none_or(|stable| stable == held_equivalent_stable),
        unanswered,
    })
}
