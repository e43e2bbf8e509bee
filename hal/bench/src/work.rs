//! Workers and snapshots on the bench.

use super::{
    Bench,
    host::{table, text, uses},
    table::Code,
};
use core::ffi::c_void;
use hal_component::{
    Plain,
    abi::{
        self, FieldSpec, Page, PageReader, Record, SnapshotRef, SnapshotSpec, Status, WorkerSpec,
    },
};

/// Memory of a snapshot's page.
pub(super) struct Memory {
    #[expect(dead_code, reason = "held so that the page stays live")]
    words: Vec<u64>,
    made: SnapshotRef,
    pub(super) fields: Vec<FieldSpec>,
}

#[expect(clippy::unwrap_used, clippy::panic, reason = "a table for tests")]
impl Bench {
    /// Runs a command as one that a client which speaks for people elsewhere has given.
    ///
    /// # Errors
    /// The reason why the command failed.
    pub fn command_from_afar(&self, name: &str, args: &[&str]) -> Result<Vec<String>, String> {
        self.table.borrow().is_from_afar.set(true);
        let done = self.command(name, args);
        self.table.borrow().is_from_afar.set(false);
        done
    }

    /// Runs one step of a worker and returns the number of items that it did. The clock does not
    /// advance.
    ///
    /// # Errors
    /// The text of the panic.
    pub fn work(&self, name: &str, items: u32) -> Result<u32, String> {
        let (run, state) = {
            let table = self.table.borrow();
            let code = table.workers.get(name).unwrap_or_else(|| panic!("no worker {name}"));
            (code.run, code.state)
        };
        // SAFETY: this is the component's code with its own state; calls do not overlap.
        let status = unsafe { run(state, items) };
        u32::try_from(status.0)
            .map_err(|_| core::mem::take(&mut *self.table.borrow().fault.borrow_mut()))
    }

    /// Returns the latest record of a snapshot, which must be of this type.
    #[must_use]
    pub fn snapshot<T: Plain>(&self, name: &str) -> T {
        let table = self.table.borrow();
        let page = table.snapshots.get(name).unwrap_or_else(|| panic!("no snapshot {name}"));
        assert_eq!(page.made.words as usize, T::WORDS, "{name} is of another type");
        // SAFETY: the memory lives as long as the bench, and has this number of words.
        let reader = unsafe { PageReader::new(page.made.page, page.made.words) };
        let mut words = Vec::new();
        reader.copy(|_, bits| words.push(bits)).unwrap();
        let mut words = words.into_iter();
        T::load(&mut || words.next().unwrap())
    }
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn worker(ctx: *mut c_void, spec: *const WorkerSpec) -> Status {
    // SAFETY: the component's record lives for the duration of its call.
    let Some(s) = (unsafe { WorkerSpec::read(spec) }) else { return Status::EINVAL };
    let Some(run) = s.run else { return Status::EINVAL };
    let code = Code { run, state: s.state, free: s.free, uses: uses(s.uses, s.n_uses) };
    if s.period_ns <= 0 || s.items == 0 {
        return Status::EINVAL;
    }
    table(ctx).borrow_mut().workers.insert(text(s.name), code);
    Status::OK
}

/// # Safety
/// Called by a component through the records that [`Bench`] made.
pub(super) unsafe extern "C" fn snapshot(
    ctx: *mut c_void,
    spec: *const SnapshotSpec,
    out: *mut SnapshotRef,
) -> Status {
    // SAFETY: the component's record lives for the duration of its call.
    let Some(s) = (unsafe { SnapshotSpec::read(spec) }) else { return Status::EINVAL };
    // SAFETY: the component's list is static.
    let fields: Vec<FieldSpec> =
        (0..s.fields.len()).filter_map(|i| unsafe { s.fields.get(i) }).collect();
    let words: u32 = fields.iter().map(|f| f.count).sum();
    if words == 0 || words > abi::MAX_PAGE_WORDS {
        return Status::EINVAL;
    }
    // Extra words for the alignment of the header.
    let mut memory = vec![0_u64; Page::bytes(words) / 8 + 8];
    let at = memory.as_ptr().align_offset(64);
    // SAFETY: `align_offset` stays within the eight spare words.
    let page = unsafe { memory.as_mut_ptr().add(at) }.cast::<Page>();
    // SAFETY: the pointer is in bounds and aligned, and the memory is not used yet.
    unsafe { page.write(Page::new(s.version, words)) };
    let made = SnapshotRef { page, words };
    // SAFETY: the caller passes a pointer to a live value.
    unsafe { out.write(made) };
    let memory = Memory { words: memory, made, fields };
    table(ctx).borrow_mut().snapshots.insert(text(s.name), memory);
    Status::OK
}
