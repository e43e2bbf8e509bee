//! Descriptors that an engine must refuse. Each is found when this file is copied to the name that
//! its symbol ends in: `libmajor.so` exports `hal_library_major`.

use hal_abi::{
    ABI_MAJOR, ABI_MINOR, ComponentType, Host, Library, List, Status, Str, panic_strategy, size,
};

/// # Safety
/// Never called with anything.
unsafe extern "C" fn create(_: *const Host) -> Status {
    Status::OK
}

/// A component type with nothing wrong.
const fn good(name: &'static str) -> ComponentType {
    ComponentType {
        size: size::<ComponentType>(),
        flags: 0,
        name: Str::new(name),
        doc: Str::new("Nothing."),
        args: List::EMPTY,
        items: List::EMPTY,
        create: Some(create),
    }
}

/// A library with nothing wrong but what is changed in it.
const fn library(list: &'static [&'static ComponentType]) -> Library {
    Library {
        size: size::<Library>(),
        abi_major: ABI_MAJOR,
        abi_minor: ABI_MINOR,
        panic: panic_strategy::UNWIND,
        components: List::new(list),
        loaders: List::EMPTY,
    }
}

macro_rules! library {
    ($($(#[$doc:meta])* $name:ident = $library:expr;)*) => {$(
        $(#[$doc])*
        #[unsafe(export_name = concat!("hal_library_", stringify!($name)))]
        pub static $name: Library = $library;
    )*};
}

#[expect(non_upper_case_globals, reason = "the names of the files")]
mod libraries {
    use super::*;

    library! {
        /// Of the next major version.
        major = Library { abi_major: ABI_MAJOR + 1, ..library(&[&good("major")]) };
        /// Of a minor version that does not exist yet.
        minor = Library { abi_minor: ABI_MINOR + 1, ..library(&[&good("minor")]) };
        /// Shorter than any release had it.
        cut = Library { size: 16, ..library(&[&good("cut")]) };
        /// Does not say how it panics.
        mute = Library { panic: 0, ..library(&[&good("mute")]) };
        /// Has a component type that is shorter than any release had it.
        stub = library(&[&ComponentType { size: 8, ..good("stub") }]);
        /// Has a component type without a name.
        nameless = library(&[&ComponentType { name: Str::NONE, ..good("") }]);
        /// Has a component type without code.
        hollow = library(&[&ComponentType { create: None, ..good("hollow") }]);
        /// Has no component type at all.
        bare = library(&[]);
        /// Is of a later minor of which an older engine knows only the beginning: to be accepted.
        longer = Library { size: size::<Library>() + 64, ..library(&[&good("longer")]) };
    }
}

/// A descriptor whose list of component types holds a null pointer.
#[repr(C)]
struct Raw {
    head: [u32; 4],
    list: *const *const ComponentType,
    len: usize,
}

// SAFETY: immutable.
unsafe impl Sync for Raw {}

static NULLS: [usize; 2] = [0, 0];

/// Lists two component types, both null.
#[unsafe(export_name = "hal_library_nulls")]
static NULL_TYPES: Raw = Raw {
    head: [size_of::<Raw>() as u32, ABI_MAJOR, ABI_MINOR, panic_strategy::UNWIND],
    list: (&raw const NULLS).cast(),
    len: 2,
};

/// Names a component type with bytes that are no text.
#[repr(C)]
struct Text {
    ptr: *const u8,
    len: usize,
}

const _: () = assert!(size_of::<Text>() == size_of::<Str>());

static LATIN: ComponentType = {
    static BYTES: [u8; 3] = [0xe4, 0xf6, 0xfc];
    let text = Text { ptr: (&raw const BYTES).cast(), len: 3 };
    // SAFETY: a `Str` is a pointer and a length.
    let name = unsafe { core::mem::transmute::<Text, Str>(text) };
    ComponentType { name, ..good("latin") }
};

/// Names a component type with bytes that are no text.
#[unsafe(export_name = "hal_library_latin")]
static LATIN_LIBRARY: Library = library(&[&LATIN]);
