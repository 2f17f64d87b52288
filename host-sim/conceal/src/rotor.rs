//! Moreau's midpoint time stepping of the rotor (J. J. Moreau, "Unilateral contact and dry friction in finite freedom
//! dynamics", 1988): angles at the middle of a step, speeds by the impulse of the whole step, friction an impulse from a
//! set, so that rest is exact.

use std::f64::consts::TAU;

use crate::drive::Drive;
use crate::fluid::Fluid;
use crate::friction::{Friction, Yield};
use crate::outside::{Hidden, Hiding, Seen};
use crate::physics::Physics;
use crate::shaft::Shaft;

/// Step of every recording, s: 200 in a control period.
pub const STEP_S: f64 = 2.5e-6;

/// What is held over a control period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Command {
    /// N m.
    pub torque_nm: f64,
    /// kV/mm.
    pub field_kv_mm: f64,
    /// The field brakes; only a delayed viscosity makes a difference.
    pub braking: bool,
    /// The controller's speed, rad/s; only for a delayed viscosity.
    pub speed_rad_s: f64,
    /// The wanted coefficient itself, N m s/rad, where it is known; else it is that of the commanded field and speed.
    pub viscosity_nm_s_rad: Option<f64>,
    /// From outside, N m.
    pub external_nm: f64,
}

/// The machine in motion.
pub struct Rotor {
    physics: Physics,
    step_s: f64,
    steps: u64,
    position_rad: f64,
    speed_rad_s: f64,
    drive: Drive,
    fluid: Fluid,
    friction: Friction,
    preyield: Option<Yield>,
    shaft: Option<Shaft>,
    hidden: Option<Box<dyn Hidden>>,
    drive_nm: f64,
}

impl Rotor {
    /// At rest at zero, with a step, s.
    pub fn new(physics: &Physics, step_s: f64) -> Self {
        Self {
            step_s,
            steps: 0,
            position_rad: 0.0,
            speed_rad_s: 0.0,
            drive: Drive::new(&physics.drive, step_s),
            fluid: Fluid::new(&physics.fluid, step_s),
            friction: Friction::new(&physics.friction, step_s),
            preyield: physics.fluid.preyield_nm_rad.map(Yield::new),
            shaft: physics.shaft.as_ref().map(Shaft::new),
            hidden: physics.hidden.as_ref().and_then(Hiding::begin),
            drive_nm: 0.0,
            physics: physics.clone(),
        }
    }

    /// rad.
    pub fn position_rad(&self) -> f64 {
        self.position_rad
    }

    /// rad/s.
    pub fn speed_rad_s(&self) -> f64 {
        self.speed_rad_s
    }

    /// Since the start, s.
    pub fn now_s(&self) -> f64 {
        self.steps as f64 * self.step_s
    }

    /// Puts the axis somewhere else, rad, at another speed, rad/s; what the drive, the fluid and the friction remember stays.
    pub fn place(&mut self, position_rad: f64, speed_rad_s: f64) {
        (self.position_rad, self.speed_rad_s) = (position_rad, speed_rad_s);
    }

    /// Torque that the drive had at the last step, N m.
    pub fn drive_nm(&self) -> f64 {
        self.drive_nm
    }

    /// One step under a command.
    // Over 40 lines: one place after another where the step's impulses come from.
    pub fn step(&mut self, command: &Command) {
        let (h, t_s) = (self.step_s, self.now_s());
        let middle_rad = self.position_rad + 0.5 * h * self.speed_rad_s;
        let inertia = self.inertia_kg_m2(t_s);
        let mut command = *command;
        let mut drive_nm = self.drive.pass(command.torque_nm, middle_rad);
        let mut seen = Seen { t_s, step_s: h, position: middle_rad, speed: self.speed_rad_s, drive: drive_nm };
        if let Some(hidden) = &mut self.hidden {
            drive_nm = hidden.drive(&seen, drive_nm);
            command.field_kv_mm = hidden.field(command.field_kv_mm);
            seen.drive = drive_nm;
        }
        self.drive_nm = drive_nm;
        let mut drag = self.fluid.pass(&command, t_s, self.speed_rad_s);
        let mut bounds = self.friction.bounds(middle_rad, self.speed_rad_s, drive_nm);
        let mut torque_nm = drive_nm + command.external_nm + self.outside_nm(middle_rad, t_s + 0.5 * h);
        let mut moved = inertia;
        if let Some(hidden) = &mut self.hidden {
            drag.level_nm = hidden.drag(&seen, drag.level_nm);
            let rub = hidden.friction(&seen);
            bounds.level_nm = bounds.level_nm.map(|level| (level * rub.share + rub.level).max(0.0));
            bounds.viscous_nm_s_rad += rub.viscous;
            torque_nm += hidden.torque(&seen);
            moved *= hidden.inertia(&seen);
        }
        torque_nm -= bounds.known_nm;
        let mut known_nm = bounds.known_nm;
        let [mut forward_nm, mut backward_nm] = bounds.level_nm;
        match &mut self.preyield {
            Some(fluid) => {
                let held_nm = fluid.pass(h * self.speed_rad_s, drag.level_nm);
                torque_nm -= held_nm;
                known_nm += held_nm;
            }
            None => (forward_nm, backward_nm) = (forward_nm + drag.level_nm, backward_nm + drag.level_nm),
        }
        let mut viscous = bounds.viscous_nm_s_rad;
        if drag.viscosity_nm_s_rad * self.speed_rad_s.abs() > drag.viscous_limit_nm {
            (forward_nm, backward_nm) = (forward_nm + drag.viscous_limit_nm, backward_nm + drag.viscous_limit_nm);
        } else {
            viscous += drag.viscosity_nm_s_rad;
        }
        if let Some(shaft) = &mut self.shaft {
            torque_nm += shaft.pass(middle_rad, self.speed_rad_s, inertia, h);
            moved *= shaft.motor_share;
        }
        // The speed without friction tells which way friction pushes; it takes what stops the rotor, and no more.
        let free = self.speed_rad_s + h * torque_nm / moved;
        let level_nm = if free > 0.0 { forward_nm } else { backward_nm };
        let most = h / moved * level_nm;
        let next = if free.abs() <= most { 0.0 } else { (free - free.signum() * most) / (1.0 + h * viscous / moved) };
        self.friction.warm((level_nm + viscous * next.abs()) * next.abs() + known_nm * next);
        self.position_rad = middle_rad + 0.5 * h * next;
        self.speed_rad_s = next;
        self.steps += 1;
    }

    fn inertia_kg_m2(&self, t_s: f64) -> f64 {
        match self.physics.load_change {
            Some((from_s, inertia)) if t_s >= from_s => inertia,
            _ => self.physics.inertia_kg_m2,
        }
    }

    /// Torques of angle and time, N m.
    fn outside_nm(&self, position_rad: f64, t_s: f64) -> f64 {
        let physics = &self.physics;
        let mut torque_nm = -physics.spring_nm_rad * position_rad - physics.cubic_spring_nm_rad3 * position_rad.powi(3);
        for wave in physics.cogging.iter().chain(&physics.ripple) {
            torque_nm += wave.at(position_rad);
        }
        if let Some((amplitude, phase)) = physics.gravity {
            torque_nm -= amplitude * (position_rad + phase).sin();
        }
        if let Some((hz, amplitude, phase)) = physics.vibration {
            torque_nm += amplitude * (TAU * hz * t_s + phase).sin();
        }
        if let Some(pulse) = physics.pulse
            && t_s >= pulse.start_s
            && t_s < pulse.start_s + pulse.duration_s
        {
            torque_nm += pulse.amplitude_nm;
        }
        torque_nm
    }
}
