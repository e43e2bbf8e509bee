//! Names that a library offers, in a form that can be read from its file: plain bytes without
//! relocations, so that no code of the library has to run.
//!
//! The bytes are zero-terminated strings: [`VERSION`], then one string for each name. The first
//! letter of each gives the kind of the name.
#![expect(
    clippy::indexing_slicing,
    reason = "the compiler evaluates it, and refuses what is out of range"
)]

/// First string, which identifies the format.
pub const VERSION: &str = "hal-names 1";
/// Prefix of the name of a component type.
pub const COMPONENT: u8 = b'c';
/// Prefix of the symbol by which a [`ForeignLoader`](crate::ForeignLoader) recognizes its files.
pub const LOADER: u8 = b'l';
/// Prefix of the release of Ferrule that the library is part of. A library of somebody else's has none.
pub const RELEASE: u8 = b'v';
/// Maximum number of bytes that an engine reads.
pub const MAX_LEN: usize = 1 << 20;

/// Returns the number of bytes for these names.
#[must_use]
pub const fn len(kinds: &[(u8, &[&str])]) -> usize {
    let mut total = VERSION.len() + 1;
    let mut kind = 0;
    while kind < kinds.len() {
        let names = kinds[kind].1;
        let mut i = 0;
        while i < names.len() {
            total += names[i].len() + 2;
            i += 1;
        }
        kind += 1;
    }
    total
}

/// Returns the bytes for these names. `N` must be the result of [`len`].
#[must_use]
pub const fn bytes<const N: usize>(kinds: &[(u8, &[&str])]) -> [u8; N] {
    let mut out = [0; N];
    let mut at = append(&mut out, 0, VERSION.as_bytes());
    let mut kind = 0;
    while kind < kinds.len() {
        let (letter, names) = kinds[kind];
        let mut i = 0;
        while i < names.len() {
            out[at] = letter;
            at = append(&mut out, at + 1, names[i].as_bytes());
            i += 1;
        }
        kind += 1;
    }
    out
}

/// Writes a string and its terminating zero at `at`. Returns the position after it.
const fn append<const N: usize>(out: &mut [u8; N], at: usize, text: &[u8]) -> usize {
    let mut i = 0;
    while i < text.len() {
        out[at + i] = text[i];
        i += 1;
    }
    at + i + 1
}

/// Returns every name with its prefix letter. Returns `None` if the bytes have another format.
pub fn parse(bytes: &[u8]) -> Option<impl Iterator<Item = (u8, &str)>> {
    let mut texts = bytes.strip_suffix(&[0])?.split(|b| *b == 0);
    if texts.next()? != VERSION.as_bytes() {
        return None;
    }
    Some(texts.filter_map(|text| {
        let (letter, name) = text.split_first()?;
        Some((*letter, core::str::from_utf8(name).ok()?))
    }))
}
