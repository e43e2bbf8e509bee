//! Plain records: values of a fixed number of words, which rings, seqlocks and snapshots carry.

use crate::{
    Value,
    abi::{self, FieldSpec, Str},
};

/// A record of pin values and arrays of them, one 64-bit word for each value.
///
/// `#[derive(Plain)]` implements it. In memory the record has the layout of a C struct in which
/// every value takes eight bytes.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a plain record",
    label = "write `#[derive(Clone, Copy, Plain)]` above it"
)]
pub trait Plain: Copy + Send + 'static {
    /// Number of words.
    const WORDS: usize;
    /// Names, types and descriptions of the fields.
    const FIELDS: &'static [&'static FieldSpec];
    /// Names of the fields.
    const NAMES: &'static [&'static str];
    /// Passes the words of the record to `put`, in order.
    fn store(&self, put: &mut impl FnMut(u64));
    /// Passes words with their places in the record to `put`: those of the fields that [`fields`] has made the number
    /// `FIELDS` of, and of fields beyond the 128th.
    fn store_some<const FIELDS: u128>(&self, put: &mut impl FnMut(usize, u64));
    /// Makes a record from the words that `take` returns, in order.
    fn load(take: &mut impl FnMut() -> u64) -> Self;
}

/// A field of a plain record: a pin value, or an array of them.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be a field of a plain record",
    label = "use `bool`, `f64`, `i32`, `u32`, `i64`, `u64`, or an array of one of them"
)]
pub trait PlainField: Copy {
    /// HAL type code.
    const TYPE: u8;
    /// Number of values.
    const COUNT: usize;
    /// Passes the words of the field to `put`, in order.
    fn store(&self, put: &mut impl FnMut(u64));
    /// Makes a field from the words that `take` returns, in order.
    fn load(take: &mut impl FnMut() -> u64) -> Self;
}

impl<V: Value> PlainField for V {
    const TYPE: u8 = V::TYPE;
    const COUNT: usize = 1;
    #[inline]
    fn store(&self, put: &mut impl FnMut(u64)) {
        put(self.to_bits());
    }
    #[inline]
    fn load(take: &mut impl FnMut() -> u64) -> Self {
        V::from_bits(take())
    }
}

impl<V: Value, const N: usize> PlainField for [V; N] {
    const TYPE: u8 = V::TYPE;
    const COUNT: usize = N;
    #[inline]
    fn store(&self, put: &mut impl FnMut(u64)) {
        self.iter().for_each(|v| put(v.to_bits()));
    }
    #[inline]
    fn load(take: &mut impl FnMut() -> u64) -> Self {
        core::array::from_fn(|_| V::from_bits(take()))
    }
}

/// Returns the number that stands for some fields of a record, for
/// [`Snapshot::set_some`](crate::Snapshot::set_some): a bit for each of the first 128. A name of no field is an error
/// of the compiler where the number is a constant.
#[must_use]
#[expect(clippy::indexing_slicing, reason = "for constants: an index out of range ends the build")]
pub const fn fields<T: Plain>(names: &[&str]) -> u128 {
    let (mut all, mut name) = (0, 0);
    while name < names.len() {
        let mut field = 0;
        while !is_same(names[name], T::NAMES[field]) {
            field += 1;
        }
        all |= 1 << field;
        name += 1;
    }
    all
}

#[expect(clippy::indexing_slicing, reason = "below both lengths")]
const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut n = 0;
    while n < a.len() && n < b.len() && a[n] == b[n] {
        n += 1;
    }
    n == a.len() && n == b.len()
}

/// Returns the declaration of a field, for `#[derive(Plain)]`.
#[doc(hidden)]
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "no record has 4 billion values")]
pub const fn field<F: PlainField>(name: &'static str, doc: &'static str) -> FieldSpec {
    FieldSpec {
        size: abi::size::<FieldSpec>(),
        ty: F::TYPE,
        count: F::COUNT as u32,
        name: Str::new(name),
        doc: Str::new(doc),
    }
}
