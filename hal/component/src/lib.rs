//! Library for authors of components.
//!
//! A plain component is a struct of pins, parameters and state that implements [`Update`]:
//!
//! ```
//! use hal_component::{Component, In, Out, Period, Update};
//!
//! /// Two-input AND gate.
//! #[derive(Component)]
//! struct And2 {
//!     /// First input.
//!     in0: In<bool>,
//!     /// Second input.
//!     in1: In<bool>,
//!     /// True when both inputs are.
//!     out: Out<bool>,
//! }
//!
//! impl Update for And2 {
//!     fn update(&mut self, _: Period) {
//!         self.out.set(self.in0.get() && self.in1.get());
//!     }
//! }
//!
//! hal_component::export!(And2);
//! ```
//!
//! A component whose pins depend on `loadrt` arguments, or that has several functions, implements
//! [`Component`] by hand and declares everything through the [`Builder`]. Its functions are structs
//! with `#[derive(Touch)]`, which tells the engine what each function reads and writes.

#![expect(unsafe_code, reason = "one of the crates that keep the binary contract")]

// The derive macros name this crate as its users do.
extern crate self as hal_component;

mod args;
mod builder;
mod call;
mod channels;
mod decl;
mod exchange;
mod homing;
mod interlock;
mod iocontrol;
mod item;
mod kinematics;
mod measured;
mod motion;
mod motion_status;
mod number;
mod operator;
mod outside;
mod pins;
mod plain;
mod port;
mod ring;
mod service;
mod share;
mod shim;
mod snapshot;
mod solved;
mod still;
mod stream;
mod sync;
mod texts;
mod wait;
mod worker;

pub use args::Arg;
pub use builder::Builder;
pub use call::{Call, Clock, Failures, HalValues, Hardware, Messages, TicketHandle};
pub use channels::Channels;
pub use decl::{Decl, Error};
pub use exchange::{RingReader, RingWriter, SeqReader, SeqWriter};
#[doc(hidden)]
pub use hal_abi as abi;
pub use hal_abi::{
    MotionCommand, OperatorView, motion_flags, motion_kind, motion_setting, motion_source,
};
pub use hal_derive::{Component, Plain, Touch};
pub use homing::{HomingRef, HomingState};
pub use interlock::{Estop, Interlock, InterlockRef};
pub use iocontrol::{IoControl, IoControlRef, IoRequest, IoResult, IoState};
#[doc(hidden)]
pub use item::Begins;
pub use item::{Field, In, InSet, Io, Item, Out, ParamRo, ParamRw, Value, Write};
pub use kinematics::{Kinematics, KinematicsKind, KinematicsRef, Pose};
pub use motion::{
    Motion, MotionEnd, MotionId, MotionRef, MotionRefusal, MotionSource, MotionToken, StopEpoch,
};
pub use motion_status::MotionStatus;
pub use number::{divisor, to_s32};
pub use operator::{Operator, OperatorRef, OperatorRequest};
#[doc(hidden)]
pub use pins::{pin_doc, pin_name};
#[doc(hidden)]
pub use plain::field as plain_field;
pub use plain::{Plain, PlainField, fields};
pub use port::Port;
pub use share::{Gives, Receiver, Sender, Takes, Touch, Uses};
#[doc(hidden)]
pub use shim::create;
pub use snapshot::{Snapshot, SnapshotReader};
pub use solved::{Solution, Solved, Unsolved, Ways};
pub use still::StillWatch;
pub use stream::{StreamIn, StreamOut};
pub use texts::{Texts, lasting};
pub use wait::Wait;
pub use worker::Work;

/// Nominal period of a thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period(i64);

impl Period {
    /// Returns a period of `ns` nanoseconds.
    pub const fn from_ns(ns: i64) -> Self {
        Self(ns)
    }

    /// Returns the period in nanoseconds.
    #[inline]
    pub const fn ns(self) -> i64 {
        self.0
    }

    /// Returns the period in seconds.
    #[inline]
    pub fn secs(self) -> f64 {
        self.0 as f64 * 1e-9
    }
}

/// Code of a HAL function or background task.
///
/// A function runs in a realtime thread: it must not lock, allocate, do I/O or print. It logs
/// messages through [`Messages`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no `Update`: a function needs code to run",
    label = "write `impl Update for {Self} {{ fn update(&mut self, period: Period) {{ … }} }}`"
)]
pub trait Update: Touch + Send + 'static {
    /// Runs once per period.
    fn update(&mut self, period: Period);
}

/// A component type.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a component",
    label = "write `#[derive(Component)]` above it, or implement `Component` by hand"
)]
pub trait Component: 'static {
    /// Name of the type, as in `loadrt NAME`.
    const NAME: &'static str;
    /// Description in Markdown. The first line is a summary.
    const DOC: &'static str;
    /// Bits of [`abi::component_flags`].
    const FLAGS: u32 = 0;
    /// Arguments of `loadrt` in addition to `count=`, `names=` and `personality=`.
    const ARGS: &'static [&'static abi::ArgSpec] = &[];
    /// Pins and parameters, if they are fixed.
    const ITEMS: &'static [&'static abi::ItemSpec] = &[];
    /// Declares an instance: first its pins and parameters, then its functions. Must not access
    /// anything outside; use [`Builder::on_open`] for that.
    ///
    /// # Errors
    /// An error of the engine, or an [`Error`] of the component's own.
    fn create(b: &mut Builder<'_>) -> Result<(), Error>;
}

/// Exports component types from this library.
#[macro_export]
macro_rules! export {
    ($($component:ty),+ $(,)?) => {
        /// Descriptor that the engine looks up.
        #[unsafe(export_name = concat!("hal_library_", env!("CARGO_CRATE_NAME")))]
        pub static HAL_LIBRARY: $crate::abi::Library = {
            const LIST: &[&$crate::abi::ComponentType] =
                &$crate::types::<{ HAL_DESCRIBED.len() }>(HAL_DESCRIBED);
            $crate::abi::Library {
                size: $crate::abi::size::<$crate::abi::Library>(),
                abi_major: $crate::abi::ABI_MAJOR,
                abi_minor: $crate::abi::ABI_MINOR,
                panic: if cfg!(panic = "unwind") {
                    $crate::abi::panic_strategy::UNWIND
                } else {
                    $crate::abi::panic_strategy::ABORT
                },
                components: $crate::abi::List::new(LIST),
                loaders: $crate::abi::List::EMPTY,
            }
        };

        /// Names of the component types, as the engine reads them from the file.
        #[unsafe(export_name = concat!("hal_names_", env!("CARGO_CRATE_NAME")))]
        pub static HAL_NAMES: [u8; HAL_NAMES_LEN] = $crate::abi::names::bytes(HAL_NAMES_OF);
        const HAL_NAMES_LEN: usize = $crate::abi::names::len(HAL_NAMES_OF);
        const HAL_NAMES_OF: &[(u8, &[&str])] = &[
            (
                $crate::abi::names::COMPONENT,
                &$crate::names::<{ HAL_DESCRIBED.len() }>(HAL_DESCRIBED),
            ),
            ($crate::abi::names::RELEASE, $crate::release_of(env!("CARGO_MANIFEST_DIR"))),
        ];
        // The only place that names the types, so that the compiler complains once of each.
        const HAL_DESCRIBED: &[$crate::Described] = &[$($crate::describe::<$component>()),+];
    };
}

/// A component type as [`export!`] writes it down: for the engine, and as plain bytes.
#[doc(hidden)]
#[derive(Debug)]
pub struct Described {
    ty: abi::ComponentType,
    name: &'static str,
}

/// Returns the types of `N` components.
#[doc(hidden)]
#[must_use]
#[expect(clippy::indexing_slicing, reason = "the compiler evaluates it")]
pub const fn types<const N: usize>(all: &'static [Described]) -> [&'static abi::ComponentType; N] {
    let mut out = [&all[0].ty; N];
    let mut i = 0;
    while i < N {
        out[i] = &all[i].ty;
        i += 1;
    }
    out
}

/// Returns the names of `N` components.
#[doc(hidden)]
#[must_use]
#[expect(clippy::indexing_slicing, reason = "the compiler evaluates it")]
pub const fn names<const N: usize>(all: &'static [Described]) -> [&'static str; N] {
    let mut out = [""; N];
    let mut i = 0;
    while i < N {
        out[i] = all[i].name;
        i += 1;
    }
    out
}

/// Returns the release of Ferrule, if the crate in this folder is in the source tree of this crate. Plugins of one tree
/// are made for each other and for its engine; a plugin of somebody else's needs the binary interface alone.
#[doc(hidden)]
#[must_use]
#[expect(clippy::indexing_slicing, reason = "the compiler evaluates it")]
pub const fn release_of(folder: &str) -> &'static [&'static str] {
    let (own, folder) = (env!("CARGO_MANIFEST_DIR").as_bytes(), folder.as_bytes());
    let tree = own.len() - "hal/component".len();
    if folder.len() < tree {
        return &[];
    }
    let mut i = 0;
    while i < tree {
        if folder[i] != own[i] {
            return &[];
        }
        i += 1;
    }
    &[env!("CARGO_PKG_VERSION")]
}

#[doc(hidden)]
#[must_use]
pub const fn describe<C: Component>() -> Described {
    Described { ty: describe_type::<C>(), name: C::NAME }
}

const fn describe_type<C: Component>() -> abi::ComponentType {
    abi::ComponentType {
        size: abi::size::<abi::ComponentType>(),
        flags: C::FLAGS,
        name: abi::Str::new(C::NAME),
        doc: abi::Str::new(C::DOC),
        args: abi::List::new(C::ARGS),
        items: abi::List::new(C::ITEMS),
        create: Some(create::<C>),
    }
}
