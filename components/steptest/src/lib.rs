//! Back and forth moves that test an axis.
#![forbid(unsafe_code)]

mod steptest;

pub use steptest::Steptest;

hal_component::export!(Steptest);
