//! The parts of the law, each pure; [`crate::step()`] is what puts them together.

pub(crate) mod damper;
pub(crate) mod mode;
pub(crate) mod pd;
pub(crate) mod resolver;
pub(crate) mod speed;
pub(crate) mod supervisor;
