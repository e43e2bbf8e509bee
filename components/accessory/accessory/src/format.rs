//! Arguments that describe the frames of a handheld, the same for both ends of its cable.

use hal_component::{Arg, Builder, Error, abi::ArgSpec};
use hal_handheld::{Check, FrameFormat};

/// Argument `period`.
pub(crate) const PERIOD: ArgSpec =
    Arg::float("period", "Time between two frames.").or("20").within(2.0, 1000.0).unit("ms");
/// Argument `header`.
pub(crate) const HEADER: ArgSpec =
    Arg::int("header", "First byte of a frame.").or("0xA5").within(0.0, 255.0);
/// Argument `size`.
pub(crate) const SIZE: ArgSpec = Arg::int("size", "Length of a frame with header and check byte.")
    .or("8")
    .within(3.0, 16.0)
    .unit("bytes");
/// Argument `check`.
pub(crate) const CHECK: ArgSpec =
    Arg::text("check", "Check byte: crc8 (polynomial 0x07), sum or xor.").or("crc8");
/// Argument `map`.
pub(crate) const MAP: ArgSpec =
    Arg::ints("map", "Bit in the bitmap of each key, from key 1 on; without it, key 1 is bit 0.")
        .at_most(48);

/// Returns the format of the frames.
pub(crate) fn format(b: &Builder<'_>) -> Result<FrameFormat, Error> {
    let name = b.arg_text("check").unwrap_or_default();
    let check = Check::named(&name)
        .ok_or_else(|| Error::new(format!("check is {name}, must be crc8, sum or xor")))?;
    let number = |name| b.arg_int(name).unwrap_or_default();
    let made = FrameFormat::new(number("header"), number("size"), check, &b.arg_ints("map"));
    made.map_err(|why| Error::new(format!("the format of the frames: {why}")))
}
