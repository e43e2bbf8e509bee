//! GPIO lines of Linux, by version 2 of the interface of its character devices.
//!
//! The arguments become a `config`, whose lines are found on the `chips` and requested as few times as possible
//! (`request`). The functions access a `device`, whose lines are real or simulated behind the trait
//! [`port::Lines`]. The kernel is accessed in `kernel`, the only module with unsafe code: it needs five device requests
//! and one read, with which a cycle neither allocates nor waits.
#![deny(unsafe_code)]

mod chips;
mod config;
mod device;
mod encoder;
mod functions;
mod gpio;
#[expect(unsafe_code, reason = "device requests are the system's, not the language's")]
mod kernel;
mod label;
mod pi;
mod refused;
mod request;
#[cfg(test)]
mod tests;

hal_component::export!(gpio::HalGpio, pi::PiGpio);
