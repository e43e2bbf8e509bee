//! Snapshots: the latest record that a component publishes, described, as values, and mapped into
//! this process.

use crate::{Type, Value};
use hal_abi::{PAGE_MAGIC, Page, PageReader};
use rustix::{
    fs::{SealFlags, fcntl_get_seals, fstat},
    mm::{MapFlags, ProtFlags, mmap, munmap},
};
use serde::{Deserialize, Serialize};
use std::{
    ffi::c_void,
    os::fd::{AsFd, OwnedFd},
    ptr,
};

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
    address: *mut c_void,
    bytes: usize,
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
        let bytes = Page::bytes(words);
        let seals = fcntl_get_seals(fd).map_err(|e| e.to_string())?;
        if !seals.contains(SealFlags::SHRINK) {
            return Err("the page could be cut while it is read".into());
        }
        let size = fstat(fd).map_err(|e| e.to_string())?.st_size;
        if usize::try_from(size).unwrap_or(0) < bytes {
            return Err("the page is smaller than its record".into());
        }
        // SAFETY: this is a new shared mapping. The file is sealed against shrinking, as checked
        // above.
        let address = unsafe {
            mmap(ptr::null_mut(), bytes, ProtFlags::READ, MapFlags::SHARED, fd.as_fd(), 0)
        }
        .map_err(|e| e.to_string())?;
        let page = address.cast::<Page>().cast_const();
        // SAFETY: mapped for as long as this value lives, with this number of words.
        let reader = unsafe { PageReader::new(page, words) };
        let mapped = Self { info, reader, address, bytes };
        // SAFETY: the mapping is longer than the header, of which only atomics change.
        let head = unsafe { &*page };
        if head.magic != PAGE_MAGIC || head.version != mapped.info.version {
            return Err("this is not the page of this snapshot".into());
        }
        Ok(mapped)
    }

    /// Returns the description of the snapshot.
    #[must_use]
    pub const fn info(&self) -> &SnapshotInfo {
        &self.info
    }

    /// Puts the values of the latest record into `out`, field after field, and returns the number
    /// of records published so far. Returns `None` if the component was writing a record at that
    /// moment: try again.
    pub fn read(&self, out: &mut Vec<Value>) -> Option<u64> {
        out.clear();
        let types = self.info.fields.iter();
        let mut types = types.flat_map(|f| (0..f.count).map(|_| f.ty));
        let sequence = self.reader.copy(|_, bits| {
            if let Some(ty) = types.next() {
                out.push(Value::from_bits(ty, bits));
            }
        })?;
        Some(sequence / 2)
    }
}

impl Drop for Snapshot {
    fn drop(&mut self) {
        // SAFETY: mapped in `map`, and no pointer into it outlives `self`.
        let _ = unsafe { munmap(self.address, self.bytes) };
    }
}
