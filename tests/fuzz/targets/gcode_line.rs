//! Lines of G-code.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::gcode::lines(bytes));
