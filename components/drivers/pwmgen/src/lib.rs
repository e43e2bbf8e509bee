//! Software pulse-width modulation.
#![forbid(unsafe_code)]

mod handover;
mod pulses;
mod pwmgen;
mod update;

pub use pwmgen::Pwmgen;

hal_component::export!(Pwmgen);
