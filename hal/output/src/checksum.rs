//! The checksum of records and files: the 64-bit hash FNV-1a of Fowler, Noll and Vo.
//!
//! A change of one byte always changes it. It finds damage, and it does not protect from forgery.

/// Offset and prime of the hash.
const FNV: (u64, u64) = (0xcbf2_9ce4_8422_2325, 0x0100_0000_01b3);

/// The checksum of bytes that come in parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Checksum(u64);

impl Default for Checksum {
    fn default() -> Self {
        Self(FNV.0)
    }
}

impl Checksum {
    /// Adds bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(FNV.1);
        self.0 = bytes.iter().fold(self.0, step);
    }

    /// Returns the value.
    pub fn value(self) -> u64 {
        self.0
    }
}

/// Returns the checksum of bytes.
pub fn of(bytes: &[u8]) -> u64 {
    let mut sum = Checksum::default();
    sum.add(bytes);
    sum.value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_published_one() {
        for (text, sum) in [("", 0xcbf2_9ce4_8422_2325), ("foobar", 0x8594_4171_f739_67e8)] {
            assert_eq!(of(text.as_bytes()), sum, "{text}");
            let mut parts = Checksum::default();
            text.bytes().for_each(|byte| parts.add(&[byte]));
            assert_eq!(parts.value(), sum, "{text} in parts");
        }
    }
}
