//! A pin or parameter to be created.

use crate::{graph::doc::Doc, name::Name};
use core::{ffi::c_void, ptr::NonNull};
use hal_protocol::{Direction, Type};

/// A pin or parameter to be created.
pub(crate) struct NewItem {
    pub(crate) name: Name,
    pub(crate) other: Option<Name>,
    pub(crate) ty: Type,
    pub(crate) direction: Direction,
    pub(crate) initial: u64,
    pub(crate) storage: Option<NonNull<c_void>>,
    pub(crate) hidden: bool,
    pub(crate) times: bool,
    pub(crate) safety: bool,
    pub(crate) measured: bool,
    pub(crate) doc: Doc,
}
