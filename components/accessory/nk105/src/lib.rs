//! A simulated closed controller, the NK105, without HAL: it reads frames of keys, draws on its handheld's display, and runs
//! jobs that it finds on a USB medium.
//!
//! | module | subject |
//! |---|---|
//! | `controller` | one cycle: keys, mode, motion |
//! | `keys` | the effect of each key |
//! | `motion` | motion along straight lines at constant speeds |
//! | `panel` | the text of the display, and the bytes that draw it |
//! | `job` | a G-code program as steps of a job |
#![forbid(unsafe_code)]

pub mod controller;
pub mod job;
mod keys;
pub mod motion;
pub mod panel;

pub use controller::{Controller, JobStop, Medium, Mode};
pub use job::{JobStep, WrongJob};
