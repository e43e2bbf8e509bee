//! Reader for untrusted bytes: numbers, strings, compressed pieces.

use crate::Flaw;

/// Unread rest of a piece of a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a> {
    rest: &'a [u8],
}

impl<'a> Bytes<'a> {
    pub(super) const fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }

    pub(super) const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.rest.is_empty()
    }

    /// Takes the next `n` bytes.
    pub(super) fn take(&mut self, n: u64) -> Result<&'a [u8], Flaw> {
        let n = usize::try_from(n).map_err(|_| Flaw::Truncated)?;
        let (head, rest) = self.rest.split_at_checked(n).ok_or(Flaw::Truncated)?;
        self.rest = rest;
        Ok(head)
    }

    /// Takes the last `n` bytes.
    pub(super) fn take_end(&mut self, n: u64) -> Result<&'a [u8], Flaw> {
        let n = usize::try_from(n).map_err(|_| Flaw::Truncated)?;
        let at = self.rest.len().checked_sub(n).ok_or(Flaw::Truncated)?;
        let (rest, end) = self.rest.split_at_checked(at).ok_or(Flaw::Truncated)?;
        self.rest = rest;
        Ok(end)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Flaw> {
        self.take(1).map(|b| b.first().copied().unwrap_or(0))
    }

    pub(super) fn array(&mut self) -> Result<[u8; 8], Flaw> {
        self.take(8)?.try_into().map_err(|_| Flaw::Truncated)
    }

    pub(super) fn number(&mut self) -> Result<u64, Flaw> {
        self.array().map(u64::from_be_bytes)
    }

    /// Takes an unsigned number in groups of seven bits, lowest group first (LEB128).
    pub(super) fn groups(&mut self) -> Result<u64, Flaw> {
        let mut n = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            n |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(n);
            }
        }
        Err(Flaw::Unreadable("a number that is too long".into()))
    }

    /// Takes a signed number in groups of seven bits, lowest group first (LEB128).
    pub(super) fn signed_groups(&mut self) -> Result<i64, Flaw> {
        let mut n = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            n |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                if byte & 0x40 != 0 && shift < 57 {
                    n |= u64::MAX << (shift + 7);
                }
                return Ok(n.cast_signed());
            }
        }
        Err(Flaw::Unreadable("a number that is too long".into()))
    }

    /// Takes a zero-terminated string.
    pub(super) fn text(&mut self) -> Result<String, Flaw> {
        let end = self.rest.iter().position(|b| *b == 0).ok_or(Flaw::Truncated)?;
        let text = self.take(end as u64)?;
        self.byte()?;
        Ok(String::from_utf8_lossy(text).into_owned())
    }
}

fn length(said: u64, packed: usize, ratio: u64) -> Result<usize, Flaw> {
    // No compression exceeds this ratio, so a short input cannot cause a large allocation.
    let most = (packed as u64).saturating_mul(ratio).saturating_add(64);
    usize::try_from(said)
        .ok()
        .filter(|_| said <= most)
        .ok_or_else(|| Flaw::Unreadable("a packed piece of an impossible length".into()))
}

fn packed(kind: &'static str) -> Flaw {
    Flaw::Unreadable(format!("a piece that is not packed as {kind}").into())
}

/// Decompresses zlib data. With `plain`, data whose two lengths are equal is not compressed.
pub(super) fn zlib(bytes: &[u8], said: u64, plain: bool) -> Result<Vec<u8>, Flaw> {
    if plain && said == bytes.len() as u64 {
        return Ok(bytes.to_owned());
    }
    let limit = length(said, bytes.len(), 1032)?;
    let out = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(bytes, limit);
    out.ok().filter(|o| o.len() == limit).ok_or_else(|| packed("zlib"))
}

/// Decompresses a gzip file.
pub(super) fn gzip(bytes: &[u8], said: u64) -> Result<Vec<u8>, Flaw> {
    let limit = length(said, bytes.len(), 1032)?;
    let (head, body) = bytes.split_at_checked(10).ok_or(Flaw::Truncated)?;
    if !head.starts_with(&[0x1f, 0x8b, 8, 0]) {
        return Err(packed("gzip"));
    }
    let out = miniz_oxide::inflate::decompress_to_vec_with_limit(body, limit);
    out.ok().filter(|o| o.len() == limit).ok_or_else(|| packed("gzip"))
}

/// Decompresses LZ4 data.
pub(super) fn lz4(bytes: &[u8], said: u64) -> Result<Vec<u8>, Flaw> {
    let limit = length(said, bytes.len(), 256)?;
    let mut out = vec![0; limit];
    let n = lz4_flex::block::decompress_into(bytes, &mut out).map_err(|_| packed("LZ4"))?;
    if n == limit { Ok(out) } else { Err(packed("LZ4")) }
}

/// Decompresses `FastLZ` data.
pub(super) fn fastlz(bytes: &[u8], said: u64) -> Result<Vec<u8>, Flaw> {
    let limit = length(said, bytes.len(), 1 << 12)?;
    super::fastlz::unpack(bytes, limit).ok_or_else(|| packed("FastLZ"))
}
