//! Declarations of pins and parameters, and errors.

use crate::{
    Builder, Field, Item, Value,
    abi::{self, ItemSpec, Status, Str, item_flags},
    item::Dir,
};
use std::borrow::Cow;

/// Reason why an instance could not be created, or a command not executed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    pub(crate) status: Status,
    pub(crate) text: Option<Cow<'static, str>>,
}

impl Error {
    /// Returns an error with a text in the user's words: lower case, no full stop.
    pub fn new(text: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::EINVAL, text: Some(text.into()) }
    }

    /// Returns an error that means: there is no room now, try again.
    pub fn again(text: impl Into<Cow<'static, str>>) -> Self {
        Self { status: Status::EAGAIN, text: Some(text.into()) }
    }

    /// Returns the text of the error. Returns `None` if the engine reported the reason itself.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        self.text.as_deref()
    }

    pub(crate) const fn engine(status: Status) -> Self {
        Self { status, text: None }
    }
}

/// Declaration of a pin or parameter.
#[derive(Clone, Copy, Debug)]
pub struct Decl<'a> {
    pub(crate) name: &'a str,
    pub(crate) doc: &'a str,
    pub(crate) old: &'a str,
    pub(crate) flags: u32,
}

impl<'a> Decl<'a> {
    /// Returns a declaration with a name within the instance (absolute for a type that is created
    /// once) and a documentation line with unit and range.
    #[must_use]
    pub const fn new(name: &'a str, doc: &'a str) -> Self {
        Self { name, doc, old: "", flags: 0 }
    }

    /// Adds the absolute name from before LinuxCNC distinguished joints and axes.
    #[must_use]
    pub const fn old(mut self, name: &'a str) -> Self {
        self.old = name;
        self
    }

    /// Marks a bit of simulated hardware, which is listed only if a pattern names it.
    #[must_use]
    pub const fn hidden(mut self) -> Self {
        self.flags |= item_flags::HIDDEN;
        self
    }

    /// Marks a limit switch or e-stop input.
    #[must_use]
    pub const fn safety(mut self) -> Self {
        self.flags |= item_flags::SAFETY;
        self
    }
}

impl Builder<'_> {
    /// Creates a pin of simulated hardware, which is listed only if a pattern names it.
    ///
    /// # Errors
    /// As [`Builder::item`].
    pub fn simulated<T: Value, D: Dir>(
        &mut self,
        name: &str,
        doc: &str,
        initial: T,
    ) -> Result<Item<T, D>, Error> {
        self.declare(Decl::new(name, doc).hidden(), initial)
    }
}

impl Decl<'_> {
    /// Marks a value that a sensor measures, such as the position of an encoder.
    #[must_use]
    pub const fn measured(mut self) -> Self {
        self.flags |= item_flags::MEASURED;
        self
    }
}

impl Decl<'static> {
    /// Returns the declaration as a library publishes it without running code: an entry of
    /// [`Component::ITEMS`](crate::Component::ITEMS). `initial` is the initial value as bits of a
    /// cell, such as `1.5_f64.to_bits()`.
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
