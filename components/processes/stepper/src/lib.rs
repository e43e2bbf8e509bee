//! Simulated stepper motor.
#![forbid(unsafe_code)]

mod motion;
mod stepper;

pub use stepper::Stepper;

hal_component::export!(Stepper);
