//! Declarations of arguments.

use crate::{Record, Str};

/// Types of arguments of `loadrt` and of commands.
pub mod arg {
    /// An integer in C notation.
    pub const INT: u32 = 1;
    /// A floating-point number.
    pub const FLOAT: u32 = 2;
    /// A string.
    pub const TEXT: u32 = 3;
    /// Integers separated by commas.
    pub const INTS: u32 = 4;
    /// Strings separated by commas.
    pub const TEXTS: u32 = 5;
    /// A boolean.
    pub const BIT: u32 = 6;
}

/// Bits of [`ArgSpec::bounds`].
pub mod arg_bounds {
    /// [`ArgSpec::low`](super::ArgSpec::low) is the least legal value.
    pub const LOW: u32 = 1;
    /// [`ArgSpec::high`](super::ArgSpec::high) is the greatest legal value.
    pub const HIGH: u32 = 2;
    /// With [`LOW`]: the legal values are above `low`, without `low` itself.
    pub const ABOVE: u32 = 4;
}

/// Name under which a command that is executing asks whether a client that speaks for people elsewhere has given it. No
/// argument has this name: the engine alone gives the value.
pub const FROM_AFAR: &str = "@from-afar";

/// An argument of `loadrt` or of a command.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ArgSpec {
    /// `size_of::<ArgSpec>()` at compile time.
    pub size: u32,
    /// Type of the argument, a constant in [`arg`].
    pub kind: u32,
    /// Maximum number of items in a list. Zero means no limit.
    pub most: u32,
    /// Not zero if the argument is required.
    pub required: u32,
    /// Name, as in `NAME=VALUE`.
    pub name: Str,
    /// Description. Unit and range have fields of their own.
    pub doc: Str,
    /// Default value as a user would write it. Empty means no default.
    pub default: Str,
    /// Least legal number, or of each number of a list, if `bounds` has [`arg_bounds::LOW`].
    pub low: f64,
    /// Greatest legal number, or of each number of a list, if `bounds` has [`arg_bounds::HIGH`].
    pub high: f64,
    /// Bits of [`arg_bounds`].
    pub bounds: u32,
    /// Must be zero.
    pub reserved: u32,
    /// Unit of a number, such as `ns` or `units/s`. Empty means none.
    pub unit: Str,
}
// SAFETY: an `ArgSpec` is immutable static data.
unsafe impl Sync for ArgSpec {}
// SAFETY: `#[repr(C)]`, size first, zero is valid: without bounds, every number is legal.
unsafe impl Record for ArgSpec {
    const MIN: usize = core::mem::offset_of!(Self, low);
}

impl ArgSpec {
    /// Returns an argument of the given kind (one of the constants in [`arg`]).
    pub const fn new(kind: u32, name: &'static str, doc: &'static str) -> Self {
        Self {
            size: crate::size::<Self>(),
            kind,
            most: 0,
            required: 0,
            name: Str::new(name),
            doc: Str::new(doc),
            default: Str::NONE,
            low: 0.0,
            high: 0.0,
            bounds: 0,
            reserved: 0,
            unit: Str::NONE,
        }
    }

    /// Sets the default value, written as a user would.
    pub const fn or(mut self, default: &'static str) -> Self {
        self.default = Str::new(default);
        self
    }

    /// Makes the argument required.
    pub const fn required(mut self) -> Self {
        self.required = 1;
        self
    }

    /// Limits a list to `n` items.
    pub const fn at_most(mut self, n: u32) -> Self {
        self.most = n;
        self
    }

    /// Limits a number, or each number of a list, to `low` to `high`.
    pub const fn within(self, low: f64, high: f64) -> Self {
        self.at_least(low).up_to(high)
    }

    /// Limits a number, or each number of a list, to `low` or more.
    pub const fn at_least(mut self, low: f64) -> Self {
        self.low = low;
        self.bounds |= arg_bounds::LOW;
        self
    }

    /// Limits a number, or each number of a list, to more than `low`.
    pub const fn above(mut self, low: f64) -> Self {
        self.low = low;
        self.bounds |= arg_bounds::LOW | arg_bounds::ABOVE;
        self
    }

    /// Limits a number, or each number of a list, to `high` or less.
    pub const fn up_to(mut self, high: f64) -> Self {
        self.high = high;
        self.bounds |= arg_bounds::HIGH;
        self
    }

    /// Sets the unit of a number.
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Str::new(unit);
        self
    }

    /// Returns whether a number is legal. NaN is not legal if there are bounds.
    #[must_use]
    pub fn allows(&self, number: f64) -> bool {
        let has = |bit| self.bounds & bit != 0;
        let is_above = if has(arg_bounds::ABOVE) { self.low < number } else { self.low <= number };
        (is_above || !has(arg_bounds::LOW)) && (number <= self.high || !has(arg_bounds::HIGH))
    }
}

#[cfg(test)]
mod tests {
    use super::{ArgSpec, arg};

    #[test]
    fn bounds_are_those_declared() {
        let free = ArgSpec::new(arg::FLOAT, "x", "");
        for (spec, legal, illegal) in [
            (free, &[f64::MIN, 0.0, f64::NAN][..], &[][..]),
            (free.within(1.0, 8.0), &[1.0, 8.0], &[0.9, 8.1, f64::NAN]),
            (free.at_least(0.0), &[0.0, f64::INFINITY], &[-0.1, f64::NAN]),
            (free.above(0.0), &[1e-300], &[0.0, -0.0, f64::NAN]),
            (free.above(0.0).up_to(1.0), &[1.0], &[0.0, 1.1]),
            (free.up_to(-1.0), &[-1.0, f64::NEG_INFINITY], &[0.0, f64::NAN]),
        ] {
            assert!(legal.iter().all(|n| spec.allows(*n)), "{spec:?}");
            assert!(!illegal.iter().any(|n| spec.allows(*n)), "{spec:?}");
        }
    }
}
