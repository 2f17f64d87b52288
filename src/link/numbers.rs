//! Numbers of a random generator that a session may have.

/// The continuous test of a random generator (FIPS PUB 140-2, as RM0090 section 24.3.1 asks for it): the first number after it
/// was started is not used but compared with the next, and one that equals the one before it is none.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Neighbours {
    before: Option<u32>,
}

impl Neighbours {
    /// The number that the generator has given, if it may be used.
    pub fn pass(&mut self, number: u32) -> Option<u32> {
        let before = self.before.replace(number)?;
        (before != number).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neither_the_first_number_nor_one_that_equals_its_neighbour_is_used() {
        let mut neighbours = Neighbours::default();
        let passed = [7, 9, 9, 9, 7, 8].map(|number| neighbours.pass(number));
        assert_eq!(passed, [None, Some(9), None, None, Some(7), Some(8)]);
    }
}
