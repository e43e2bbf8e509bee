//! The safety machine of motion: what may be switched on, what may move, which order is refused, and what each event stops
//! and how.
//!
//! Everything here is a `Copy` value without a clock, a pin or a queue, so that a test can walk through all orders of events.
//!
//! - [`SafetyMachine`] decides for `motmod`: its one function, [`SafetyMachine::on`], takes an [`Event`] and the [`Facts`]
//!   of that moment, and answers with a refusal or a stop. The joints and the path do what the [`Answer`] says.
//! - [`lease`] decides for the plugin `remote`: how long a lease and a jog last, and what a lost lease does.
//! - [`plant`] is the plainest body that obeys a machine: joints and a path that move, brake or rest. Searches and random
//!   walks use it; the real ones must do the same.
#![no_std]
#![forbid(unsafe_code)]

mod epoch;
mod event;
pub mod lease;
mod machine;
pub mod plant;
mod refused;

pub use epoch::{Ends, Epoch};
pub use event::{
    Answer, Event, Facts, Jog, Mode, OrderKind, OrderSource, Parked, Reaction, Resume, Shift, Stop,
    Trouble,
};
pub use machine::{Power, SafetyMachine};
pub use refused::Refused;
