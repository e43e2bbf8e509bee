//! Software step pulse generators.
#![forbid(unsafe_code)]

mod capture;
mod freq;
mod handover;
mod params;
mod pulses;
mod stepgen;
mod types;

pub use stepgen::Stepgen;

hal_component::export!(Stepgen);
