//! Realtime. Bytes in the words of a plain record.

/// Returns bytes as words, the first byte in the lowest one of a word. Bytes that are missing are 0; those beyond the words
/// are left out.
pub(crate) fn words<const N: usize>(bytes: &[u8]) -> [u64; N] {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks(8)) {
        *word = bytes.iter().rev().fold(0, |all, byte| all << 8 | u64::from(*byte));
    }
    words
}

/// Returns the bytes of words.
pub(crate) fn bytes(words: &[u64]) -> impl Iterator<Item = u8> {
    words.iter().flat_map(|word| word.to_le_bytes())
}
