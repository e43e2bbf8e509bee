//! What the whole-system tests share: programs, plugins, engines, folders of their own, cases as data,
//! recordings read back.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stderr,
    reason = "whatever fails here fails a test; what is skipped is said"
)]

pub mod case;
pub mod faults;
pub mod foreign;
pub mod fuzz;
pub mod machine;
pub mod plugins;
pub mod programs;
pub mod scratch;
pub mod terminal;
pub mod trace;
pub mod vcd;
