//! Functions in Python that remapped codes and O-words call.
//!
//! They run in a process of their own. The interpreter's state goes there by value with each step, and the effects of the
//! function come back, so that a function that crashes or never ends is an error of its line.
//!
//! | module | subject |
//! |---|---|
//! | [`setup`] | what an INI file says about them |
//! | [`functions`] | calls in progress, and their steps |
//! | `process` | the process, and the lines that go to it and come from it |
#![forbid(unsafe_code)]

pub mod functions;
mod process;
pub mod setup;

pub use functions::{Functions, Progress};
pub use setup::Setup;
