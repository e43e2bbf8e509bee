//! How a component declares the arguments of `loadrt` and of its commands.

use crate::abi::{ArgSpec, arg};

/// Declares arguments: `const ARGS: … = &[&Arg::ints("step_type", "…").required().at_most(16)];`
#[derive(Debug)]
pub enum Arg {}

impl Arg {
    /// One integer in C's notation (`10`, `0x378`, `017`).
    #[must_use]
    pub const fn int(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::INT, name, doc)
    }

    /// One floating-point number.
    #[must_use]
    pub const fn float(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::FLOAT, name, doc)
    }

    /// One string.
    #[must_use]
    pub const fn text(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::TEXT, name, doc)
    }

    /// Integers separated by commas.
    #[must_use]
    pub const fn ints(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::INTS, name, doc)
    }

    /// Strings separated by commas.
    #[must_use]
    pub const fn texts(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::TEXTS, name, doc)
    }

    /// A truth value (`1`, `0`, `TRUE`, `FALSE`, `ON`, `OFF`, `YES`, `NO`).
    #[must_use]
    pub const fn bit(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::BIT, name, doc)
    }
}
