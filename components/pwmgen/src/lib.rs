//! Pulse-width modulation in software.
#![forbid(unsafe_code)]

mod handover;
mod pulses;
mod pwmgen;
mod update;

pub use pwmgen::Pwmgen;

hal_component::export!(Pwmgen);
