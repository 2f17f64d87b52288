//! er-servo.
fn main() {}
