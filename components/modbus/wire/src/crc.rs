//! The check sum of frames on serial lines.

/// Returns the CRC of bytes: polynomial 0xA001, first value 0xFFFF.
#[must_use]
pub fn crc(bytes: &[u8]) -> u16 {
    let mut crc = 0xFFFF_u16;
    for byte in bytes {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 0 { crc >> 1 } else { (crc >> 1) ^ 0xA001 };
        }
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
