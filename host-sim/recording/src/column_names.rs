//! Names of columns that are there twice, are empty or are none.

use super::columns::Complaint;

/// Names that are there twice, or empty, with the number of their column: somebody else's log may have them where nobody needs them.
pub(crate) fn told_apart(names: &[String]) -> Vec<String> {
    let is_unclear = |name: &String| name.is_empty() || names.iter().filter(|other| *other == name).count() > 1;
    let numbered = |(index, name): (usize, &String)| format!("{name} (column {})", index + 1).trim_start().to_owned();
    let told = |of: (usize, &String)| if is_unclear(of.1) { numbered(of) } else { of.1.clone() };
    names.iter().enumerate().map(told).collect()
}

/// Whether a name is one of several that are alike.
pub(crate) fn is_told_apart(name: &str) -> bool {
    name.ends_with(')') && name.contains(" (column ")
}

/// Says what is wrong with names that a recording cannot have.
pub(crate) fn refuse_unusable_names(names: &[String]) -> Result<(), Complaint> {
    if !names.is_empty() && names.iter().all(|name| name.parse::<f64>().is_ok()) {
        let message = "header row is missing: the first line holds numbers only; say which column is what by its number, \
                       as in servo-lab init LOG --map time=[1]:s --map position=[2]:rad --map \"torque=[3]:N m\"";
        return Err(Complaint::new("", message));
    }
    for (index, name) in names.iter().enumerate() {
        if name.is_empty() {
            return Err(Complaint::new("", format!("column {} has no name", index + 1)));
        }
        if let Some(first) = names[..index].iter().position(|earlier| earlier == name) {
            let message = format!("column is there twice, as column {} and column {}", first + 1, index + 1);
            return Err(Complaint::new(name, message));
        }
    }
    Ok(())
}
