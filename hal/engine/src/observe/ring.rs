//! Rings that components share with programs: memory that no program can shrink.

use crate::{graph::Ix, serve::hold::Hold};
use core::{ffi::c_void, ptr::null_mut};
use hal_abi::{MAX_WIDTH, Producer, Ring, StreamRef, StreamSpec, stream_direction};
use hal_protocol::{StreamInfo, Type};
use rustix::{
    fs::{MemfdFlags, SealFlags, fcntl_add_seals, ftruncate, memfd_create},
    mm::{MapFlags, ProtFlags, mmap, munmap},
};
use std::os::fd::OwnedFd;

/// Mapping of a file in memory whose size no process can change.
#[derive(Debug)]
pub(crate) struct Sealed {
    pub(crate) fd: OwnedFd,
    pub(crate) address: *mut c_void,
    bytes: usize,
}

impl Sealed {
    /// Maps `bytes` zero bytes, and then seals their file against changes of its size, and with
    /// `seals`.
    pub(super) fn new(name: &str, bytes: usize, seals: SealFlags) -> rustix::io::Result<Self> {
        let fd = memfd_create(name, MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING)?;
        ftruncate(&fd, bytes as u64)?;
        let protection = ProtFlags::READ | ProtFlags::WRITE;
        let flags = MapFlags::SHARED | MapFlags::POPULATE;
        // SAFETY: a fresh shared mapping of a new file.
        let address = unsafe { mmap(null_mut(), bytes, protection, flags, &fd, 0) }?;
        let sealed = Self { fd, address, bytes };
        let seals = seals | SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL;
        fcntl_add_seals(&sealed.fd, seals)?;
        Ok(sealed)
    }
}

impl Sealed {
    /// Maps `bytes` zero bytes that other processes can also write.
    pub(crate) fn shared(name: &str, bytes: usize) -> std::io::Result<Self> {
        Ok(Self::new(name, bytes, SealFlags::empty())?)
    }
}

impl Drop for Sealed {
    fn drop(&mut self) {
        // SAFETY: mapped in `new`; every user of the mapping kept this value alive.
        let _ = unsafe { munmap(self.address, self.bytes) };
    }
}

/// A ring in sealed memory.
#[derive(Debug)]
pub(crate) struct Memory {
    sealed: Sealed,
    ring: *mut Ring,
    depth: u32,
    width: u32,
}

// SAFETY: both sides of the ring use only atomics; the rest never changes while it is shared.
unsafe impl Send for Memory {}
// SAFETY: as for `Send`.
unsafe impl Sync for Memory {}

impl Memory {
    /// Creates an empty ring whose records have values of these types.
    pub(crate) fn of_types(depth: u32, types: &[Type]) -> Result<Self, String> {
        Self::new(depth, width(types), codes(types))
    }

    /// Creates an empty ring of this shape.
    pub(crate) fn new(depth: u32, width: u32, types: [u8; 24]) -> Result<Self, String> {
        let sealed = Sealed::new("hal-stream", Ring::bytes(depth, width), SealFlags::empty())
            .map_err(|e| format!("no memory for a stream: {e}"))?;
        let ring = sealed.address.cast::<Ring>();
        // SAFETY: mapped, page-aligned, not yet shared.
        unsafe { ring.write(Ring::new(depth, width, types)) };
        Ok(Self { sealed, ring, depth, width })
    }

    /// Returns the writing side; the caller ensures that there is no other.
    pub(crate) fn producer(&self) -> Producer {
        // SAFETY: mapped in this shape; the caller keeps this memory, and is the only writer.
        unsafe { Producer::new(self.ring, self.depth, self.width) }
    }

    /// Returns the memory's descriptor, for another process.
    pub(crate) fn file(&self) -> std::io::Result<OwnedFd> {
        self.sealed.fd.try_clone()
    }

    pub(crate) fn ring(&self) -> &Ring {
        // SAFETY: mapped as long as this value lives.
        unsafe { &*self.ring }
    }
}

/// Returns the number of values of a record.
fn width(types: &[Type]) -> u32 {
    u32::try_from(types.len()).unwrap_or(0)
}

/// Returns the types as a ring states them.
fn codes(types: &[Type]) -> [u8; 24] {
    let mut codes = [0; 24];
    codes.iter_mut().zip(types).for_each(|(code, ty)| *code = ty.code());
    codes
}

/// A shared ring.
#[derive(Debug)]
pub(crate) struct SharedRing {
    pub(crate) owner: Ix,
    pub(crate) out: bool,
    /// The attached client.
    pub(crate) attached: Option<u64>,
    /// The process that is attached or was attached last.
    pid: i32,
    /// The index at which that process has all the records that it wants.
    enough: Option<u64>,
    /// Time for which the writer has left the ring empty while the virtual clock was to move;
    /// `None` after that has taken too long.
    hold: Option<Hold>,
    types: Vec<Type>,
    depth: u32,
    pub(crate) memory: Memory,
}

impl SharedRing {
    pub(crate) fn new(owner: Ix, spec: &StreamSpec) -> Result<Self, String> {
        let width = spec.width as usize;
        if width == 0 || width > MAX_WIDTH || spec.depth < 2 || spec.depth > 1 << 24 {
            return Err(format!(
                "a stream of {} values and depth {} is not possible: 1 to {MAX_WIDTH} values, \
                 depth 2 to 16777216",
                spec.width, spec.depth
            ));
        }
        let out = match spec.direction {
            stream_direction::OUT => true,
            stream_direction::IN => false,
            _ => return Err("a stream has no direction".into()),
        };
        let types: Option<Vec<Type>> =
            spec.types.iter().take(width).map(|t| Type::from_code(*t)).collect();
        let types = types.ok_or("a stream has a value of no known type")?;
        let memory = Memory::of_types(spec.depth, &types)?;
        let (attached, enough, depth) = (None, None, spec.depth);
        let hold = Some(Hold::NONE);
        Ok(Self { owner, out, attached, pid: 0, enough, hold, types, depth, memory })
    }

    /// Returns the reference that the component receives.
    pub(crate) fn made(&self) -> StreamRef {
        StreamRef { ring: self.memory.ring, depth: self.depth, width: width(&self.types) }
    }

    /// Returns the description for programs.
    pub(crate) fn info(&self, name: &str) -> StreamInfo {
        StreamInfo {
            name: name.to_owned(),
            out: self.out,
            depth: self.depth,
            types: self.types.clone(),
            attached: self.attached.is_some(),
            both: false,
        }
    }

    fn ring(&self) -> &Ring {
        self.memory.ring()
    }

    /// Attaches a client that wants `count` records. The constant part of the ring is written
    /// again, because the previous client may have overwritten it.
    pub(crate) fn attach(&mut self, client: u64, pid: i32, count: Option<u64>) {
        let head = Ring::new(self.depth, width(&self.types), codes(&self.types));
        let (from, to) = ((&raw const head).cast::<u8>(), self.memory.ring.cast::<u8>());
        // SAFETY: the beginning of the mapping, where this side keeps nothing that it relies on.
        unsafe { from.copy_to_nonoverlapping(to, core::mem::offset_of!(Ring, lost)) };
        self.ring().reopen();
        let taken = self.ring().taken();
        self.attached = Some(client);
        self.pid = pid;
        self.hold = Some(Hold::NONE);
        self.enough = count.map(|n| taken.saturating_add(n));
    }

    /// Returns whether the virtual clock need not move for this process, whose end the script waits
    /// for: it has detached, has all the records that it wanted, or can still write.
    pub(crate) fn is_enough_for(&self, pid: i32) -> bool {
        let more = if self.out {
            self.enough.is_none_or(|n| self.ring().written() < n)
        } else {
            self.ring().waiting(self.depth) + 1 >= self.depth
        };
        self.pid == pid && !(self.attached.is_some() && more)
    }

    /// Returns whether moving the virtual clock would lose something: the ring is full, or it is
    /// empty with its writer still attached. The clock waits for a writer for at most `patience_ns`
    /// of wall-clock time; then `late` is called.
    pub(crate) fn holds_back(&mut self, patience_ns: i64, now: i64, late: impl FnOnce()) -> bool {
        let waiting = self.ring().waiting(self.depth);
        if self.out {
            return waiting + 1 >= self.depth;
        }
        if waiting > 0 || self.attached.is_none() {
            self.hold = Some(Hold::NONE);
            return false;
        }
        let Some(hold) = &mut self.hold else { return false };
        if hold.outlasts(patience_ns, now) {
            self.hold = None;
            late();
        }
        self.hold.is_some()
    }
}

impl Drop for SharedRing {
    /// Closes the ring, by which the program at the other end learns that the component is
    /// unloaded.
    fn drop(&mut self) {
        self.ring().close();
    }
}
