//! What a `--map` flag says of a column of a log.

use super::nearest::{misspelt, quoted};
use super::{AxisKind, Column};

/// A `--map` flag taken apart: `torque=i:A*0.12`.
#[derive(Debug, Clone, PartialEq)]
pub struct MapFlag {
    /// Key of `[columns]`, of either kind of axis: an effort may be called `torque` or `force` on both.
    pub key: String,
    /// The column that it means.
    pub column: Column,
    /// Name in the log.
    pub name: String,
    /// Unit; empty where none is given.
    pub unit: String,
    /// Factor on top of the unit.
    pub scale: Option<f64>,
}

impl std::str::FromStr for MapFlag {
    type Err = String;

    /// `KEY=NAME`, `KEY=NAME:UNIT`, `KEY=NAME:UNIT*SCALE`, `KEY=NAME:*SCALE`; a name may hold colons where a unit follows.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = "must be KEY=NAME, KEY=NAME:UNIT or KEY=NAME:UNIT*SCALE, such as torque=i:A*0.12";
        let (key, rest) = text.split_once('=').ok_or_else(|| form.to_owned())?;
        let (key, rest) = (key.trim(), rest.trim());
        let column = column(key)?;
        let (name, unit, scale) = match rest.rsplit_once(':') {
            None => (rest, "", None),
            Some((name, after)) => {
                let (unit, scale) = after.split_once('*').map_or((after, None), |(unit, scale)| (unit, Some(scale)));
                (name, unit, scale)
            }
        };
        if name.trim().is_empty() {
            return Err(format!("no name of a column; {form}"));
        }
        let scale = scale.map(|scale| {
            scale.trim().parse::<f64>().map_err(|_| format!("scale {} is not a number; {form}", quoted(scale)))
        });
        Ok(Self {
            key: key.to_owned(),
            column,
            name: name.trim().to_owned(),
            unit: unit.trim().to_owned(),
            scale: scale.transpose()?,
        })
    }
}

/// The column that a key means on one kind of axis or the other.
fn column(key: &str) -> Result<Column, String> {
    let keys = |column: Column| AxisKind::ALL.map(|axis| column.key(axis));
    if let Some(column) = Column::ALL.into_iter().find(|column| keys(*column).contains(&key)) {
        return Ok(column);
    }
    let mut known: Vec<&str> = Vec::new();
    for key in Column::ALL.into_iter().flat_map(keys) {
        if !known.contains(&key) {
            known.push(key);
        }
    }
    let near = misspelt(key, known.iter().copied());
    let hint = near.map_or_else(|| format!("known are {}", known.join(", ")), |near| format!("is `{near}` meant?"));
    Err(format!("{} is not a column of a recording; {hint}", quoted(key)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn flags_are_taken_apart() {
        let parsed = |text: &str| text.parse::<MapFlag>().map(|flag| (flag.key, flag.name, flag.unit, flag.scale));
        let of =
            |key: &str, name: &str, unit: &str, scale| Ok((key.to_owned(), name.to_owned(), unit.to_owned(), scale));
        assert_eq!(parsed("position=pos:mm"), of("position", "pos", "mm", None));
        assert_eq!(parsed("torque=i:A*0.12"), of("torque", "i", "A", Some(0.12)));
        assert_eq!(parsed("force=u"), of("force", "u", "", None));
        assert_eq!(
            parsed("position=/js:enc.a:counts(8192)*-1"),
            of("position", "/js:enc.a", "counts(8192)", Some(-1.0))
        );
        assert!(parsed("positon=pos").unwrap_err().contains("is `position` meant?"));
        assert!(parsed("position").unwrap_err().starts_with("must be KEY=NAME"));
        assert!(parsed("torque=i:A*x").unwrap_err().starts_with("scale `x` is not a number"));
    }
}
