//! Lines of a script, executed on a held clock.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::script(bytes));
