//! The account that a hostmot2 firmware gives of itself, as the driver reads it and as the simulated card writes it.
//!
//! | address | contents |
//! |---|---|
//! | 0x100 | [`COOKIE`] |
//! | 0x104, 0x108 | `HOSTMOT2`, eight letters |
//! | 0x10C | address of the [`Identification`] |
//! | its `modules` | a [`Module`] of 12 bytes each, up to one whose tag is 0 |
//! | its `pins` | a [`Pin`] of 4 bytes for each I/O pin |
//!
//! [`Tag`] names the kinds of modules, and [`registers`] the registers of each: documentation, driver and simulation use
//! the same table. Without `std` and `alloc`.
//!
//! Sources: the register map that Mesa publishes with the firmware, Mesa's manuals of the cards, and what cards answer.
#![no_std]
#![forbid(unsafe_code)]

mod idrom;
mod module;
mod names;
mod pin;
pub mod registers;
mod tag;

pub use idrom::{BadIdentification, Identification};
pub use module::{Clock, Module};
pub use names::PinName;
pub use pin::Pin;
pub use registers::Register;
pub use tag::Tag;

/// Value of the register at [`COOKIE_AT`].
pub const COOKIE: u32 = 0x55AA_CAFE;

/// Address of the cookie.
pub const COOKIE_AT: u16 = 0x100;

/// Letters of the registers at [`COOKIE_AT`] + 4 and + 8.
pub const NAME: [u8; 8] = *b"HOSTMOT2";

/// Address of the register that holds the address of the [`Identification`].
pub const IDENTIFICATION_AT: u16 = 0x10C;

/// Most modules of a firmware.
pub const MAX_MODULES: usize = 32;

/// Most I/O pins of a firmware.
pub const MAX_PINS: usize = 144;
