//! How an item is declared, and what can go wrong.

use crate::{
    Field,
    abi::{self, ItemSpec, Status, Str, item_flags},
};
use std::borrow::Cow;

/// Why an instance could not be made, or a command not carried out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    pub(crate) status: Status,
    pub(crate) text: Option<Cow<'static, str>>,
}

impl Error {
    /// An error in the user's words: lower case, no full stop.
    pub fn new(text: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::EINVAL, text: Some(text.into()) }
    }

    /// The sentence, if it has one of its own; otherwise the engine said why.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        self.text.as_deref()
    }

    pub(crate) const fn engine(status: Status) -> Self {
        Self { status, text: None }
    }
}

/// How an item is declared.
#[derive(Clone, Copy, Debug)]
pub struct Decl<'a> {
    pub(crate) name: &'a str,
    pub(crate) doc: &'a str,
    pub(crate) old: &'a str,
    pub(crate) flags: u32,
}

impl<'a> Decl<'a> {
    /// A name within the instance (absolute for a type created once) and its documentation:
    /// one line with unit and range.
    #[must_use]
    pub const fn new(name: &'a str, doc: &'a str) -> Self {
        Self { name, doc, old: "", flags: 0 }
    }

    /// The absolute name it had before joints and axes were told apart.
    #[must_use]
    pub const fn old(mut self, name: &'a str) -> Self {
        self.old = name;
        self
    }

    /// A bit of simulated hardware: listed only when a pattern names it.
    #[must_use]
    pub const fn hidden(mut self) -> Self {
        self.flags |= item_flags::HIDDEN;
        self
    }

    /// A limit switch or e-stop input.
    #[must_use]
    pub const fn safety(mut self) -> Self {
        self.flags |= item_flags::SAFETY;
        self
    }
}

impl Decl<'static> {
    /// The declaration as a library shows it without running code: a line of
    /// [`Component::ITEMS`](crate::Component::ITEMS). `initial` is the first value as stored,
    /// such as `1.5_f64.to_bits()`.
    #[must_use]
    pub const fn spec<F: Field>(self, initial: u64) -> ItemSpec {
        ItemSpec {
            size: abi::size::<ItemSpec>(),
            flags: self.flags,
            name: Str::new(self.name),
            doc: Str::new(self.doc),
            old_name: Str::new(self.old),
            initial,
            storage: core::ptr::null_mut(),
            ty: F::TYPE,
            dir: F::DIR,
        }
    }
}
