//! A dynamic library that exports no descriptor.

/// Something that is exported all the same.
#[unsafe(no_mangle)]
pub extern "C" fn nothing_of_interest() -> i32 {
    0
}
