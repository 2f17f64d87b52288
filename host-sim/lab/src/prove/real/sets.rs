//! The real machines: which recordings, which nominal models, what is hidden from each, and what is known of it.

use crate::read::{EffectEntry, Machine};

/// A value known from elsewhere: effect, parameter, value, source. A range where two sources differ.
pub(crate) type Known = (&'static str, &'static str, [f64; 2], &'static str);

/// One nominal model of one machine.
pub(crate) struct Model {
    /// Folder of the set.
    pub(crate) folder: &'static str,
    /// Recordings of the machine; each is held out once.
    pub(crate) recordings: &'static [&'static str],
    /// Machine file.
    pub(crate) file: &'static str,
    /// What is hidden, in words.
    pub(crate) hidden: &'static str,
    /// What is put into the file's model, or taken out.
    pub(crate) edit: fn(&mut Machine),
    /// What is to be found.
    pub(crate) known: &'static [Known],
}

const JANOT: &str = "Janot, Gautier, Brunot 2019";
const WEIGAND: &str = "published";
const FIT: &str = "least squares of the data's authors";
const MASS: &str = "mass and length, or least squares";
const MAP: &str = "two maps of the holding torque";

/// The published offset stands on the side of the drag; the tool's on that of the drive.
const OFFSET: Known = ("torque_offset", "offset_n", [3.165, 3.165], JANOT);
const COULOMB: Known = ("coulomb_friction", "coulomb_n", [20.39, 20.39], JANOT);
const VISCOUS: Known = ("viscous_friction", "viscous_n_s_m", [203.5034, 203.5034], JANOT);
const EMPS: &[&str] = &["train.csv", "pulses.csv"];
const MOTOR: &[&str] = &["slow2_nocomp_0.csv", "slow2_nocomp_1.csv", "slow2_nocomp_2.csv", "slow2_slower_nocomp_0.csv"];
const COMPENSATED: &[&str] = &["slow2_comp_0.csv", "slow2_slower_comp_0.csv"];
const PENDULUM: &[&str] = &["ddp.csv", "dircol.csv", "ilqr.csv", "energy.csv"];
const COGGING: &[Known] = &[
    ("cogging", "order_per_rev", [7.0, 7.0], MAP),
    ("cogging", "order_per_rev", [28.0, 28.0], MAP),
    ("cogging", "order_per_rev", [14.0, 14.0], MAP),
];
const GRAVITY: Known = ("gravity_load", "amplitude_nm", [3.1, 3.31], MASS);
const SWING_COULOMB: Known = ("coulomb_friction", "coulomb_nm", [0.2, 0.2], FIT);
const SWING_VISCOUS: Known = ("viscous_friction", "viscous_nm_s_rad", [0.03, 0.03], FIT);
const FIRST: &[&str] = &["j1_A.csv", "j1_B.csv", "j1_C.csv"];
const SIXTH: &[&str] = &["j6_A.csv", "j6_B.csv", "j6_C.csv"];
const FIRST_COULOMB: Known = ("coulomb_friction", "coulomb_nm", [355.495, 355.495], WEIGAND);
const FIRST_VISCOUS: Known = ("viscous_friction", "viscous_nm_s_rad", [2050.35, 2050.35], WEIGAND);
const FIRST_OFFSET: Known = ("torque_offset", "offset_nm", [-54.024, -54.024], WEIGAND);
const SIXTH_OFFSET: Known = ("torque_offset", "offset_nm", [-0.3674, -0.3674], WEIGAND);
const SIXTH_COULOMB: Known = ("coulomb_friction", "coulomb_nm", [76.129, 76.129], WEIGAND);
const SIXTH_VISCOUS: Known = ("viscous_friction", "viscous_nm_s_rad", [458.8, 458.8], WEIGAND);

fn as_filed(_: &mut Machine) {}

fn emps(machine: &mut Machine, coulomb: f64, viscous: f64, offset: f64) {
    let plant = &mut machine.plant;
    (plant.coulomb, plant.viscous, plant.torque_offset) = (coulomb, viscous, offset);
}

/// Order, amplitude, N m, and phase of the torque that `map_a_4.csv` holds, position by position: sines of a least-squares fit, turned by
/// half a turn, for what is held is against the cogging, and by the 16 counts that the slow runs are behind the map.
const MAPPED: [[f64; 3]; 5] = [
    [7.0, 0.0475, 2.757],
    [28.0, 0.0309, -2.967],
    [14.0, 0.0192, -0.115],
    [36.0, 0.0160, -0.052],
    [12.0, 0.0145, -0.635],
];

fn mapped(machine: &mut Machine) {
    let entry = |[order, amplitude, phase]: [f64; 3]| EffectEntry {
        id: "cogging".to_owned(),
        recording: None,
        parameters: [("amplitude_nm", amplitude), ("order_per_rev", order), ("phase_rad", phase)]
            .map(|(id, value)| (id.to_owned(), value))
            .to_vec(),
    };
    machine.effects.extend(MAPPED.map(entry));
}

const fn filed(
    folder: &'static str,
    recordings: &'static [&'static str],
    file: &'static str,
    hidden: &'static str,
    known: &'static [Known],
) -> Model {
    Model { folder, recordings, file, hidden, edit: as_filed, known }
}

/// As filed with something put in or taken out.
const fn edited(model: Model, edit: fn(&mut Machine)) -> Model {
    Model { edit, ..model }
}

const fn of_emps(hidden: &'static str, edit: fn(&mut Machine), known: &'static [Known]) -> Model {
    edited(filed("emps", EMPS, "machine.toml", hidden, known), edit)
}

const fn of_pendulum(hidden: &'static str, edit: fn(&mut Machine), known: &'static [Known]) -> Model {
    edited(filed("dfki", PENDULUM, "heavy_full.toml", hidden, known), edit)
}

const fn of_first(hidden: &'static str, edit: fn(&mut Machine), known: &'static [Known]) -> Model {
    edited(filed("weigand", FIRST, "j1_full.toml", hidden, known), edit)
}

const fn of_sixth(hidden: &'static str, edit: fn(&mut Machine), known: &'static [Known]) -> Model {
    edited(filed("weigand", SIXTH, "j6_full.toml", hidden, known), edit)
}

fn no_coulomb(machine: &mut Machine) {
    machine.plant.coulomb = 0.0;
}

fn no_viscous(machine: &mut Machine) {
    machine.plant.viscous = 0.0;
}

fn no_offset(machine: &mut Machine) {
    machine.plant.torque_offset = 0.0;
}

/// Every model: each known effect hidden in turn, all of them, and none.
pub(crate) static MODELS: &[Model] = &[
    of_emps("nothing", |m| emps(m, 20.39, 203.5034, 3.165), &[]),
    filed("emps", EMPS, "machine.toml", "dry friction, offset", &[COULOMB, OFFSET]),
    of_emps("dry friction", |m| emps(m, 0.0, 203.5034, 3.165), &[COULOMB]),
    of_emps("viscous friction", |m| emps(m, 20.39, 0.0, 3.165), &[VISCOUS]),
    of_emps("offset", |m| emps(m, 20.39, 203.5034, 0.0), &[OFFSET]),
    edited(filed("odrive_cogging", MOTOR, "machine.toml", "nothing", &[]), mapped),
    filed("odrive_cogging", MOTOR, "machine.toml", "cogging", COGGING),
    filed("odrive_cogging", COMPENSATED, "machine.toml", "cogging, under compensation", COGGING),
    filed("dfki", PENDULUM, "heavy_full.toml", "nothing", &[]),
    filed("dfki", PENDULUM, "heavy_no_gravity.toml", "gravity", &[GRAVITY]),
    filed("dfki", PENDULUM, "heavy_no_friction.toml", "friction", &[SWING_COULOMB, SWING_VISCOUS]),
    of_pendulum("dry friction", no_coulomb, &[SWING_COULOMB]),
    of_pendulum("viscous friction", no_viscous, &[SWING_VISCOUS]),
    filed("dfki", PENDULUM, "heavy_none.toml", "gravity, friction", &[GRAVITY, SWING_COULOMB, SWING_VISCOUS]),
    filed("weigand", FIRST, "j1_full.toml", "nothing", &[]),
    filed("weigand", FIRST, "j1_no_coulomb.toml", "dry friction", &[FIRST_COULOMB]),
    of_first("viscous friction", no_viscous, &[FIRST_VISCOUS]),
    of_first("offset", no_offset, &[FIRST_OFFSET]),
    filed("weigand", FIRST, "j1_no_friction.toml", "friction, offset", &[FIRST_VISCOUS, FIRST_COULOMB]),
    filed("weigand", SIXTH, "j6_full.toml", "nothing", &[]),
    filed("weigand", SIXTH, "j6_no_coulomb.toml", "dry friction", &[SIXTH_COULOMB]),
    of_sixth("viscous friction", no_viscous, &[SIXTH_VISCOUS]),
    of_sixth("offset", no_offset, &[SIXTH_OFFSET]),
    filed("weigand", SIXTH, "j6_no_friction.toml", "friction, offset", &[SIXTH_VISCOUS, SIXTH_COULOMB]),
];

impl Model {
    /// As in tables.
    pub(crate) fn name(&self) -> String {
        format!("{}/{}", self.folder, self.file.trim_end_matches(".toml"))
    }
}
