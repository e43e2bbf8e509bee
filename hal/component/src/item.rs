//! Realtime. Handles of pins and parameters in a component.

use crate::{Builder, Decl, Error, Touch, Uses, abi};
use abi::Slot;
use core::{marker::PhantomData, ptr::NonNull};

/// A value that a pin or parameter can carry.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a type that a pin can carry",
    label = "use `bool`, `f64`, `i32`, `u32`, `i64`, `u64` or `Port`"
)]
pub trait Value: Copy + 'static {
    /// HAL type code.
    const TYPE: u8;
    /// Converts the value to the bits of a cell.
    fn to_bits(self) -> u64;
    /// Converts the bits of a cell to a value.
    fn from_bits(bits: u64) -> Self;
}

macro_rules! value {
    ($($t:ty, $code:ident, |$v:ident| $to:expr, |$b:ident| $from:expr;)*) => {$(
        impl Value for $t {
            const TYPE: u8 = abi::ty::$code;
            #[inline]
            fn to_bits(self) -> u64 { let $v = self; $to }
            #[inline]
            fn from_bits($b: u64) -> Self { $from }
        }
    )*};
}
value! {
    bool, BIT, |v| u64::from(v), |b| b & 0xff != 0;
    f64, FLOAT, |v| v.to_bits(), |b| f64::from_bits(b);
    i32, S32, |v| u64::from(v.cast_unsigned()), |b| low(b).cast_signed();
    u32, U32, |v| u64::from(v), |b| low(b);
    i64, S64, |v| v.cast_unsigned(), |b| b.cast_signed();
    u64, U64, |v| v, |b| b;
}

#[expect(clippy::cast_possible_truncation, reason = "32-bit values live in the low half")]
const fn low(bits: u64) -> u32 {
    bits as u32
}

/// Direction of a pin or parameter.
pub trait Dir: 'static {
    /// Direction code in the ABI.
    const CODE: u8;
    /// Access of a function that holds such an item: bits of [`abi::access`].
    const ACCESS: u32;
}

/// A direction that the component may write.
#[diagnostic::on_unimplemented(
    message = "an input pin cannot be written",
    label = "declare it `Out` or `Io`, or `InSet` if the component corrects its own input"
)]
pub trait Write: Dir {}

/// Handle of a pin or parameter. A copy refers to the same pin.
#[derive(Debug)]
pub struct Item<T, D> {
    slot: NonNull<Slot>,
    kind: PhantomData<(T, D)>,
}

impl<T, D> Clone for Item<T, D> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T, D> Copy for Item<T, D> {}
// SAFETY: every access through a slot is atomic.
unsafe impl<T, D> Send for Item<T, D> {}
// SAFETY: every access through a slot is atomic.
unsafe impl<T, D> Sync for Item<T, D> {}

macro_rules! dirs {
    ($($(#[$m:meta])* $alias:ident, $marker:ident, $code:ident, $access:expr $(, $write:ident)?;)*) => {$(
        #[doc(hidden)]
        #[derive(Debug)]
        pub enum $marker {}
        impl Dir for $marker {
            const CODE: u8 = abi::dir::$code;
            const ACCESS: u32 = $access;
        }
        $(impl $write for $marker {})?
        $(#[$m])*
        pub type $alias<T> = Item<T, $marker>;
    )*};
}
dirs! {
    /// An input pin.
    In, DirIn, IN, abi::access::READ;
    /// An input pin that the component corrects (a wrong scale, a frequency out of range).
    InSet, DirInSet, IN, abi::access::READ, Write;
    /// An output pin.
    Out, DirOut, OUT, abi::access::WRITE, Write;
    /// A bidirectional pin.
    Io, DirIo, IO, abi::access::READ | abi::access::WRITE, Write;
    /// A parameter that the component reports.
    ParamRo, DirRo, RO, abi::access::WRITE, Write;
    /// A parameter that the user sets; the component may correct it.
    ParamRw, DirRw, RW, abi::access::READ, Write;
}

impl<T: Value, D: Dir> Item<T, D> {
    /// Returns the current value.
    #[inline]
    #[must_use]
    pub fn get(&self) -> T {
        // SAFETY: the builder received this slot from the engine, whose arena outlives the
        // instance.
        T::from_bits(unsafe { Slot::cell(self.slot.as_ptr()) }.load())
    }

    /// Sets the value.
    #[inline]
    pub fn set(&self, value: T)
    where
        D: Write,
    {
        // SAFETY: as in `get`.
        unsafe { Slot::cell(self.slot.as_ptr()) }.store(value.to_bits());
    }

    pub(crate) const fn from_slot(slot: NonNull<Slot>) -> Self {
        Self { slot, kind: PhantomData }
    }

    pub(crate) const fn slot(&self) -> *const Slot {
        self.slot.as_ptr()
    }
}

impl<T: Value> InSet<T> {
    /// Sets the pin's own value, which it has while it is not linked. The value of a linked signal
    /// does not change.
    #[inline]
    pub fn set_own(&self, value: T) {
        // SAFETY: the builder received this slot from the engine, whose arena outlives the
        // instance.
        unsafe { self.slot.as_ref() }.own().store(value.to_bits());
    }
}

impl<T: Value, D: Dir> Touch for Item<T, D> {
    fn touch(&self, uses: &mut Uses) {
        uses.item(self.slot(), D::ACCESS);
    }
}

/// A field that `#[derive(Component)]` can create: a pin, a parameter, or a list of them.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a pin or parameter",
    label = "use `In`, `Out`, `Io`, `ParamRo` or `ParamRw`, or mark the field `#[state]`"
)]
pub trait Field: Sized {
    /// Value of the pin or parameter.
    type Value: Value;
    /// Type code.
    const TYPE: u8;
    /// Direction code.
    const DIR: u8;
    /// Creates the pin or parameter.
    ///
    /// # Errors
    /// As [`Builder::item`].
    fn make(b: &mut Builder<'_>, decl: Decl<'_>, initial: Self::Value) -> Result<Self, Error>;
}

impl<T: Value, D: Dir> Field for Item<T, D> {
    type Value = T;
    const TYPE: u8 = T::TYPE;
    const DIR: u8 = D::CODE;
    fn make(b: &mut Builder<'_>, decl: Decl<'_>, initial: T) -> Result<Self, Error> {
        b.declare(decl, initial)
    }
}

/// State that `#[derive(Component)]` can initialize: every type with a [`Default`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say how it begins",
    label = "write `#[hal(default = …)]` above the field, or `#[derive(Default)]` above `{Self}`"
)]
pub trait Begins {
    /// Returns the initial state.
    fn begin() -> Self;
}

#[diagnostic::do_not_recommend]
impl<T: Default> Begins for T {
    fn begin() -> Self {
        Self::default()
    }
}
