//! Requests of a client on the socket.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| hal_tests::fuzz::protocol(bytes));
