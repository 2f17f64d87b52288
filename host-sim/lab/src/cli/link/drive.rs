//! What the actions of `servo-lab link` do with the drive.

use std::time::{Duration, Instant};

use er_servo::Counts;
use er_servo::events::KEPT;
use er_servo::link::{Command, Status};
use er_servo::parameters::{Parameter, TABLE};
use wire::connection::LinkError;

use super::set::Assignment;
use super::{BEAT, Drive, FAULT, RUNNING, Run, STOPPING, Stay, TAKES_EFFECT, status};
use crate::cli::decode::note_parameters;
use crate::decode::parameter_line;
use crate::interrupt::Interrupt;
use crate::output::Growing;
use crate::record::OverLink;
use crate::{Error, output};

impl Drive {
    pub(super) fn known<T>(&self, outcome: Result<T, LinkError>) -> Result<T, Error> {
        outcome.map_err(|error| self.line.error(error))
    }

    pub(super) fn tell(&mut self, command: Command) -> Result<(), Error> {
        let outcome = self.connection.tell(command);
        self.known(outcome)
    }

    pub(super) fn status(&mut self) -> Result<Status, Error> {
        let outcome = self.connection.status();
        self.known(outcome)
    }

    pub(super) fn refused(&self, what: &str, status: &Status) -> Error {
        let state = status::state(status).replace('\n', "; ");
        Error::Refused { place: self.line.to_string(), message: format!("{what}: the drive is in state {state}") }
    }

    /// Makes a request, and waits until it shows.
    pub(super) fn tell_until(
        &mut self,
        command: Command,
        what: &str,
        shows: impl Fn(&Status) -> bool,
    ) -> Result<(), Error> {
        self.tell(command)?;
        let deadline = Instant::now() + TAKES_EFFECT;
        loop {
            let status = self.status()?;
            if shows(&status) {
                return output::print(&format!("{what}\n"));
            }
            if Instant::now() > deadline {
                return Err(self.refused(&format!("not {what}"), &status));
            }
        }
    }

    /// Chips that are brought up again, and an event log that has to be tidied, cost an axis its position.
    pub(super) fn clear(&mut self) -> Result<(), Error> {
        let was_homed = self.status()?.homed;
        self.tell_until(Command::ClearFault, "cleared", |status| status.state != FAULT)?;
        if was_homed && !self.status()?.homed {
            output::print("the axis was not watched meanwhile and has lost its position: home it\n")?;
        }
        Ok(())
    }

    pub(super) fn print_status(&mut self, json: bool) -> Result<(), Error> {
        let status = self.status()?;
        let image = status::Image { build: self.connection.build, to_output_s: self.connection.sample_to_output_s };
        output::print(&if json { status::json(&status, &image) } else { status::text(&status, &image) })
    }

    pub(super) fn print_events(&mut self) -> Result<(), Error> {
        let mut text = String::new();
        for back in 0..KEPT as u8 {
            let outcome = self.connection.event(back);
            let Some(event) = self.known(outcome)? else { break };
            text += &status::event(&event);
        }
        output::print(if text.is_empty() { "no faults\n" } else { &text })
    }

    pub(super) fn enable(&mut self, autonomous: bool) -> Result<(), Error> {
        self.tell_until(Command::Enable { autonomous }, "running", |status| status.state == RUNNING)
    }

    /// The axis is braked to rest first, which takes up to stop_time_s.
    pub(super) fn disable(&mut self) -> Result<(), Error> {
        self.tell_until(Command::Disable, "stopped", |status| ![RUNNING, STOPPING].contains(&status.state))
    }

    /// Keeps the link alive as long as that was asked for, and stops the drive then; or leaves it running alone.
    pub(super) fn stay(&mut self, stay: &Stay) -> Result<(), Error> {
        if stay.autonomous {
            return Ok(());
        }
        self.beat(stay.duration_s)?;
        self.disable()
    }

    /// Keeps the link alive for a time, or until Ctrl-C.
    pub(super) fn beat(&mut self, duration: Option<Duration>) -> Result<Status, Error> {
        let interrupt = Interrupt::watch()?;
        let start = Instant::now();
        loop {
            let status = self.status()?;
            if status.state != RUNNING {
                return Err(self.refused("the reference is not followed", &status));
            }
            if interrupt.is_raised() || duration.is_some_and(|duration| start.elapsed() >= duration) {
                return Ok(status);
            }
            // What is recorded comes in meanwhile.
            let outcome = self.connection.listen_for(BEAT);
            self.known(outcome)?;
        }
    }

    pub(super) fn reference(&mut self, command: Command, stay: &Stay) -> Result<(), Error> {
        self.tell(command)?;
        if stay.autonomous {
            return self.tell(Command::Hold { autonomous: true });
        }
        let status = self.beat(stay.duration_s)?;
        let (at, to) = (Counts(status.position).to_rad(), Counts(status.reference).to_rad());
        output::print(&format!("reference {to:.6} rad, position {at:.6} rad\n"))?;
        self.disable()
    }

    pub(super) fn run(&mut self, run: &Run) -> Result<(), Error> {
        let outcome = self.connection.parameter("period_s");
        let experiment = run.shape.experiment(self.known(outcome)?)?;
        if run.enable {
            self.enable(false)?;
        }
        self.tell(Command::Run { experiment, torque_bound_nm: run.max_torque_nm, autonomous: run.autonomous })?;
        output::print(&format!("runs for {} s\n", experiment.duration_s))?;
        if !run.autonomous {
            self.beat(Some(Duration::from_secs_f32(experiment.duration_s)))?;
        }
        if run.enable { self.disable() } else { Ok(()) }
    }

    /// Runs it, and writes the recording whatever becomes of it.
    pub(super) fn run_recorded(&mut self, run: &Run, out: Growing) -> Result<(), Error> {
        let recording = OverLink::start(&self.line, &mut self.connection, 1, out)?;
        let outcome = self.run(run);
        let summary = recording.end(&mut self.connection)?;
        eprintln!("{summary}");
        note_parameters(&summary.begin.config);
        let file = run.record.as_deref().unwrap_or(std::path::Path::new("")).display().to_string();
        output::print(&format!("wrote {file}: {} rows\n", summary.ticks.taken))?;
        outcome
    }

    pub(super) fn get(&mut self, names: &[String]) -> Result<(), Error> {
        let outcome = self.connection.config();
        let config = self.known(outcome)?;
        let is_asked = |parameter: &&Parameter| names.is_empty() || names.iter().any(|name| name == parameter.name);
        let line = |parameter: &Parameter| parameter_line(parameter, &config) + "\n";
        output::print(&TABLE.iter().filter(is_asked).map(line).collect::<String>())
    }

    pub(super) fn set(&mut self, values: &[Assignment], force: bool) -> Result<(), Error> {
        let outcome = self.connection.set_parameters(values, force);
        self.known(outcome)
    }
}
