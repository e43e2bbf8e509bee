//! The check sum of frames on serial lines.

/// CRC of no bytes.
pub(crate) const START: u16 = 0xFFFF;

/// Returns the CRC of bytes: polynomial 0xA001, first value 0xFFFF.
#[must_use]
pub fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(START, |crc, byte| with(crc, *byte))
}

/// Returns the CRC of bytes that have this CRC, and one more. It is 0 behind bytes that end with their own.
pub(crate) const fn with(crc: u16, byte: u8) -> u16 {
    let mut crc = crc ^ byte as u16;
    let mut bits = 0;
    while bits < 8 {
        crc = if crc & 1 == 0 { crc >> 1 } else { (crc >> 1) ^ 0xA001 };
        bits += 1;
    }
    crc
}

/// Appends the CRC, low byte first.
pub fn push_crc(frame: &mut Vec<u8>) {
    let sum = crc(frame);
    frame.extend(sum.to_le_bytes());
}

/// Returns whether bytes end with their CRC.
#[must_use]
pub fn is_whole(frame: &[u8]) -> bool {
    frame
        .split_last_chunk::<2>()
        .is_some_and(|(data, sum)| 2 <= data.len() && crc(data) == u16::from_le_bytes(*sum))
}
