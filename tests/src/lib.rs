//! Support code of the whole-system tests: programs, plugins, engines, scratch folders, cases as data, a reader for
//! recordings, and the judge of components.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "whatever fails here fails a test"
)]

pub mod browser;
pub mod case;
pub mod conformance;
pub mod costs;
pub mod counted;
pub mod every;
pub mod faults;
pub mod foreign;
pub mod fuzz;
mod guard;
pub mod imports;
mod lasting;
pub mod machine;
pub mod mutations;
pub mod pins;
pub mod plugins;
pub mod programs;
pub mod properties;
pub mod proxy;
pub mod random;
pub mod raw;
pub mod schema;
pub mod scratch;
pub mod terminal;
pub mod tools;
pub mod trace;
pub mod user;
pub mod vcd;
pub mod web;

pub use hal_golden as golden;
