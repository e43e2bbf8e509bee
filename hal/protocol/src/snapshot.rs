//! Snapshots: the latest record that a component publishes, described, as values, and mapped into
//! this process.

use crate::{Type, Value, stream::Mapping};
use hal_abi::{PAGE_MAGIC, Page, PageReader};
use rustix::mm::ProtFlags;
use serde::{Deserialize, Serialize};
use std::{os::fd::OwnedFd, thread, time::Duration};

/// Number of times that a record is read at once while its component replaces it.
const AT_ONCE: u32 = 100;
/// Number of further reads, each after a wait, and that wait: together a second.
const WAITS: u32 = 5000;
const WAIT: Duration = Duration::from_micros(200);

/// A field of a snapshot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FieldInfo {
    /// Name of the field.
    pub name: String,
    /// Type of its values.
    pub ty: Type,
    /// Number of values: 1, or the length of an array.
    pub count: u32,
    /// Description.
    pub doc: String,
}

/// A snapshot that a component publishes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SnapshotInfo {
    /// Name of the snapshot.
    pub name: String,
    /// Name of the component that publishes it.
    pub owner_name: String,
    /// Version of the record. It changes when a field changes or is removed.
    pub version: u32,
    /// Description. The first line is a summary.
    pub doc: String,
    /// Fields of the record, in order. Each value takes eight bytes of the page.
    pub fields: Vec<FieldInfo>,
}

/// The latest record of a snapshot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SnapshotValues {
    /// Description of the snapshot.
    pub info: SnapshotInfo,
    /// Number of records published so far.
    pub records: u64,
    /// Values of each field.
    pub values: Vec<Vec<Value>>,
}

/// A snapshot's page, mapped into this process for reading.
#[derive(Debug)]
pub struct Snapshot {
    info: SnapshotInfo,
    reader: PageReader,
    // Last field, because the reader points into it and must be dropped first.
    #[expect(dead_code, reason = "held so that the page stays mapped")]
    mapping: Mapping,
}

// SAFETY: the mapping belongs to this value, and its words are only loaded.
unsafe impl Send for Snapshot {}

impl Snapshot {
    /// Maps the page that the engine sent with this description.
    ///
    /// # Errors
    /// The file descriptor is not such a page.
    pub fn map(fd: &OwnedFd, info: SnapshotInfo) -> Result<Self, String> {
        let words = info.fields.iter().try_fold(0_u32, |sum, f| sum.checked_add(f.count));
        let words = words.ok_or("the record is too long")?;
        let mapping = Mapping::sealed(fd, Page::bytes(words), ProtFlags::READ, "page")?;
        let page = mapping.address().cast::<Page>();
        // SAFETY: the mapping is longer than the header, of which only atomics change.
        let head = unsafe { &*page };
        if head.magic != PAGE_MAGIC || head.version != info.version {
            return Err("this is not the page of this snapshot".into());
        }
        // SAFETY: mapped for as long as this value lives, with this number of words.
        let reader = unsafe { PageReader::new(page, words) };
        Ok(Self { info, reader, mapping })
    }

    /// Returns the description of the snapshot.
    #[must_use]
    pub const fn info(&self) -> &SnapshotInfo {
        &self.info
    }

    /// Puts the values of the latest record into `out`, field after field, and returns the number
    /// of records published so far. Returns `None` if the component was writing a record at that
    /// moment, and leaves `out` empty: try again.
    pub fn read(&self, out: &mut Vec<Value>) -> Option<u64> {
        out.clear();
        let types = self.info.fields.iter();
        let mut types = types.flat_map(|f| (0..f.count).map(|_| f.ty));
        let sequence = self.reader.copy(|_, bits| {
            if let Some(ty) = types.next() {
                out.push(Value::from_bits(ty, bits));
            }
        });
        if sequence.is_none() {
            out.clear();
        }
        sequence.map(|n| n / 2)
    }

    /// Reads as [`read`](Self::read) does, and waits while the component writes a record: the system may have suspended it in
    /// the middle. Returns `None` after a second.
    pub fn wait(&self, out: &mut Vec<Value>) -> Option<u64> {
        (0..AT_ONCE + WAITS).find_map(|n| {
            if n >= AT_ONCE {
                thread::park_timeout(WAIT);
            }
            self.read(out)
        })
    }

    /// Returns a field of words as text: eight bytes in each, the first lowest. It ends at the first byte that is 0.
    #[must_use]
    pub fn text(words: &[Value]) -> String {
        let bytes = words.iter().flat_map(|word| word.bits().to_le_bytes());
        let bytes: Vec<u8> = bytes.take_while(|byte| *byte != 0).collect();
        String::from_utf8_lossy(&bytes).into_owned()
    }
}

#[cfg(test)]
mod tests {
    //! Texts in words.

    use super::{Snapshot, Value};

    #[test]
    fn words_become_the_text_before_the_first_zero() {
        for (words, text) in [
            (&[][..], ""),
            (&[b"part.ngc", b"\0after\0\0"], "part.ngc"),
            (&[b"pi\xc3\xa9ce n", b"o 1\0\0\0\0\0"], "pi\u{e9}ce no 1"),
            (&[b"a\xff b\0c\0\0"], "a\u{fffd} b"),
            (&[b"12345678"], "12345678"),
        ] {
            let words: Vec<Value> = words
                .iter()
                .map(|word: &&[u8; 8]| Value::U64(u64::from_le_bytes(**word)))
                .collect();
            assert_eq!(Snapshot::text(&words), text);
        }
    }
}
