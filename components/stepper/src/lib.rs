//! A stepper motor on the bench.
#![forbid(unsafe_code)]

mod motion;
mod stepper;

pub use stepper::Stepper;

hal_component::export!(Stepper);
