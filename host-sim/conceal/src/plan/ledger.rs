//! Which families outside the vocabulary a round draws, and which were tuned beside.

use rand::SeedableRng;
use rand::rngs::StdRng;
use rand::seq::SliceRandom;

use super::ROUND;
use crate::Error;
use crate::outside::{self, Kind};

/// Seeds below are for tuning.
pub const TUNING: u64 = 10_000;
/// Families outside the vocabulary in a round.
const FAMILIES: usize = 6;

/// Families outside the vocabulary that the tool was tuned beside or a scored round has drawn, and since when. They are never scored as
/// unseen again: a family is added here with the round that drew it, or as soon as one case of it has been looked into.
pub const LEDGER: [(&str, &str); 79] = [
    ("friction over position", "friction_over_position, round 20000 of the fixed plan"),
    ("friction over load", "friction_by_load, round 20000 of the fixed plan"),
    ("friction over rest", "stiction_by_rest, round 20000 of the fixed plan"),
    ("springs that harden", "nonlinear_spring, round 20000 of the fixed plan"),
    ("torque hysteresis", "torque_memory, round 20000 of the fixed plan"),
    ("torque curve", "magnetic_saturation, round 20000 of the fixed plan"),
    ("changing inertia", "load_change, round 20000 of the fixed plan"),
    ("fluid hysteresis", "warmth_with_hysteresis, round 20000 of the fixed plan"),
    ("fluid memory", "field_leakage, round 20000 of the fixed plan"),
    ("friction over temperature", "dry_friction_warms, round 200000 of the drawn plan"),
    ("friction over time", "run_in, round 200000 of the drawn plan"),
    ("friction over speed", "root_drag, round 200000 of the drawn plan"),
    ("springs with memory", "creeping_spring, round 200000 of the drawn plan"),
    ("torque ripple", "torque_ripple, round 200000 of the drawn plan"),
    ("several loads", "slipping_load, round 200000 of the drawn plan"),
    ("fluid over angle and shear", "eccentric_gap, seeds 205000 to 205149 of the drawn plan"),
    ("torque over supply", "gain_fades, round 210000 of the drawn plan"),
    ("sensor nonlinearity", "bent_scale, round 210000 of the drawn plan"),
    ("loads that drift", "stiffening_hose, seed 210013 on a newer generator"),
    ("sensor over time", "clock_beat, seed 210005 on a newer generator"),
    ("rolling hysteresis", "wedged_balls, round 230000 of the drawn plan"),
    ("torque over angle and speed", "uneven_film, round 230000 of the drawn plan"),
    ("drive in steps", "torque_steps, round 230000 of the drawn plan"),
    ("load that follows", "stirred_fill, round 230000 of the drawn plan"),
    ("fluid over direction", "overshoot_at_turns, round 230000 of the drawn plan"),
    ("drive over speed", "eddy_brake, round 230000 of the drawn plan"),
    ("friction over the track", "stroke_ridges, round 240000 of the drawn plan"),
    ("friction when driven", "load_brake, round 240000 of the drawn plan"),
    ("torque through filters", "ringing_torque, round 240000 of the drawn plan"),
    ("swings with the clock", "pulsing_seal, round 240000 of the drawn plan"),
    ("orders that slip", "creeping_belt, round 240000 of the drawn plan"),
    ("fluid over acceleration", "bound_fluid, round 240000 of the drawn plan"),
    ("friction over angle and load", "eccentric_mesh, round 250000 of the drawn plan"),
    ("waves in lines", "held_line, round 250000 of the drawn plan"),
    ("pressure that leaks", "soft_damper, round 250000 of the drawn plan"),
    ("torque over angle and current", "reluctance_torque, round 250000 of the drawn plan"),
    ("converter that switches", "mains_firing, round 250000 of the drawn plan"),
    ("field in bursts", "arcs, round 250000 of the drawn plan"),
    ("torque that needs a flux", "flux_builds, round 260000 of the drawn plan"),
    ("ranges that switch", "two_ranges, round 260000 of the drawn plan"),
    ("two states over speed", "bearing_lifts_off, round 260000 of the drawn plan"),
    ("particles that migrate", "spun_out, round 260000 of the drawn plan"),
    ("fluid over strain", "chains_outlast, round 260000 of the drawn plan"),
    ("sensor that loses way", "counts_lost, round 260000 of the drawn plan"),
    ("axes beside this one", "rolling_ship, round 270000 of the drawn plan"),
    ("drive that protects itself", "bus_fills, round 270000 of the drawn plan"),
    ("friction over acceleration", "inertia_brake, round 270000 of the drawn plan"),
    ("here and there by chance", "chips_in_guide, round 270000 of the drawn plan"),
    ("loads taken one way", "chain_picked_up, round 270000 of the drawn plan"),
    ("sensor over angle and speed", "speed_voltages, round 270000 of the drawn plan"),
    ("sensor that falls behind", "tracking_converter, round 280000 of the drawn plan"),
    ("scale in pieces", "butted_scales, round 280000 of the drawn plan"),
    ("load that rearranges", "cargo_slides, round 280000 of the drawn plan"),
    ("field and shear together", "rings_form, round 280000 of the drawn plan"),
    ("orders that meet a resonance", "chattering_guide, round 280000 of the drawn plan"),
    ("gyroscopes", "gimbal_stops, round 280000 of the drawn plan"),
    ("sensor that warms", "bracket_warps, round 290000 of the drawn plan"),
    ("sensor under load", "column_bends, round 290000 of the drawn plan"),
    ("sensor that speaks now and then", "dead_reckoning, round 290000 of the drawn plan"),
    ("drive that adds its own", "disturbance_observer, round 290000 of the drawn plan"),
    ("friction over load and speed", "flash_heat, round 290000 of the drawn plan"),
    ("force over the stator", "short_coil, round 290000 of the drawn plan"),
    ("springs that snap", "buckled_strip, seeds 290000 once more after 290000 was in the ledger"),
    ("wind on the axis", "galloping_prism, seeds 290000 once more"),
    ("half orders", "liquid_layer, seeds 290000 once more"),
    ("mass that comes and goes", "hopper_fills, seeds 290000 once more"),
    ("commutation that is late", "hall_hysteresis, seeds 290000 once more"),
    ("resonance that moves", "cracked_shaft, seeds 290000 once more"),
    ("a drive without torque", "holding_brake, first half of round 300000 of the drawn plan"),
    ("a base that moves", "raft_turns, first half of round 300000"),
    ("stamps that wander", "two_routes, first half of round 300000"),
    ("readings that are smoothed", "slewed_reading, first half of round 300000"),
    ("valves that stick", "no miss, first half of round 300000"),
    ("springs that lose work", "first half of round 310000, not looked into"),
    ("what comes and goes by itself", "first half of round 310000, not looked into"),
    ("tones that a motion starts", "first half of round 310000, not looked into"),
    ("couplings that skip", "first half of round 310000, not looked into"),
    ("torque that rises otherwise than it falls", "first half of round 310000, not looked into"),
    ("commands that come late", "first half of round 310000, not looked into"),
];

/// Families of a round: of those in the ledger below [`TUNING`], of the others from there on.
///
/// # Errors
/// No family is left that was never used.
pub fn families_of(seed: u64) -> Result<Vec<&'static str>, Error> {
    let used = |family: &&str| LEDGER.iter().any(|(known, _)| known == family);
    let tuning = seed < TUNING;
    let families = drawn(outside::families().into_iter().filter(|one| used(one) == tuning).collect(), seed);
    if families.is_empty() { Err(Error::NoFamily) } else { Ok(families) }
}

/// Those that a round takes of some families.
fn drawn(mut families: Vec<&'static str>, seed: u64) -> Vec<&'static str> {
    families.shuffle(&mut StdRng::seed_from_u64(seed / ROUND));
    families.truncate(FAMILIES);
    families
}

/// Kinds of these families.
pub(crate) fn kinds_of(families: &[&'static str]) -> Vec<&'static Kind> {
    outside::kinds().filter(|kind| families.contains(&kind.family)).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::catalogue::ENTRIES;

    #[test]
    fn a_family_in_the_ledger_is_never_scored_again() {
        let known: Vec<&str> = LEDGER.iter().map(|(family, _)| *family).collect();
        assert!(known.iter().all(|family| outside::families().contains(family)));
        for round in 0..200 {
            let families = families_of(round * ROUND).unwrap();
            let tuning = round * ROUND < TUNING;
            assert!(families.iter().all(|family| known.contains(family) == tuning), "{round}: {families:?}");
            assert_eq!(families, families_of(round * ROUND + 7).unwrap());
        }
        assert_ne!(drawn(outside::families(), 50 * ROUND), drawn(outside::families(), 51 * ROUND));
        // Every kind that was in the fixed plan is of a family in the ledger.
        for entry in ENTRIES.iter().filter(|entry| !entry.in_vocabulary) {
            assert!(known.contains(&outside::find(entry.id).unwrap().family), "{}", entry.id);
        }
    }

    /// A results file is written to be looked into: its misses tell kinds by name.
    #[test]
    fn every_kind_outside_in_a_committed_result_is_of_a_family_in_the_ledger() {
        let folder = std::fs::read_dir(env!("CARGO_MANIFEST_DIR")).unwrap().map(|file| file.unwrap().path());
        let is_result = |file: &std::path::PathBuf| {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            name.starts_with("RESULTS") && name.ends_with(".md")
        };
        let mut told = std::collections::BTreeSet::new();
        for file in folder.filter(is_result) {
            let text = std::fs::read_to_string(&file).unwrap();
            let words = text.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
            told.extend(words.filter_map(outside::find).map(|kind| (kind.family, kind.id)));
        }
        println!("{told:?}");
        assert!(told.len() >= 15, "{told:?}");
        for (family, kind) in told {
            assert!(LEDGER.iter().any(|(known, _)| *known == family), "{kind}: {family} is not in the ledger");
        }
    }
}
