//! Input devices of Linux: gamepads, keyboards, shuttles and pulse wheels, by the kernel's event interface.
//!
//! The argument `devices` becomes a list of `spec`s, which choose devices of a `bus`: those of the `kernel`, or
//! `simulated` ones, which `described` describes as text. A worker (`worker`) reads their events (`event`), keeps the
//! state of each (`reader`) and finds a device again that was lost. The function or the background task (`show`)
//! sets the pins; it alone decides what a lost device and a device that came back mean. `codes` has the names.
//!
//! A new kind of device is data: a block in `devices.txt`.
#![deny(unsafe_code)]

mod bus;
mod codes;
mod described;
mod event;
mod hal_input;
#[expect(unsafe_code, reason = "device requests are the system's, not the language's")]
mod kernel;
mod pins;
mod reader;
mod refused;
mod show;
mod simulated;
mod spec;
mod worker;

#[cfg(test)]
mod tests;

hal_component::export!(hal_input::HalInput);
