//! A shared ring of the engine, mapped into this process.

use crate::{StreamInfo, Type, Value};
use core::{ffi::c_void, ptr};
use hal_abi::{Consumer, Got, Producer, RING_MAGIC, Ring};
use rustix::{
    fs::SealFlags,
    mm::{MapFlags, ProtFlags, mmap, munmap},
};
use std::os::fd::{AsFd, OwnedFd};

/// A program's end of a shared ring.
#[derive(Debug)]
pub struct Stream {
    info: StreamInfo,
    end: End,
    // Last field, because `end` points into it and must be dropped first.
    mapping: Mapping,
}

/// Memory of the engine that is mapped into this process.
#[derive(Debug)]
pub(crate) struct Mapping {
    address: *mut c_void,
    bytes: usize,
}

// SAFETY: the mapping is shared memory that is accessed only through atomics.
unsafe impl Send for Mapping {}

impl Mapping {
    /// Maps a ring of this depth (slots) and width (values per record).
    pub(crate) fn new(fd: &OwnedFd, depth: u32, width: u32) -> Result<Self, String> {
        let mapping = Self::writable(fd, Ring::bytes(depth, width), "ring")?;
        // SAFETY: the mapping is at least as long as the header, and the magic is its first word.
        let magic = unsafe { mapping.ring().cast::<u64>().read() };
        if magic == RING_MAGIC { Ok(mapping) } else { Err("this is not a ring".into()) }
    }

    /// Maps the first bytes of a file for reading and writing; otherwise as [`Self::sealed`].
    pub(crate) fn writable(fd: &OwnedFd, bytes: usize, what: &str) -> Result<Self, String> {
        Self::sealed(fd, bytes, ProtFlags::READ | ProtFlags::WRITE, what)
    }

    /// Maps the first bytes of a file that cannot shrink; `what` is its name in errors.
    pub(crate) fn sealed(
        fd: &OwnedFd,
        bytes: usize,
        prot: ProtFlags,
        what: &str,
    ) -> Result<Self, String> {
        let size = rustix::fs::fstat(fd.as_fd()).map_err(|e| e.to_string())?.st_size;
        if usize::try_from(size).ok().is_none_or(|s| s < bytes) {
            return Err(format!("the {what} is smaller than it says"));
        }
        let seals = rustix::fs::fcntl_get_seals(fd).map_err(|e| e.to_string())?;
        if !seals.contains(SealFlags::SHRINK) {
            return Err(format!("the {what} could be cut while it is read"));
        }
        // SAFETY: this is a new shared mapping. The file is sealed against shrinking, as checked
        // above.
        let address =
            unsafe { mmap(ptr::null_mut(), bytes, prot, MapFlags::SHARED, fd.as_fd(), 0) }
                .map_err(|e| e.to_string())?;
        Ok(Self { address, bytes })
    }

    /// Returns the start of the mapping.
    pub(crate) const fn address(&self) -> *const c_void {
        self.address.cast_const()
    }

    /// Returns the header of the ring.
    pub(crate) const fn ring(&self) -> *const Ring {
        self.address().cast::<Ring>()
    }
}

impl Drop for Mapping {
    fn drop(&mut self) {
        // SAFETY: mapped in `sealed`, and no pointer into it outlives `self`.
        let _ = unsafe { munmap(self.address, self.bytes) };
    }
}

#[derive(Debug)]
enum End {
    Reads(Consumer),
    Writes(Producer),
    /// Of a ring between two programs. Its places are those that the ring states, because the other program may have
    /// read and written meanwhile.
    Both,
}

impl Stream {
    pub(crate) fn map(fd: &OwnedFd, info: StreamInfo) -> Result<Self, String> {
        let width = u32::try_from(info.types.len()).map_err(|e| e.to_string())?;
        let mapping = Mapping::new(fd, info.depth, width)?;
        let end = if info.both {
            End::Both
        } else if info.out {
            // SAFETY: the mapping lives as long as `Self`; the engine admits only one program to
            // the ring.
            End::Reads(unsafe { Consumer::new(mapping.ring(), info.depth, width) })
        } else {
            // SAFETY: as above.
            End::Writes(unsafe { Producer::new(mapping.ring(), info.depth, width) })
        };
        Ok(Self { info, end, mapping })
    }

    /// Returns the types of a record's values.
    #[must_use]
    pub fn types(&self) -> &[Type] {
        &self.info.types
    }

    fn ring(&self) -> &Ring {
        // SAFETY: the mapping lives as long as `Self`, and of the header only atomics change.
        unsafe { &*self.mapping.ring() }
    }

    fn shape(&self) -> Option<(u32, u32)> {
        let is_both = matches!(self.end, End::Both);
        is_both.then_some((self.info.depth, u32::try_from(self.info.types.len()).unwrap_or(0)))
    }

    /// Returns the reading side of a ring between two programs.
    fn reader(&self) -> Option<Consumer> {
        let (depth, width) = self.shape()?;
        // SAFETY: the mapping lives as long as `Self`. Both programs may read and write: each checks the indices of the
        // other, so that records of two writers get lost, but nothing else does.
        Some(unsafe { Consumer::new(self.mapping.ring(), depth, width) })
    }

    /// Returns the writing side of a ring between two programs.
    fn writer(&self) -> Option<Producer> {
        let (depth, width) = self.shape()?;
        // SAFETY: as in `reader`.
        Some(unsafe { Producer::new(self.mapping.ring(), depth, width) })
    }

    /// Takes the oldest record into `out` and returns its number. Returns `None` if there is none.
    pub fn take(&mut self, out: &mut Vec<Value>) -> Option<u64> {
        let mut shared = self.reader();
        let ((End::Reads(consumer), _) | (_, Some(consumer))) = (&mut self.end, &mut shared) else {
            return None;
        };
        out.clear();
        let types = &self.info.types;
        consumer.follow();
        let got = consumer.take(|i, bits| {
            if let Some(ty) = types.get(i) {
                out.push(Value::from_bits(*ty, bits));
            }
        });
        match got {
            Got::Sample(n) => Some(n),
            Got::Nothing | Got::Nonsense => None,
        }
    }

    /// Appends a record. Returns false if the ring is full; nothing is then written or counted.
    pub fn put(&mut self, record: &[Value]) -> bool {
        let mut shared = self.writer();
        let ((End::Writes(producer), _) | (_, Some(producer))) = (&mut self.end, &mut shared)
        else {
            return false;
        };
        producer.follow();
        producer.room() > 0 && producer.put(|i| record.get(i).map_or(0, Value::bits))
    }

    /// Returns whether the component at the other end has been unloaded. A reader takes the records
    /// that wait then; no more will come.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        match &self.end {
            End::Reads(c) => c.lost_and_closed().1,
            End::Writes(p) => p.is_closed(),
            End::Both => self.ring().is_closed(),
        }
    }

    /// Returns the number of slots. One of them is always free.
    #[must_use]
    pub const fn depth(&self) -> u32 {
        self.info.depth
    }

    /// Returns the number of records in the ring.
    #[must_use]
    pub fn waiting(&self) -> u32 {
        match &self.end {
            End::Reads(c) => c.waiting(),
            End::Both => self.ring().waiting(self.info.depth),
            End::Writes(p) => p.waiting(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{MemfdFlags, fcntl_add_seals, ftruncate, memfd_create};

    #[test]
    fn memory_that_could_be_cut_is_not_mapped() {
        let map = |seal: SealFlags, bytes: u64| {
            let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
            let fd = memfd_create("hal-test", flags).unwrap();
            ftruncate(&fd, bytes).unwrap();
            fcntl_add_seals(&fd, seal).unwrap();
            Mapping::new(&fd, 4, 1).map(drop).unwrap_err()
        };
        assert_eq!(map(SealFlags::GROW, 4096), "the ring could be cut while it is read");
        assert_eq!(map(SealFlags::SHRINK, 8), "the ring is smaller than it says");
        assert_eq!(map(SealFlags::SHRINK, 4096), "this is not a ring");
        // A regular file has no seals.
        let file = std::env::temp_dir().join(format!("hal-ring-{}", std::process::id()));
        std::fs::write(&file, [0; 4096]).unwrap();
        let fd = OwnedFd::from(std::fs::File::open(&file).unwrap());
        assert!(Mapping::new(&fd, 4, 1).is_err());
        std::fs::remove_file(file).unwrap();
    }
}
