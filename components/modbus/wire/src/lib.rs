//! Frames of Modbus RTU and TCP, and of Huanyang's inverters.
//!
//! | module | subject |
//! |---|---|
//! | `request` | Modbus: what a master asks, and its frames |
//! | `answer` | Modbus: what a device answers, found in the bytes that have come |
//! | `exception` | Modbus: why a device refuses a request |
//! | `huanyang` | the same for Huanyang's inverters, whose frames only look like Modbus |
//! | `miss` | why the bytes that have come are no answer |
//! | `crc` | the check sum of all frames on serial lines |
//! | `silence` | times without bytes that separate frames |
//!
//! Nothing here has a clock or a line. A master keeps the bytes that came since its request, and asks [`find_rtu`],
//! [`find_tcp`] or [`huanyang::find`] after each piece whether the answer is among them. At its deadline it asks
//! [`Miss::of_rtu`] or [`huanyang::miss`] what came instead. No bytes whatever make these functions panic.
#![forbid(unsafe_code)]

mod answer;
mod crc;
mod exception;
pub mod huanyang;
mod miss;
mod request;
mod silence;
#[cfg(test)]
mod tests;

pub use answer::{ModbusAnswer, find_rtu, find_tcp};
pub use crc::{crc, is_whole, push_crc};
pub use exception::Exception;
pub use miss::Miss;
pub use request::{BadRequest, Call, ModbusRequest, ModbusTable};
pub use silence::{HUANYANG_SILENCE_NS, char_ns, nanoseconds, silence_ns};
