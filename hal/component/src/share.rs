//! State shared between the functions of a component, and the declaration of what each function
//! accesses.

use crate::abi::{Slot, Use, access};
use crossbeam::queue::ArrayQueue;
use std::{ops::Deref, sync::Arc};

/// Pins, parameters and hidden state that a function accesses.
#[derive(Debug, Default)]
pub struct Uses(pub(crate) Vec<Use>);

impl Uses {
    pub(crate) fn item(&mut self, slot: *const Slot, access: u32) {
        self.0.push(Use { slot, token: 0, access });
    }

    pub(crate) fn hidden<T>(&mut self, shared: &Arc<T>, access: u32) {
        let token = Arc::as_ptr(shared).cast::<u8>().addr() as u64;
        self.0.push(Use { slot: core::ptr::null(), token, access });
    }
}

/// Part of a function that declares which pins, parameters and hidden state it accesses.
#[diagnostic::on_unimplemented(
    message = "the engine cannot see which pins `{Self}` touches",
    label = "write `#[derive(Touch)]` above it, or mark the field `#[state]`"
)]
pub trait Touch {
    /// Adds the items that this value accesses.
    fn touch(&self, uses: &mut Uses);
}

impl<T: Touch> Touch for Vec<T> {
    fn touch(&self, uses: &mut Uses) {
        self.iter().for_each(|t| t.touch(uses));
    }
}
impl<T: Touch> Touch for Box<[T]> {
    fn touch(&self, uses: &mut Uses) {
        self.iter().for_each(|t| t.touch(uses));
    }
}
impl<T: Touch, const N: usize> Touch for [T; N] {
    fn touch(&self, uses: &mut Uses) {
        self.iter().for_each(|t| t.touch(uses));
    }
}
impl<T: Touch> Touch for Option<T> {
    fn touch(&self, uses: &mut Uses) {
        self.iter().for_each(|t| t.touch(uses));
    }
}
impl<T: Touch> Touch for Arc<T> {
    fn touch(&self, uses: &mut Uses) {
        (**self).touch(uses);
    }
}
impl<A: Touch, B: Touch> Touch for (A, B) {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
        self.1.touch(uses);
    }
}

macro_rules! handover {
    ($($(#[$m:meta])* $name:ident, $access:expr;)*) => {$(
        $(#[$m])*
        #[derive(Debug)]
        pub struct $name<T>(pub(crate) Arc<T>);
        impl<T> Clone for $name<T> {
            fn clone(&self) -> Self {
                Self(self.0.clone())
            }
        }
        impl<T> Deref for $name<T> {
            type Target = T;
            #[inline]
            fn deref(&self) -> &T {
                &self.0
            }
        }
        impl<T> Touch for $name<T> {
            fn touch(&self, uses: &mut Uses) {
                uses.hidden(&self.0, $access);
            }
        }
    )*};
}
handover! {
    /// Writing end of hidden state (atomics) that one function passes to another.
    Gives, access::WRITE;
    /// Reading end of hidden state (atomics) that one function passes to another.
    Takes, access::READ;
}

/// Sending end of a bounded queue between a command or task and a function.
#[derive(Debug)]
pub struct Sender<T>(pub(crate) Arc<ArrayQueue<T>>);
/// Receiving end of a bounded queue between a command or task and a function.
#[derive(Debug)]
pub struct Receiver<T>(pub(crate) Arc<ArrayQueue<T>>);

impl<T> Clone for Sender<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T: Copy> Sender<T> {
    /// Appends `value`. Lock-free.
    ///
    /// # Errors
    /// The queue is full; the error contains the value.
    pub fn send(&self, value: T) -> Result<(), T> {
        self.0.push(value)
    }

    /// Returns the number of values that wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.0.len()
    }
}

impl<T: Copy> Receiver<T> {
    /// Takes the oldest value. Lock-free.
    pub fn take(&mut self) -> Option<T> {
        // An empty queue answers `pop` only after a fence.
        if self.0.is_empty() { None } else { self.0.pop() }
    }
}

impl<T> Touch for Sender<T> {
    fn touch(&self, uses: &mut Uses) {
        uses.hidden(&self.0, access::WRITE);
    }
}
impl<T> Touch for Receiver<T> {
    fn touch(&self, uses: &mut Uses) {
        uses.hidden(&self.0, access::READ);
    }
}
