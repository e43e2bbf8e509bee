//! Snapshots: pages of shared memory in which components publish records, and that programs may
//! read but never write.

use super::ring::Sealed;
use crate::{Error, error::near::nearest, graph::Ix, name::Name, os};
use hal_abi::{FieldSpec, List, MAX_PAGE_WORDS, Page, PageReader, SnapshotRef, SnapshotSpec, Str};
use hal_protocol::{FieldInfo, Patterns, SnapshotInfo, SnapshotValues, Type, Value};
use rustix::fs::{Mode, OFlags, SealFlags, open};
use std::{
    collections::BTreeMap,
    os::fd::{AsRawFd, OwnedFd},
};

/// Longest time for which the control side tries to copy a record, in nanoseconds.
const TIMEOUT_NS: i64 = 50_000_000;

/// A page that this process alone can write.
#[derive(Debug)]
struct Memory {
    sealed: Sealed,
    page: *mut Page,
    words: u32,
}

// SAFETY: the words are atomics; the rest of the page never changes.
unsafe impl Send for Memory {}

impl Memory {
    fn new(version: u32, words: u32) -> Result<Self, String> {
        // No process can write the file except through this mapping.
        let sealed = Sealed::new("hal-snapshot", Page::bytes(words), SealFlags::FUTURE_WRITE)
            .map_err(|e| format!("no memory for a snapshot: {e}"))?;
        let page = sealed.address.cast::<Page>();
        // SAFETY: mapped, page-aligned, not yet shared. The words after it are zero.
        unsafe { page.write(Page::new(version, words)) };
        Ok(Self { sealed, page, words })
    }

    /// Returns a new descriptor of the page that can only read.
    fn read_only(&self) -> rustix::io::Result<OwnedFd> {
        let path = format!("/proc/self/fd/{}", self.sealed.fd.as_raw_fd());
        open(path, OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty())
    }
}

/// A snapshot of a component.
#[derive(Debug)]
pub(crate) struct Snapshot {
    owner: Ix,
    info: SnapshotInfo,
    memory: Memory,
}

/// The snapshots of an instance, by name.
#[derive(Debug, Default)]
pub(crate) struct Snapshots(BTreeMap<Name, Snapshot>);

impl Snapshot {
    pub(crate) fn new(
        owner: (Ix, &Name),
        name: &Name,
        doc: &str,
        spec: &SnapshotSpec,
    ) -> Result<Self, String> {
        let fields = fields(&spec.fields)?;
        let words = fields.iter().try_fold(0_u32, |sum, f| sum.checked_add(f.count));
        let words = words.filter(|n| (1..=MAX_PAGE_WORDS).contains(n)).ok_or_else(|| {
            format!("a snapshot holds 1 to {MAX_PAGE_WORDS} values, in fields of at least one")
        })?;
        let memory = Memory::new(spec.version, words)?;
        let info = SnapshotInfo {
            name: name.as_str().to_owned(),
            owner_name: owner.1.as_str().to_owned(),
            version: spec.version,
            doc: doc.to_owned(),
            fields,
        };
        Ok(Self { owner: owner.0, info, memory })
    }

    /// Returns the page for the component that writes it.
    pub(crate) const fn made(&self) -> SnapshotRef {
        SnapshotRef { page: self.memory.page, words: self.memory.words }
    }

    /// Copies the latest record. Returns `None` if the writer does not complete a record in time.
    fn values(&self) -> Option<SnapshotValues> {
        // SAFETY: mapped with this number of words as long as `self` lives.
        let reader = unsafe { PageReader::new(self.memory.page, self.memory.words) };
        let limit = os::monotonic_ns().saturating_add(TIMEOUT_NS);
        let mut words = Vec::with_capacity(self.memory.words as usize);
        let sequence = loop {
            words.clear();
            if let Some(sequence) = reader.copy(|_, bits| words.push(bits)) {
                break sequence;
            }
            if os::monotonic_ns() > limit {
                return None;
            }
            os::sleep_until(os::monotonic_ns() + 20_000);
        };
        let mut words = words.into_iter();
        let mut values = Vec::new();
        for field in &self.info.fields {
            let own = words.by_ref().take(field.count as usize);
            values.push(own.map(|bits| Value::from_bits(field.ty, bits)).collect());
        }
        Some(SnapshotValues { info: self.info.clone(), records: sequence / 2, values })
    }
}

/// Copies the declared fields.
fn fields(list: &List<FieldSpec>) -> Result<Vec<FieldInfo>, String> {
    let mut fields: Vec<FieldInfo> = Vec::new();
    for i in 0..list.len() {
        // SAFETY: the component's list and its texts are static.
        let spec = unsafe { list.get(i) }.ok_or("a field of a snapshot is not well declared")?;
        // SAFETY: as above.
        let text = |s: Str| unsafe { s.get() }.ok_or("a text is not UTF-8");
        let name = text(spec.name)?;
        let ty = Type::from_code(spec.ty).filter(|ty| *ty != Type::Port);
        let ty = ty.ok_or_else(|| format!("field '{name}' of a snapshot has no known type"))?;
        if spec.count == 0 || name.is_empty() || fields.iter().any(|f| f.name == name) {
            return Err(format!("field '{name}' of a snapshot is empty or declared twice"));
        }
        let doc = text(spec.doc)?.to_owned();
        fields.push(FieldInfo { name: name.to_owned(), ty, count: spec.count, doc });
    }
    Ok(fields)
}

impl Snapshots {
    /// Returns whether a component has a snapshot of this name.
    pub(crate) fn has(&self, name: &Name) -> bool {
        self.0.contains_key(name)
    }

    /// Adds a snapshot.
    pub(crate) fn add(&mut self, name: Name, snapshot: Snapshot) {
        self.0.insert(name, snapshot);
    }

    /// Frees the snapshots of a component.
    pub(crate) fn free(&mut self, owner: Ix) {
        self.0.retain(|_, s| s.owner != owner);
    }

    /// Keeps the pages mapped: a thread that does not end may still write them.
    pub(crate) fn leak(&mut self) {
        let _left = core::mem::ManuallyDrop::new(core::mem::take(&mut self.0));
    }

    /// Returns the descriptions of the snapshots.
    pub(crate) fn list(&self, p: &Patterns) -> Vec<SnapshotInfo> {
        self.0.values().map(|s| &s.info).filter(|i| p.matches(&i.name)).cloned().collect()
    }

    fn find(&self, name: &str) -> Result<&Snapshot, Error> {
        self.0.get(name).ok_or_else(|| Error::NotFound {
            what: "snapshot",
            name: name.into(),
            near: nearest(name, self.0.keys().map(Name::as_str)),
        })
    }

    /// Returns the latest record of a snapshot.
    pub(crate) fn values(&self, name: &str) -> Result<SnapshotValues, Error> {
        let busy = || Error::System {
            what: "the snapshot cannot be read",
            why: "its component does not complete a record".into(),
        };
        self.find(name)?.values().ok_or_else(busy)
    }

    /// Returns the description of a snapshot and a descriptor of its page.
    pub(crate) fn page(&self, name: &str) -> Result<(SnapshotInfo, OwnedFd), Error> {
        let snapshot = self.find(name)?;
        let fd = snapshot.memory.read_only().map_err(|e| Error::System {
            what: "the snapshot cannot be handed over",
            why: os::said(&e.into()),
        })?;
        Ok((snapshot.info.clone(), fd))
    }
}

#[cfg(test)]
mod tests {
    use super::{Memory, Page};
    use hal_abi::{PageReader, PageWriter};
    use rustix::{
        fs::{Mode, OFlags, SealFlags, fcntl_add_seals, ftruncate, open},
        io::{Errno, pwrite},
        mm::{MapFlags, ProtFlags, mmap},
    };
    use std::os::fd::AsRawFd;

    #[test]
    fn a_program_can_neither_write_nor_shorten_a_page() {
        let memory = Memory::new(1, 2).unwrap();
        // SAFETY: mapped with two words until the end of the test.
        let mut writer = unsafe { PageWriter::new(memory.page, 2) };
        // SAFETY: as above.
        let reader = unsafe { PageReader::new(memory.page, 2) };
        let read_only = memory.read_only().unwrap();
        // A program that has the descriptor can open the same file again with more rights.
        let path = format!("/proc/self/fd/{}", read_only.as_raw_fd());
        let again = open(path, OFlags::RDWR, Mode::empty()).unwrap();
        let map = |fd: &std::os::fd::OwnedFd| {
            let prot = ProtFlags::READ | ProtFlags::WRITE;
            // SAFETY: a mapping at an address that the system chooses.
            unsafe { mmap(core::ptr::null_mut(), 64, prot, MapFlags::SHARED, fd, 0) }
        };
        assert_eq!(pwrite(&read_only, &[1], 64), Err(Errno::BADF));
        assert_eq!(map(&read_only), Err(Errno::ACCESS));
        assert_eq!(pwrite(&again, &[1], 64), Err(Errno::PERM));
        assert_eq!(map(&again), Err(Errno::PERM));
        assert_eq!(ftruncate(&again, 0), Err(Errno::PERM));
        assert_eq!(ftruncate(&again, 1 << 20), Err(Errno::PERM));
        assert_eq!(fcntl_add_seals(&again, SealFlags::WRITE), Err(Errno::PERM));
        // The component still writes.
        for n in 1..=3 {
            writer.put(|words| {
                words.iter().for_each(|w| w.store(n, core::sync::atomic::Ordering::Relaxed));
            });
            let mut seen = Vec::new();
            assert_eq!(reader.copy(|_, bits| seen.push(bits)), Some(2 * n));
            assert_eq!(seen, [n, n]);
        }
        assert_eq!(Page::bytes(2), 80);
    }
}
