//! Logs of several joints (or runs): columns that share a name before their last dot, `/joint_states.elbow.position`.

use super::nearest::{misspelt, quoted};
use super::{Column, MapFlag, Table};

/// What stands before the last dot of a name.
fn before(name: &str) -> Option<&str> {
    name.rsplit_once('.').map(|(before, _)| before)
}

/// The joints of a log that have a position and an effort, and the one that is wanted.
pub(crate) struct Joints<'a> {
    /// Names before the last dot, in the order of the log.
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
            let Some(joint) = before(name).filter(|joint| !all.contains(joint)) else { continue };
            let of_joint = names().filter(|name| before(name) == Some(joint));
            if of_joint.into_iter().any(|name| fits(name, Column::EffortCmd) || fits(name, Column::EffortMeas)) {
                all.push(joint);
            }
        }
        let mut joints = Self { all, wanted: None };
        joints.wanted = match wanted {
            Some(wanted) => Some(joints.named(wanted)?),
            None => flags
                .iter()
                .filter_map(|flag| before(table.column(&flag.name)?.0))
                .find(|joint| joints.all.contains(joint)),
        };
        if joints.wanted.is_none() && joints.all.len() > 1 {
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
        let is =
            |joint: &&str| Some(*joint) != self.wanted && name.strip_prefix(joint).is_some_and(|n| n.starts_with('.'));
        self.wanted.is_some() && self.all.iter().any(is)
    }
}
