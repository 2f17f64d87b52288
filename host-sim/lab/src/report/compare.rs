//! The comparison of a model with a recording: how large the residual is, and where.

use std::fmt::{Display, Formatter};

use diagnosis::confidence_set::TWO_SIDED_95;
use diagnosis::windows::HORIZONS_S;
use plant::Model;

use super::Units;
use super::html::{number, short};
use super::text::{fall, per_cent};
use crate::Error;
use crate::plot::{Figure, Ink, Mark, Panel, Series, Stroke};
use crate::read::{Axis, Recording};
use crate::residual::{Bin, Channel, Map, Orders, Residual, Window, residual, sensor_noise};

/// Length of the shorter windows, s, where ten rows take no longer;
pub const HORIZON_S: f64 = HORIZONS_S[0];
/// the longer ones are so many times that.
const LONGER: f64 = HORIZONS_S[1] / HORIZONS_S[0];
/// Windows named as the worst.
const WORST: usize = 5;

/// What a model leaves of a recording in windows of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// Length of the windows, s.
    pub horizon_s: f64,
    /// Root mean square of the residual, rad (m).
    pub rms: f64,
    /// Root mean square of the torque (force) that would make it, N m (N).
    pub effort_rms: f64,
    /// Number of windows.
    pub windows: usize,
}

/// How the residual torque (force) goes with a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// The channel.
    pub name: &'static str,
    /// Of the channel.
    pub unit: &'static str,
    /// Share of the residual that follows it, 1.
    pub share: f64,
    /// Mean where it is largest, N m (N).
    pub largest: f64,
    /// Half the width of its 95 % interval, N m (N).
    pub half: f64,
    /// From where to where that is, in the unit of the channel.
    pub range: [f64; 2],
}

impl Followed {
    /// The mean with its interval, in the digits that it leaves, by that sign of a tolerance.
    pub(crate) fn mean(&self, within: &str) -> String {
        format!("{} {within} {}", number(self.largest, self.half), number(self.half, self.half))
    }

    /// Where that is, in the digits that tell its ends apart.
    pub(crate) fn place(&self) -> String {
        let [low, high] = self.range;
        if low == high {
            return format!("{} {}", short(low), self.unit).trim_end().to_owned();
        }
        format!("{} to {} {}", number(low, high - low), number(high, high - low), self.unit).trim_end().to_owned()
    }
}

/// A window in which much is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// Its first and last row, s.
    pub span_s: [f64; 2],
    /// The torque (force) that would make its residual, N m (N).
    pub effort: f64,
    /// Mean speed in it, rad/s (m/s).
    pub speed: f64,
}

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

    /// Length, s, and root mean square of the residual, rad (m), of the shorter windows, then of the longer ones.
    pub fn windows(&self) -> impl Iterator<Item = (f64, f64)> {
        self.left().map(|left| (left.horizon_s, left.rms))
    }

    /// What is left in the shorter windows, then in the longer ones.
    pub fn left(&self) -> impl Iterator<Item = Left> {
        self.residuals.iter().map(|residual| {
            let squares: f64 = residual.windows.iter().map(|window| window.torque * window.torque).sum();
            let windows = residual.windows.len();
            let effort_rms = (squares / windows as f64).sqrt();
            Left { horizon_s: residual.horizon_s, rms: residual.rms(), effort_rms, windows }
        })
    }

    /// Names of the units of the recording.
    pub fn units(&self) -> Units {
        self.units
    }

    /// What the residual follows, the most first.
    pub fn followed(&self) -> Vec<Followed> {
        let one = |map: &Map| {
            let (name, unit) = self.channel_label(map.channel);
            let bin = map.bins.iter().max_by(|a, b| a.mean_torque.abs().total_cmp(&b.mean_torque.abs()))?;
            let half = TWO_SIDED_95 * bin.standard_error;
            Some(Followed {
                name,
                unit,
                share: map.explained,
                largest: bin.mean_torque,
                half,
                range: [bin.low, bin.high],
            })
        };
        let mut followed: Vec<Followed> = self.maps.iter().filter_map(one).collect();
        followed.sort_by(|a, b| b.share.total_cmp(&a.share));
        followed
    }

    /// Windows far beyond all others, which no share counts.
    pub fn set_aside(&self) -> usize {
        self.residuals[0].windows.len() - self.residuals[0].usual().count()
    }

    /// The shorter windows in which most is left.
    pub fn worst(&self) -> Vec<Worst> {
        let mut windows: Vec<&Window> = self.residuals[0].windows.iter().collect();
        windows.sort_by(|a, b| b.torque.abs().total_cmp(&a.torque.abs()));
        windows.truncate(WORST);
        let t_s = &self.recording.t_s;
        let one = |window: &Window| Worst {
            span_s: [t_s[window.start], t_s[window.end - 1]],
            effort: window.torque,
            speed: window.speed,
        };
        windows.into_iter().map(one).collect()
    }

    /// Standard deviation of the sensor's noise, one sample, rad (m).
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// Share of the residual torque that a channel explains; 0 where the recording lacks it.
    pub fn explained(&self, channel: Channel) -> f64 {
        self.maps.iter().find(|map| map.channel == channel).map_or(0.0, |map| map.explained)
    }

    /// Orders per revolution in the residual torque; none where they cannot be told.
    pub fn orders(&self) -> Option<&Orders> {
        self.orders.as_ref()
    }

    /// Position, residual over time, residual torque over each channel the recording has; of an improved model too, where there
    /// is one. Bars are 95 % intervals of means.
    pub fn figure(&self, title: &str, improved: Option<&Self>) -> Figure {
        let (r, u) = (self.recording, self.units);
        let mut position = vec![
            Series::new("recorded", Mark::Line, r.t_s.iter().copied().zip(r.position.iter().copied()))
                .inked(Ink::Recorded),
        ];
        let models = self.models(improved);
        position.extend(models.iter().map(|(name, ink, model)| model.simulated(name).inked(*ink).with(stroke(*ink))));
        let mut panels = vec![Panel::new("time (s)", &format!("position ({})", u.position), position)];
        // The longer windows leave far more, so each length has a panel of its own.
        panels.extend((0..self.residuals.len()).map(|length| {
            let series = models.iter().map(|(name, ink, model)| model.residual_series(length, name).inked(*ink));
            Panel::new("time (s)", &format!("recorded - simulated ({})", u.position), series.collect())
        }));
        let torque = format!("residual {} ({})", u.effort_name, u.effort);
        for map in self.maps.iter().filter(|map| map.channel != Channel::Direction && map.channel != Channel::Time) {
            let (name, unit) = self.channel_label(map.channel);
            let series = models.iter().flat_map(|(name, ink, model)| model.map_series(map.channel, name, *ink));
            panels.push(Panel::new(&format!("{name} ({unit})"), &torque, series.collect()));
        }
        Figure { title: title.to_owned(), panels }
    }

    /// This model, and the improved one over it.
    fn models<'b>(&'b self, improved: Option<&'b Self>) -> Vec<(&'static str, Ink, &'b Self)> {
        let improved = improved.map(|improved| ("improved", Ink::Improved, improved));
        std::iter::once(("nominal", Ink::Nominal, self)).chain(improved).collect()
    }

    /// The position that the model has in the longer windows, broken where one begins anew.
    fn simulated(&self, name: &str) -> Series {
        let windows = self.residuals.last().map_or(&[][..], |residual| &residual.windows);
        let rows = windows.iter().flat_map(|window| {
            let rows = (window.start..window.end).zip(&window.residual);
            rows.map(|(row, left)| (self.recording.t_s[row], self.recording.position[row] - left))
                .chain([(f64::NAN, f64::NAN)])
        });
        Series::new(name, Mark::Line, rows)
    }

    fn residual_series(&self, length: usize, name: &str) -> Series {
        let residual = &self.residuals[length];
        let rows = residual.windows.iter().flat_map(|window| (window.start..window.end).zip(&window.residual));
        let name = format!("{name}, windows of {:.0} ms", 1e3 * residual.horizon_s);
        Series::new(&name, Mark::Line, rows.map(|(row, value)| (self.recording.t_s[row], *value)))
    }

    /// The mean of each bin with its 95 % interval; of the nominal model each window, too.
    fn map_series(&self, channel: Channel, name: &str, ink: Ink) -> Vec<Series> {
        let Some(map) = self.maps.iter().find(|map| map.channel == channel) else { return Vec::new() };
        let middle = |bin: &Bin| 0.5 * (bin.low + bin.high);
        let bar = |bin: &Bin| {
            let half = TWO_SIDED_95 * bin.standard_error;
            (middle(bin), bin.mean_torque - half, bin.mean_torque + half)
        };
        let points = || Map::points(channel, &self.residuals[0], self.recording).unwrap_or_default();
        let cloud = (ink == Ink::Nominal)
            .then(|| Series::new("nominal, one window", Mark::Points, points()).inked(Ink::Recorded));
        let means = map.bins.iter().map(|bin| (middle(bin), bin.mean_torque));
        let mean = Series::new(&format!("{name}, mean"), Mark::Line, means).inked(ink).with(stroke(ink));
        let bars = Series::bars(&format!("{name}, 95 %"), map.bins.iter().map(bar)).inked(ink);
        cloud.into_iter().chain([mean, bars]).collect()
    }

    fn channel_label(&self, channel: Channel) -> (&'static str, &'static str) {
        match channel {
            Channel::Direction => ("direction", ""),
            Channel::Speed => ("speed", self.units.speed),
            Channel::Position => ("position", self.units.position),
            Channel::Field => ("field", "kV/mm"),
            Channel::Time => ("time", "s"),
        }
    }

    fn write_windows(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let u = self.units;
        writeln!(f, "sensor noise  {:.3e} {} (one sample, standard deviation)", self.noise, u.position)?;
        for left in self.left() {
            writeln!(
                f,
                "{:>4.0} ms windows  residual {:.3e} {} rms, {:.1} times the noise; as a {} {:.4} {} rms; {} windows",
                1e3 * left.horizon_s,
                left.rms,
                u.position,
                left.rms / self.noise.max(f64::MIN_POSITIVE),
                u.effort_name,
                left.effort_rms,
                u.effort,
                left.windows
            )?;
        }
        Ok(())
    }

    /// What this model, an improved one, leaves, and how much less that is than what another one does.
    pub fn beside(&self, other: &Self) -> String {
        let each = self.residuals.iter().zip(&other.residuals).map(|(own, other)| {
            let (rms, before) = (own.rms(), other.rms());
            format!(
                "{:>4.0} ms windows  residual {rms:.3e} {} rms, {:.1} times the noise, {} % less\n",
                1e3 * own.horizon_s,
                self.units.position,
                rms / self.noise.max(f64::MIN_POSITIVE),
                per_cent(fall(before, rms))
            )
        });
        each.collect()
    }

    fn write_maps(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let u = self.units;
        let aside = self.set_aside();
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
        for followed in self.followed() {
            let (percent, name, effort) = (100.0 * followed.share, followed.name, u.effort);
            writeln!(f, "  {percent:>5.1} %  {name:<9} {} {effort} at {}", followed.mean("+-"), followed.place())?;
        }
        Ok(())
    }
}

/// Where the two models run side by side, the strokes tell them apart without colours.
fn stroke(ink: Ink) -> Stroke {
    if ink == Ink::Improved { Stroke::Solid } else { Stroke::Dashed }
}

impl Display for Comparison<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let (r, u) = (self.recording, self.units);
        let length_s = r.t_s.last().unwrap_or(&0.0) - r.t_s.first().unwrap_or(&0.0);
        writeln!(f, "{}: {} rows, {length_s:.3} s, {} gaps", r.name, r.t_s.len(), r.gaps.len())?;
        self.write_windows(f)?;
        self.write_maps(f)?;
        writeln!(f, "worst windows of {:.0} ms:", 1e3 * self.residuals[0].horizon_s)?;
        for Worst { span_s: [start_s, end_s], effort, speed } in self.worst() {
            let (effort_unit, speed_unit) = (u.effort, u.speed);
            writeln!(f, "  t = {start_s:.4} to {end_s:.4} s  {effort:+.4} {effort_unit} at {speed:+.4} {speed_unit}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_told_in_the_digits_of_its_interval() {
        let speed = Followed {
            name: "speed",
            unit: "rad/s",
            share: 0.5,
            largest: 0.2749,
            half: 0.1084,
            range: [-8.3608, -6.7984],
        };
        assert_eq!((speed.mean("+-"), speed.place()), ("0.27 +- 0.11".to_owned(), "-8.4 to -6.8 rad/s".to_owned()));
        // The direction is a number alone.
        assert_eq!(Followed { unit: "", range: [1.0, 1.0], ..speed }.place(), "1");
    }
}
