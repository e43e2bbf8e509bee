//! What a library offers, in a form that is read from its file: plain bytes, which no relocation
//! touches, so that nothing of the library has to run.
//!
//! The bytes are texts, each ended by a zero: [`VERSION`], then one text for each name, with a letter
//! in front that says what it names.
#![expect(
    clippy::indexing_slicing,
    reason = "the compiler evaluates it, and refuses what is out of range"
)]

/// The first text, which names the format.
pub const VERSION: &str = "hal-names 1";
/// In front of the name of a component type.
pub const COMPONENT: u8 = b'c';
/// In front of the symbol by which a [`ForeignLoader`](crate::ForeignLoader) knows its files.
pub const LOADER: u8 = b'l';
/// The most bytes that an engine reads.
pub const MAX_LEN: usize = 1 << 20;

/// The number of bytes for these names.
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

/// The bytes for these names; `N` is what [`len`] says.
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

/// Puts a text and the zero that ends it at `at`; returns where the next one begins.
const fn append<const N: usize>(out: &mut [u8; N], at: usize, text: &[u8]) -> usize {
    let mut i = 0;
    while i < text.len() {
        out[at + i] = text[i];
        i += 1;
    }
    at + i + 1
}

/// Returns every name in such bytes with its letter; nothing if they are of another format.
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
