//! A dynamic library that exports no descriptor.

/// Another exported symbol.
#[unsafe(no_mangle)]
pub extern "C" fn nothing_of_interest() -> i32 {
    0
}
