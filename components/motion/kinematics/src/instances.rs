//! Kinematics components with pins per instance.

use hal_component::{Arg, Builder, Error, abi::ArgSpec};

/// Argument `count=`.
pub(crate) const COUNT: ArgSpec =
    Arg::int("count", "How many times its own pins are there, 1 to 16.").or("1");

/// Argument `names=`.
pub(crate) const NAMES: ArgSpec =
    Arg::texts("names", "Names for its own pins instead of numbers; not with count=.");

/// Returns the prefixes of the pins: `base.0` and so on, or the given names.
pub(crate) fn prefixes(b: &Builder<'_>, base: &str) -> Result<Vec<String>, Error> {
    let names = b.arg_texts("names");
    let count = b.arg_int("count").unwrap_or(1);
    if !names.is_empty() {
        if count != 1 {
            return Err(Error::new("count= and names= are mutually exclusive"));
        }
        return Ok(names);
    }
    if !(1..=16).contains(&count) {
        return Err(Error::new(format!("count is {count}, must be between 1 and 16")));
    }
    Ok((0..count).map(|i| format!("{base}.{i}")).collect())
}
