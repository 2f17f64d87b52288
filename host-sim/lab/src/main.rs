//! servo-lab.
fn main() {}
