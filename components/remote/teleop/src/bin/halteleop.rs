//! The program halteleop.
fn main() {}
