//! The page through which a client exchanges the values of its pins with the engine.
//!
//! The page has two halves. Each is a [`Page`] of two words for each pin: a value, and a number of
//! writes. The engine writes the first half: the value of the pin, and the number of the client's
//! writes that are part of it. The client writes the second half: its latest value, and how often it
//! has written one. A side never reads its own half, keeps all sizes privately, and never waits for
//! the other side. No word of the other side is an index or a size.

use crate::stream::Mapping;
use core::ffi::c_void;
use hal_abi::{PAGE_MAGIC, Page, PageWriter, seqlock};
use serde::{Deserialize, Serialize};
use std::{os::fd::OwnedFd, sync::atomic::Ordering};

/// Largest number of pins in a page.
pub const MAX_PAGE_PINS: u32 = 1 << 15;
/// Attempts to read a value while the engine writes its half. Then the value that was read last is used: a word is
/// never half written.
const ATTEMPTS: usize = 1000;

/// Description of a page.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PinPageInfo {
    /// Number of pins that fit.
    pub pins: u32,
    /// True if the instance runs on the virtual clock, where values are exchanged while the client sleeps.
    pub is_virtual: bool,
}

impl PinPageInfo {
    /// Returns the offset of the second half, in bytes.
    #[must_use]
    pub const fn second(&self) -> usize {
        Page::bytes(self.pins * 2).next_multiple_of(4096)
    }

    /// Returns the number of bytes of the page.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        self.second() * 2
    }
}

/// Value of a pin that this client has written, and how often.
#[derive(Clone, Copy, Debug, Default)]
struct Written {
    bits: u64,
    count: u64,
}

/// A client's page of pin values.
#[derive(Debug)]
pub struct PinPage {
    info: PinPageInfo,
    written: Vec<Written>,
    engine: *const Page,
    own: PageWriter,
    // Last field, because `engine` and `own` point into it.
    #[expect(dead_code, reason = "held so that the page stays mapped")]
    mapping: Mapping,
}

// SAFETY: the mapping belongs to this value, and its words are atomics.
unsafe impl Send for PinPage {}

impl PinPage {
    /// Maps the page that the engine sent. Values of `before`, the page that it replaces, are
    /// written to the new page.
    ///
    /// # Errors
    /// The file descriptor is not such a page.
    pub fn map(fd: &OwnedFd, info: PinPageInfo, before: Option<&Self>) -> Result<Self, String> {
        if !(1..=MAX_PAGE_PINS).contains(&info.pins) {
            return Err(format!("a page has 1 to {MAX_PAGE_PINS} pins"));
        }
        let mapping = Mapping::writable(fd, info.bytes(), "page")?;
        let engine = mapping.address().cast::<Page>();
        let own = mapping.address().wrapping_byte_add(info.second());
        // SAFETY: mapped; the magic is the first word.
        if unsafe { engine.cast::<u64>().read() } != PAGE_MAGIC {
            return Err("this is not a page of pins".into());
        }
        // SAFETY: the second half of the mapping; this client is its only writer.
        let own = unsafe { PageWriter::new(own.cast::<Page>(), info.pins * 2) };
        let written = before.map(|page| page.written.clone()).unwrap_or_default();
        let mut page = Self { info, written, engine, own, mapping };
        page.written.resize(page.info.pins as usize, Written::default());
        page.put_all();
        Ok(page)
    }

    /// Returns the description of the page.
    #[must_use]
    pub const fn info(&self) -> &PinPageInfo {
        &self.info
    }

    fn put_all(&mut self) {
        self.own.put(|words| {
            for (pair, written) in words.as_chunks().0.iter().zip(&self.written) {
                let [value, count] = pair;
                value.store(written.bits, Ordering::Relaxed);
                count.store(written.count, Ordering::Relaxed);
            }
        });
    }

    /// Writes the value of a pin, by the index of its creation. Returns false if the page has no
    /// such pin.
    #[inline]
    pub fn set(&mut self, pin: usize, bits: u64) -> bool {
        let Some(written) = self.written.get_mut(pin) else { return false };
        written.bits = bits;
        written.count = written.count.wrapping_add(1);
        let Written { bits, count } = *written;
        self.own.put(|words| {
            if let (Some(value), Some(number)) = (words.get(2 * pin), words.get(2 * pin + 1)) {
                value.store(bits, Ordering::Relaxed);
                number.store(count, Ordering::Relaxed);
            }
        });
        true
    }

    /// Returns the value that this client wrote last to a pin, or `None` if it has not written it.
    #[inline]
    #[must_use]
    pub fn own(&self, pin: usize) -> Option<u64> {
        self.written.get(pin).filter(|written| written.count > 0).map(|written| written.bits)
    }

    /// Returns the value of a pin: the value that the client has written if the engine has not taken it yet,
    /// otherwise the one that the engine has published. Returns zero if the page has no such pin.
    #[inline]
    #[must_use]
    pub fn get(&self, pin: usize) -> u64 {
        let Some(written) = self.written.get(pin) else { return 0 };
        // SAFETY: mapped with this number of words as long as `self` lives.
        let words = unsafe { Page::words(self.engine, self.info.pins * 2) };
        let (Some(value), Some(number)) = (words.get(2 * pin), words.get(2 * pin + 1)) else {
            return 0;
        };
        // SAFETY: as above.
        let sequence = unsafe { &(*self.engine).sequence };
        let load = || (value.load(Ordering::Relaxed), number.load(Ordering::Relaxed));
        let mut latest = load();
        for _ in 0..ATTEMPTS {
            if seqlock::read(sequence, || latest = load()).is_some() {
                break;
            }
            core::hint::spin_loop();
        }
        let (bits, count) = latest;
        if count == written.count { bits } else { written.bits }
    }

    /// Returns the address of the mapping, for tests of clients that write anything to it.
    #[doc(hidden)]
    #[must_use]
    pub fn address(&self) -> *mut c_void {
        self.engine.cast_mut().cast()
    }
}
