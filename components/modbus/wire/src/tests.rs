//! Frames of the standard, of rmodbus, of LinuxCNC's programs, and random ones.
#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "random bytes")]

mod huanyang;
mod modbus;

/// Returns the bytes of a text such as `01 03`.
fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}
