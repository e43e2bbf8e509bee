//! Files of recordings.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::trace(bytes));
