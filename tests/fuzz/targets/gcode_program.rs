//! G-code programs.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::gcode::program(bytes));
