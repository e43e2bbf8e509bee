//! The bytes in the cable between a handheld and its controller, without HAL: state machines over bytes and times.
//!
//! | module | subject |
//! |---|---|
//! | `keys` | sets of keys, and the names of the NK105's keys |
//! | `frame` | frames of keys with their check byte, and their reader |
//! | `keypad` | physical and virtual keys together |
//! | `line` | lines of text that press keys |
//! | [`st7920`] | the serial protocol of the ST7920, decoded and written |
//! | `screen` | whole screens after a quiet time, and their readers |
#![forbid(unsafe_code)]

pub mod frame;
pub mod keypad;
pub mod keys;
pub mod line;
pub mod screen;
pub mod st7920;

pub use frame::{Check, FrameFormat, FrameReader, WrongFormat};
pub use keypad::{Keypad, Press};
pub use keys::KeySet;
pub use line::{BadLine, LineReader};
pub use screen::{RECORD_LEN, ScreenReader, Screens, TEXT_LEN};
pub use st7920::{Decode, St7920};
