//! INI files, and look-ups of variables in them.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::ini(bytes));
