//! Tests of the driver on fake and on simulated devices.
//!
//! `names` and `axes` compare with what LinuxCNC's `hal_input` was measured to do; `choosing` has tables of
//! specifications and of refusals; `events`, `lost` and `simulated` go from events to pins; `bytes` has what no device
//! should send.

mod axes;
mod bytes;
mod choosing;
mod events;
mod fake;
mod lost;
mod names;
mod simulated;
