//! A robot arm behind the line protocol of its own controller: programs into lines, the driver, a simulated controller, and
//! the plugin `robot`.
#![forbid(unsafe_code)]

mod console;
mod controller;
mod convert;
mod driver;
mod line;
mod link;
mod plugin;
mod program;
mod state;
mod volume;

pub use console::{Console, ConsoleOptions, ConsoleRequest, LogEntry, LogKind};
pub use controller::{Controller, Faults, Output};
pub use convert::{Failed, Record, convert};
pub use driver::Driver;
pub use line::{Answer, Command, FASTEST, Framer, MAX_LINE, Refusal};
pub use link::{SimulatedLink, TcpLink, TcpOpening, check_address, connect};
pub use plugin::Robot;
pub use program::{Program, approach};
pub use state::{Event, State, Stopped};
pub use volume::{Outside, Volume, Zero, parse_volume, parse_zero};

hal_component::export!(Robot);
