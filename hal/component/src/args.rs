//! Declaration of the arguments of `loadrt` and of commands.

use crate::{
    Builder, Error,
    abi::{ArgSpec, arg},
};

/// Declares arguments, as in
/// `const ARGS: … = &[&Arg::ints("step_type", "…").required().at_most(16)];`
#[derive(Debug)]
pub enum Arg {}

impl Arg {
    /// Declares an integer in C notation (`10`, `0x378`, `017`).
    #[must_use]
    pub const fn int(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::INT, name, doc)
    }

    /// Declares a floating-point number.
    #[must_use]
    pub const fn float(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::FLOAT, name, doc)
    }

    /// Declares a string.
    #[must_use]
    pub const fn text(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::TEXT, name, doc)
    }

    /// Declares a list of integers, separated by commas.
    #[must_use]
    pub const fn ints(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::INTS, name, doc)
    }

    /// Declares a list of strings, separated by commas.
    #[must_use]
    pub const fn texts(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::TEXTS, name, doc)
    }

    /// Declares a boolean (`1`, `0`, `TRUE`, `FALSE`, `ON`, `OFF`, `YES`, `NO`).
    #[must_use]
    pub const fn bit(name: &'static str, doc: &'static str) -> ArgSpec {
        ArgSpec::new(arg::BIT, name, doc)
    }
}

impl Builder<'_> {
    /// Returns the number of `pins` that the personality requests, or `usual` if the personality is
    /// 0.
    ///
    /// # Errors
    /// The personality is not in the range 0 to `most`.
    pub fn size(&self, pins: &str, usual: i64, most: i64) -> Result<i64, Error> {
        match self.personality() {
            0 => Ok(usual),
            n if (1..=most).contains(&n) => Ok(n),
            n => Err(Error::new(format!(
                "{pins}: Requested size {n} exceeds max size {most}: personality= is 1 to {most}, \
                 or 0 for {usual}"
            ))),
        }
    }
}
