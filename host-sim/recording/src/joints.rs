//! Logs of several joints (or runs): columns that share a name before their last dot, `/joint_states.elbow.position`, a number,
//! `Position2` and `actual_q_2` and `run.q[2]`, or what stands beside the quantity, `a1 position [rad]` and `effort_left_knee`.

use super::nearest::{misspelt, quoted};
use super::words::besides_quantity;
use super::{Column, MapFlag, Table, units};

/// The array that a name is of, and the number of its member: of `run.q[2]` both; none where it is of no array.
pub(crate) fn member(name: &str) -> Option<(&str, &str)> {
    let (array, bracket) = name.split_once('[')?;
    let number = bracket.strip_suffix(']')?;
    let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then_some((array, number))
}

/// What of a name tells the joint.
fn joint_of(name: &str) -> Option<&str> {
    if let Some((_, number)) = member(name) {
        return Some(number);
    }
    if let Some((before, _)) = name.rsplit_once('.') {
        return Some(before);
    }
    let plain = units::stem(name);
    let stem = plain.trim_end_matches(|letter: char| letter.is_ascii_digit());
    if !stem.is_empty() && stem.len() < plain.len() {
        return Some(&plain[stem.len()..]);
    }
    besides_quantity(name)
}

/// The joints of a log that have a position and an effort, and the one that is wanted.
pub(crate) struct Joints<'a> {
    /// What tells each in the names of its columns, in the order of the log.
    all: Vec<&'a str>,
    wanted: Option<&'a str>,
}

impl<'a> Joints<'a> {
    /// The joints of `table`, where `fits` tells whether a name is one of a column; `wanted` by its name or by the end of it, else
    /// the one that the flags name columns of.
    ///
    /// # Errors
    /// A sentence: there are several, and nothing tells which is meant; there is none of this name.
    pub(crate) fn of(
        table: &'a Table,
        fits: impl Fn(&str, Column) -> bool,
        wanted: Option<&str>,
        flags: &[MapFlag],
    ) -> Result<Self, String> {
        let names = || table.numbers.iter().map(|(name, _)| name.as_str());
        let mut all: Vec<&str> = Vec::new();
        for name in names().filter(|name| fits(name, Column::Position)) {
            let Some(joint) = joint_of(name).filter(|joint| !all.contains(joint)) else { continue };
            let of_joint = names().filter(|name| joint_of(name) == Some(joint));
            if of_joint.into_iter().any(|name| fits(name, Column::EffortCmd) || fits(name, Column::EffortMeas)) {
                all.push(joint);
            }
        }
        let mut joints = Self { all, wanted: None };
        joints.wanted = match wanted {
            Some(wanted) => Some(joints.named(wanted)?),
            None => flags
                .iter()
                .filter_map(|flag| joint_of(table.column(&flag.name)?.0))
                .find(|joint| joints.all.contains(joint)),
        };
        let given = |column| flags.iter().any(|flag| flag.column == column);
        let all_given = given(Column::Position) && given(Column::EffortCmd);
        if joints.wanted.is_none() && joints.all.len() > 1 && !all_given {
            let count = joints.all.len();
            return Err(format!(
                "the log has {count} joints (or runs), and a machine file is of one; give --joint with one of {}",
                joints.list()
            ));
        }
        Ok(joints)
    }

    fn named(&self, wanted: &str) -> Result<&'a str, String> {
        let found = self.all.iter().find(|joint| **joint == wanted || self.short(joint) == wanted);
        found.copied().ok_or_else(|| {
            let near = misspelt(wanted, self.all.iter().map(|joint| self.short(joint)));
            let near = near.map_or_else(String::new, |near| format!("; is {} meant?", quoted(near)));
            let has = if self.all.is_empty() { "no joints".to_owned() } else { self.list() };
            format!("--joint {wanted}: there is no such joint; the log has {has}{near}")
        })
    }

    fn list(&self) -> String {
        self.all.iter().map(|joint| quoted(self.short(joint))).collect::<Vec<_>>().join(", ")
    }

    /// The name without its topic, where that tells it from the others.
    fn short(&self, joint: &'a str) -> &'a str {
        let last = |name: &'a str| name.rsplit_once('.').map_or(name, |(_, last)| last);
        let alike = self.all.iter().filter(|other| last(other) == last(joint)).count();
        if alike == 1 { last(joint) } else { joint }
    }

    /// Whether the column is of another joint than the wanted one.
    pub(crate) fn is_of_another(&self, name: &str) -> bool {
        let own = joint_of(name);
        let is = |joint: &&str| {
            let below = name.strip_prefix(joint).is_some_and(|rest| rest.starts_with('.'));
            Some(*joint) != self.wanted && (own == Some(*joint) || below)
        };
        self.wanted.is_some() && self.all.iter().any(is)
    }
}

#[cfg(test)]
mod tests {
    use super::joint_of;

    #[test]
    fn names_tell_the_joint_they_are_of() {
        for (name, joint) in [
            ("/joint_states.elbow.position", Some("/joint_states.elbow")),
            ("Position12", Some("12")),
            ("actual_q_0", Some("0")),
            ("tau 3 [N m]", Some("3")),
            ("run.q[2]", Some("2")),
            ("a1 position [rad]", Some("a1")),
            ("J2_pos", Some("J2")),
            ("arm_1_joint_position", Some("arm_1_joint")),
            ("cmd_effort_left_knee_nm", Some("left_knee")),
            ("pos_x", Some("x")),
            ("x_position", Some("x")),
            ("KneeTorque", Some("Knee")),
            ("actual_position_rad", None),
            ("position [rad]", None),
            ("Time (s)", None),
            ("2", None),
            ("t", None),
            ("", None),
        ] {
            assert_eq!(joint_of(name), joint, "{name}");
        }
    }
}
