//! C components: the interface that they are written for, and their loader.
//!
//! The library registers as the loader of files that export `rtapi_app_main`, opens them with global symbols and
//! immediate binding, and provides the functions of `include/hal.h` and `include/rtapi.h`. These are implemented with
//! the engine's ordinary plugin interface, so that a C pin is an ordinary pin.

#![expect(unsafe_code, reason = "the boundary to components in C")]

mod access;
mod arguments;
mod board;
mod capability;
mod docs;
mod dry_run;
mod elf;
mod funct;
mod homing;
mod kinematics;
mod load;
mod loading;
mod memory;
mod message;
mod module;
mod objects;
mod outside;
mod pin;
mod port;
mod registers;
mod running;
mod second_copy;
mod second_setup;
mod service;
mod shared;
mod spawn;
mod stream;
mod system;
mod task;
mod trap;
mod variadic;

use hal_component::abi::{
    ABI_MAJOR, ABI_MINOR, ForeignLoader, Library, List, Str, names, panic_strategy, size,
};

/// Symbol by which the loader recognises its files.
const SYMBOL: &str = "rtapi_app_main";

const LOADER: ForeignLoader = ForeignLoader {
    size: size::<ForeignLoader>(),
    flags: 0,
    symbol: Str::new(SYMBOL),
    kind: Str::new("component in C"),
    load: Some(load::load),
};

/// Descriptor that the engine looks up: no component types, one loader.
#[unsafe(export_name = "hal_library_compat")]
pub static HAL_LIBRARY: Library = {
    const LOADERS: &[&ForeignLoader] = &[&LOADER];
    Library {
        size: size::<Library>(),
        abi_major: ABI_MAJOR,
        abi_minor: ABI_MINOR,
        panic: if cfg!(panic = "unwind") { panic_strategy::UNWIND } else { panic_strategy::ABORT },
        components: List::EMPTY,
        loaders: List::new(LOADERS),
    }
};

/// Offered names, which the engine reads from the file without opening the library.
#[unsafe(export_name = "hal_names_compat")]
pub static HAL_NAMES: [u8; names::len(NAMES)] = names::bytes(NAMES);
const NAMES: &[(u8, &[&str])] =
    &[(names::LOADER, &[SYMBOL]), (names::RELEASE, &[env!("CARGO_PKG_VERSION")])];
