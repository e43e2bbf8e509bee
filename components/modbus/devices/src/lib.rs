//! Simulated devices on a simulated line. Each knows the time only by what its caller tells it.
//!
//! | module | subject |
//! |---|---|
//! | `bus` | the line: time of characters, silence, and faults by a seed |
//! | `slave` | a Modbus slave with its four tables |
//! | `inverter` | Huanyang's inverter: ramps, trips, and a time-out by its own clock |
#![forbid(unsafe_code)]

mod bus;
mod inverter;
mod slave;
#[cfg(test)]
mod tests;

pub use bus::{Bus, Device, Faults, Timing};
pub use inverter::Inverter;
pub use slave::Slave;
