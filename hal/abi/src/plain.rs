//! Declarations of plain records: names and types of their fields.

use crate::{Record, Str};

/// A field of a plain record. Each of its values takes one 64-bit word.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct FieldSpec {
    /// `size_of::<FieldSpec>()` at compile time.
    pub size: u32,
    /// Number of values: 1, or the length of an array.
    pub count: u32,
    /// Name of the field, as in a C struct.
    pub name: Str,
    /// Description, with unit and range.
    pub doc: Str,
    /// Type code of each value, a constant in [`ty`](crate::ty).
    pub ty: u8,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for FieldSpec {
    const MIN: usize = size_of::<Self>();
}
// SAFETY: a `FieldSpec` is immutable static data.
unsafe impl Sync for FieldSpec {}
