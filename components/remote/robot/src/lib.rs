//! A robot arm behind the line protocol of its own controller: programs into lines, the driver, a simulated controller.
#![forbid(unsafe_code)]

mod controller;
mod convert;
mod driver;
mod line;
mod volume;

pub use controller::{Controller, Faults, Output};
pub use convert::{Failed, Record, convert};
pub use driver::{Driver, Event, State, Stopped};
pub use line::{Answer, Command, FASTEST, Framer, MAX_LINE, Refusal};
pub use volume::{Outside, Volume, Zero, parse_zero};
