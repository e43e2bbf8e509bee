//! Realtime. Pages of shared memory that hold the latest record of a snapshot: a header and one 64-bit word for each value, under a seqlock.
//!
//! A page of `words` words takes [`Page::bytes`] bytes. Its memory is sealed, so that nobody can
//! shorten it. A side keeps the number of words privately and does not read it back.

use crate::{
    seqlock,
    sync::{AtomicU64, Ordering},
};

/// First word of every page ("halpage" and a version).
pub const PAGE_MAGIC: u64 = 0x0165_6761_706c_6168;
/// Largest number of words of a page.
pub const MAX_PAGE_WORDS: u32 = 1 << 16;

/// Header of a page, followed by its words.
#[repr(C, align(64))]
#[derive(Debug)]
pub struct Page {
    /// Always [`PAGE_MAGIC`].
    pub magic: u64,
    /// Version of the record, which its publisher chooses.
    pub version: u32,
    /// Number of words.
    pub words: u32,
    /// Sequence number of the seqlock: odd while the words are replaced, two more for each record.
    pub sequence: AtomicU64,
    reserved: [u64; 5],
}

const _: () = assert!(size_of::<Page>() == 64 && core::mem::offset_of!(Page, sequence) == 16);

impl Page {
    /// Returns the header of an empty page.
    pub const fn new(version: u32, words: u32) -> Self {
        let sequence = AtomicU64::new(0);
        Self { magic: PAGE_MAGIC, version, words, sequence, reserved: [0; 5] }
    }

    /// Returns the number of bytes of a page with this number of words.
    pub const fn bytes(words: u32) -> usize {
        size_of::<Self>() + words as usize * 8
    }

    /// Returns the words of a page.
    ///
    /// # Safety
    /// `page` must be the header of a live mapping of [`Page::bytes`] bytes, for as long as the
    /// result is used. The memory must be zeroed or hold words.
    pub unsafe fn words<'p>(page: *const Self, words: u32) -> &'p [AtomicU64] {
        // SAFETY: guaranteed by the caller: the words follow the header.
        let first = unsafe { page.add(1) }.cast::<AtomicU64>();
        // SAFETY: guaranteed by the caller; aligned like the header.
        unsafe { core::slice::from_raw_parts(first, words as usize) }
    }
}

/// Writing side of a page.
#[derive(Debug)]
pub struct PageWriter {
    page: *const Page,
    words: u32,
    number: u64,
}

// SAFETY: there is one writer, and everything shared is atomic.
unsafe impl Send for PageWriter {}

impl PageWriter {
    /// Returns the writing side of a page.
    ///
    /// # Safety
    /// As [`Page::words`], for as long as this value and its [readers](Self::reader) live, and
    /// without another writer.
    pub const unsafe fn new(page: *const Page, words: u32) -> Self {
        Self { page, words, number: 0 }
    }

    /// Replaces the record: `fill` stores the words.
    #[inline]
    pub fn put(&mut self, fill: impl FnOnce(&[AtomicU64])) {
        // SAFETY: the caller of `new` guarantees that the page is live.
        let sequence = unsafe { &(*self.page).sequence };
        seqlock::begin(sequence, self.number);
        // SAFETY: as above.
        fill(unsafe { Page::words(self.page, self.words) });
        seqlock::end(sequence, &mut self.number);
    }

    /// Returns a reading side.
    pub const fn reader(&self) -> PageReader {
        PageReader { page: self.page, words: self.words }
    }

    /// Returns the sequence number of the last record.
    pub const fn number(&self) -> u64 {
        self.number
    }
}

/// Reading side of a page.
#[derive(Debug)]
pub struct PageReader {
    page: *const Page,
    words: u32,
}

// SAFETY: a reader only loads atomics.
unsafe impl Send for PageReader {}
// SAFETY: as for `Send`.
unsafe impl Sync for PageReader {}

impl PageReader {
    /// Returns a reading side of a page.
    ///
    /// # Safety
    /// As [`Page::words`], for as long as this value lives.
    pub const unsafe fn new(page: *const Page, words: u32) -> Self {
        Self { page, words }
    }

    /// Copies the record and returns its sequence number, which is zero before the first record.
    /// Returns `None` if the writer was replacing it: try again. The values passed to `value` are
    /// then invalid.
    pub fn copy(&self, mut value: impl FnMut(usize, u64)) -> Option<u64> {
        // SAFETY: the caller of `new` guarantees that the page is live.
        let sequence = unsafe { &(*self.page).sequence };
        seqlock::read(sequence, || {
            // SAFETY: as above.
            let words = unsafe { Page::words(self.page, self.words) };
            for (i, word) in words.iter().enumerate() {
                value(i, word.load(Ordering::Relaxed));
            }
        })
    }
}
