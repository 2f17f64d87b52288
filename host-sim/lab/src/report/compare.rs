//! The comparison of a model with a recording: how large the residual is, and where.

use std::fmt::{Display, Formatter};

use diagnosis::windows::HORIZONS_S;
use plant::Model;

use super::Units;
use crate::Error;
use crate::plot::{Figure, Mark, Panel, Series};
use crate::read::{Axis, Recording};
use crate::residual::{Channel, Map, Orders, Residual, Window, residual, sensor_noise};

/// Length of the shorter windows, s, where ten rows take no longer;
pub const HORIZON_S: f64 = HORIZONS_S[0];
/// the longer ones are so many times that.
const LONGER: f64 = HORIZONS_S[1] / HORIZONS_S[0];
/// Windows named as the worst.
const WORST: usize = 5;

/// A model beside a recording.
#[derive(Debug, Clone)]
pub struct Comparison<'a> {
    recording: &'a Recording,
    units: Units,
    noise: f64,
    residuals: Vec<Residual>,
    maps: Vec<Map>,
    orders: Option<Orders>,
}

impl<'a> Comparison<'a> {
    /// Runs the model over the recording in windows of both lengths, and maps what is left.
    ///
    /// # Errors
    /// A recording too short for the windows, or a model the plant refuses.
    pub fn new(model: &Model, axis: &Axis, recording: &'a Recording) -> Result<Self, Error> {
        let short = residual(model, recording, HORIZON_S)?;
        let long = residual(model, recording, LONGER * short.horizon_s)?;
        let residuals = vec![short, long];
        let channels = [Channel::Direction, Channel::Speed, Channel::Position, Channel::Field, Channel::Time];
        let maps = channels.into_iter().filter_map(|channel| Map::over(channel, &residuals[0], recording)).collect();
        Ok(Self {
            recording,
            units: Units::of(recording.axis),
            noise: sensor_noise(recording, axis),
            orders: Orders::of(&residuals[0], recording),
            residuals,
            maps,
        })
    }

    /// Residual of the shorter windows, root mean square, rad (m).
    pub fn rms(&self) -> f64 {
        self.residuals[0].rms()
    }

    /// Share of the residual torque that a channel explains; 0 where the recording lacks it.
    pub fn explained(&self, channel: Channel) -> f64 {
        self.maps.iter().find(|map| map.channel == channel).map_or(0.0, |map| map.explained)
    }

    /// Orders per revolution in the residual torque; none where they cannot be told.
    pub fn orders(&self) -> Option<&Orders> {
        self.orders.as_ref()
    }

    /// Position, residual over time, residual torque over each channel the recording has.
    pub fn figure(&self, title: &str) -> Figure {
        let (r, u) = (self.recording, self.units);
        let position = Series::new("recorded", Mark::Line, r.t_s.iter().copied().zip(r.position.iter().copied()));
        let mut panels = vec![Panel::new("time (s)", &format!("position ({})", u.position), vec![position])];
        panels.extend(self.residuals.iter().map(|residual| self.residual_panel(residual)));
        let torque = format!("residual {} ({})", u.effort_name, u.effort);
        for map in self.maps.iter().filter(|map| map.channel != Channel::Direction && map.channel != Channel::Time) {
            let (name, unit) = self.channel_label(map.channel);
            panels.push(Panel::new(&format!("{name} ({unit})"), &torque, self.map_series(map)));
        }
        Figure { title: title.to_owned(), panels }
    }

    /// The longer windows leave far more, so each length has a panel of its own.
    fn residual_panel(&self, residual: &Residual) -> Panel {
        let rows = residual.windows.iter().flat_map(|window| (window.start..window.end).zip(&window.residual));
        let name = format!("windows of {:.0} ms", 1e3 * residual.horizon_s);
        let series = Series::new(&name, Mark::Line, rows.map(|(row, value)| (self.recording.t_s[row], *value)));
        Panel::new("time (s)", &format!("recorded - simulated ({})", self.units.position), vec![series])
    }

    fn map_series(&self, map: &Map) -> Vec<Series> {
        let points = Map::points(map.channel, &self.residuals[0], self.recording).unwrap_or_default();
        let means = map.bins.iter().map(|bin| (0.5 * (bin.low + bin.high), bin.mean_torque));
        vec![Series::new("one window", Mark::Points, points), Series::new("mean", Mark::Line, means)]
    }

    fn channel_label(&self, channel: Channel) -> (&'static str, &'static str) {
        match channel {
            Channel::Direction => ("direction", "1"),
            Channel::Speed => ("speed", self.units.speed),
            Channel::Position => ("position", self.units.position),
            Channel::Field => ("field", "kV/mm"),
            Channel::Time => ("time", "s"),
        }
    }

    fn worst(&self) -> Vec<&Window> {
        let mut windows: Vec<&Window> = self.residuals[0].windows.iter().collect();
        windows.sort_by(|a, b| b.torque.abs().total_cmp(&a.torque.abs()));
        windows.truncate(WORST);
        windows
    }

    fn write_windows(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let u = self.units;
        writeln!(f, "sensor noise  {:.3e} {} (one sample, standard deviation)", self.noise, u.position)?;
        for residual in &self.residuals {
            let torque: f64 = residual.windows.iter().map(|w| w.torque * w.torque).sum();
            let torque = (torque / residual.windows.len() as f64).sqrt();
            writeln!(
                f,
                "{:>4.0} ms windows  residual {:.3e} {} rms, {:.1} times the noise; as a {} {torque:.4} {} rms; {} windows",
                1e3 * residual.horizon_s,
                residual.rms(),
                u.position,
                residual.rms() / self.noise.max(f64::MIN_POSITIVE),
                u.effort_name,
                u.effort,
                residual.windows.len()
            )?;
        }
        Ok(())
    }

    fn write_maps(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let u = self.units;
        let mut maps: Vec<&Map> = self.maps.iter().collect();
        maps.sort_by(|a, b| b.explained.total_cmp(&a.explained));
        let aside = self.residuals[0].windows.len() - self.residuals[0].usual().count();
        if aside > 0 {
            writeln!(f, "set aside from the shares: {aside} windows far beyond all others, see the worst windows")?;
        }
        writeln!(f, "share of the residual {} that follows each channel, and where it is largest:", u.effort_name)?;
        if let Some(orders) = &self.orders {
            let names: Vec<String> =
                orders.orders.iter().map(|o| format!("{} ({:.4} N m)", o.per_rev, o.amplitude_nm)).collect();
            let share = 100.0 * orders.explained;
            writeln!(f, "  {share:>5.1} %  position within a revolution, orders {}", names.join(", "))?;
        }
        for map in maps {
            let (name, unit) = self.channel_label(map.channel);
            let Some(bin) = map.bins.iter().max_by(|a, b| a.mean_torque.abs().total_cmp(&b.mean_torque.abs())) else {
                continue;
            };
            writeln!(
                f,
                "  {:>5.1} %  {name:<9} {:+.4} +- {:.4} {} at {:.4} to {:.4} {unit}",
                100.0 * map.explained,
                bin.mean_torque,
                1.96 * bin.standard_error,
                u.effort,
                bin.low,
                bin.high
            )?;
        }
        Ok(())
    }
}

impl Display for Comparison<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (r, u) = (self.recording, self.units);
        let length_s = r.t_s.last().unwrap_or(&0.0) - r.t_s.first().unwrap_or(&0.0);
        writeln!(f, "{}: {} rows, {length_s:.3} s, {} gaps", r.name, r.t_s.len(), r.gaps.len())?;
        self.write_windows(f)?;
        self.write_maps(f)?;
        writeln!(f, "worst windows of {:.0} ms:", 1e3 * self.residuals[0].horizon_s)?;
        for window in self.worst() {
            writeln!(
                f,
                "  t = {:.4} to {:.4} s  {:+.4} {} at {:+.4} {}",
                r.t_s[window.start],
                r.t_s[window.end - 1],
                window.torque,
                u.effort,
                window.speed,
                u.speed
            )?;
        }
        Ok(())
    }
}
