//! The nearest known word, for messages about a key or a column that is not one.

/// The candidate `word` is probably a misspelling of: at most four letters in ten differ.
pub fn misspelt<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = candidates.into_iter().map(|candidate| (likeness(word, candidate), candidate));
    let nearest = scored.max_by(|one, other| one.0.total_cmp(&other.0));
    nearest.filter(|(likeness, _)| *likeness >= 0.6).map(|(_, candidate)| candidate)
}

/// How alike two words are, 0 to 1, whatever the case of the first.
pub(crate) fn likeness(word: &str, candidate: &str) -> f64 {
    // Comparing is quadratic in the length; no known word is longer than this, and a corrupt file may hold a huge one.
    let word: String = word.chars().take(64).collect::<String>().to_lowercase();
    strsim::normalized_damerau_levenshtein(&word, candidate)
}

/// A piece of the user's input as a message quotes it: one line, at most 40 characters, those that can be typed as they are.
pub(crate) fn quoted(text: &str) -> String {
    let mut short = String::from("`");
    for letter in text.chars().take(40) {
        match letter {
            '\\' | '"' | '\'' => short.push(letter),
            other => short.extend(other.escape_debug()),
        }
    }
    if text.chars().nth(40).is_some() {
        short.push('…');
    }
    short + "`"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelling_is_found_and_a_stranger_is_not() {
        let known = ["t_s", "position_rad", "torque_cmd_nm"];
        assert_eq!(misspelt("positon_rad", known), Some("position_rad"));
        assert_eq!(misspelt("torque_nm", known), Some("torque_cmd_nm"));
        assert_eq!(misspelt("humidity", known), None);
        assert_eq!(misspelt("inertai", ["inertia", "coulomb"]), Some("inertia"));
    }

    #[test]
    fn what_is_quoted_can_be_typed_and_is_one_line() {
        for (text, said) in [(r"$\theta$", r"`$\theta$`"), ("a\nb", r"`a\nb`"), ("it's \"q\"", "`it's \"q\"`")] {
            assert_eq!(quoted(text), said);
        }
        assert_eq!(quoted(&"x".repeat(41)), format!("`{}…`", "x".repeat(40)));
    }
}
