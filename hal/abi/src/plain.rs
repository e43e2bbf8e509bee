//! Declarations of plain records: names and types of their fields.

use crate::{List, Page, Record, Str};

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

/// A snapshot: a plain record that a component publishes, and that programs read from a page of
/// shared memory.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SnapshotSpec {
    /// `size_of::<SnapshotSpec>()` at compile time.
    pub size: u32,
    /// Version of the record. It changes when a field changes or is removed.
    pub version: u32,
    /// Absolute name, such as `motion.status`.
    pub name: Str,
    /// Description. The first line is a summary.
    pub doc: Str,
    /// Fields of the record, in order.
    pub fields: List<FieldSpec>,
}
// SAFETY: `#[repr(C)]`, size first, zero is valid.
unsafe impl Record for SnapshotSpec {
    const MIN: usize = size_of::<Self>();
}

/// A page that the host created for a snapshot.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct SnapshotRef {
    /// Header of the page, live until the component is unloaded.
    pub page: *const Page,
    /// Number of words.
    pub words: u32,
}
