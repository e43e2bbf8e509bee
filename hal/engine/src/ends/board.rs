//! Realtime. Shared memory that says what an instance is doing. The watcher reads it after the
//! process has ended.

use crate::sync::{AtomicI32, AtomicPtr, AtomicU8, AtomicU32, AtomicU64, Ordering};
use core::{ffi::c_int, ptr::null_mut};

/// Maximum number of threads that have a row.
pub(super) const ROWS: usize = 64;
/// Size of the text in bytes.
const TEXT_BYTES: usize = 1 << 20;
/// Number that stands for no function and no other code.
pub(crate) const NOBODY: u32 = u32::MAX;

/// Layout of the shared memory.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Board {
    /// Nonzero while the watcher has to report the end of the process.
    pub(super) untold: AtomicU32,
    /// Number of the component code that the control side runs.
    pub(super) doing: AtomicU32,
    /// Current function of each thread, and whether the row is in use.
    pub(super) rows: [ThreadRow; ROWS],
    /// Length of the recording's file in bytes up to its last whole record, and its length once the
    /// write in progress is complete.
    pub(super) recorded: AtomicU64,
    pub(super) recording: AtomicU64,
    /// Number of changes that the recording has lost for want of room and that are not reported yet.
    pub(super) lost: AtomicU64,
    /// Process IDs of programs that the instance has started; 0 if none.
    pub(super) programs: [AtomicI32; 64],
    /// Number of valid bytes of the text.
    len: AtomicU64,
    text: [AtomicU8; TEXT_BYTES],
}

/// Row of one thread.
#[repr(C)]
#[derive(Debug)]
pub(super) struct ThreadRow {
    pub(super) funct: AtomicU32,
    taken: AtomicU32,
}

/// The board of this process, if it has one.
static BOARD: AtomicPtr<Board> = AtomicPtr::new(null_mut());

/// Creates the board. Called once.
pub(super) fn make() {
    // New memory is zero, which is a valid empty board but for its function numbers.
    let board = super::sys::shared(size_of::<Board>()).cast::<Board>();
    // SAFETY: new memory of this size, or null; all zero is a valid board.
    if let Some(made) = unsafe { board.as_ref() } {
        made.rows.iter().for_each(|r| r.funct.store(NOBODY, Ordering::Relaxed));
        made.doing.store(NOBODY, Ordering::Relaxed);
        BOARD.store(board, Ordering::Release); // Pairs with `board`.
    }
}

/// Returns the board, if there is one.
pub(super) fn board() -> Option<&'static Board> {
    // SAFETY: it is never unmapped.
    unsafe { BOARD.load(Ordering::Acquire).as_ref() } // Pairs with `make`.
}

impl Board {
    /// Adds a line of text. Only the control side may call this. A line that does not fit is left
    /// out.
    pub(super) fn add(&self, line: &str) {
        let at = self.len.load(Ordering::Relaxed);
        let from = usize::try_from(at).unwrap_or(TEXT_BYTES);
        let rest = self.text.get(from..).unwrap_or_default();
        if rest.len() <= line.len() {
            return;
        }
        // A newline must not occur inside a line.
        let bytes = line.bytes().map(|b| if b == b'\n' { b' ' } else { b }).chain([b'\n']);
        for (place, byte) in rest.iter().zip(bytes) {
            place.store(byte, Ordering::Relaxed);
        }
        self.len.store(at + line.len() as u64 + 1, Ordering::Release); // Pairs with `byte`.
    }

    /// Returns a byte of the text; `None` beyond its end.
    pub(super) fn byte(&self, at: usize) -> Option<u8> {
        let len = self.len.load(Ordering::Acquire); // Pairs with `add`.
        let byte = self.text.get(at).filter(|_| (at as u64) < len);
        byte.map(|b| b.load(Ordering::Relaxed))
    }
}

/// Number of the function that a thread is in, on the board if there is one.
#[derive(Debug)]
pub(crate) struct Current {
    row: Option<&'static ThreadRow>,
    own: AtomicU32,
}

impl Current {
    /// Takes a row for a thread that is in no function yet, and tells the watcher the thread's
    /// name.
    pub(crate) fn new(thread: &str) -> Self {
        let own = AtomicU32::new(NOBODY);
        let Some(board) = board() else { return Self { row: None, own } };
        let take = |r: &&ThreadRow| {
            r.taken.compare_exchange(0, 1, Ordering::Relaxed, Ordering::Relaxed).is_ok()
        };
        let row = board.rows.iter().position(|r| take(&r));
        let row = row.and_then(|i| Some((i, board.rows.get(i)?)));
        if let Some((i, _)) = row {
            super::notes::note(format_args!("t {i} {thread}"));
        }
        Self { row: row.map(|r| r.1), own }
    }

    /// Sets the current function.
    #[inline]
    pub(crate) fn store(&self, funct: u32, order: Ordering) {
        self.place().store(funct, order);
    }

    /// Returns the current function.
    pub(crate) fn load(&self, order: Ordering) -> u32 {
        self.place().load(order)
    }

    #[inline]
    const fn place(&self) -> &AtomicU32 {
        match self.row {
            Some(row) => &row.funct,
            None => &self.own,
        }
    }
}

impl Drop for Current {
    fn drop(&mut self) {
        if let Some(row) = self.row {
            row.funct.store(NOBODY, Ordering::Relaxed);
            row.taken.store(0, Ordering::Relaxed);
        }
    }
}

/// Publishes the length of the recording's file up to its last whole record, and its length once
/// the write in progress is complete.
pub(crate) fn record(recorded: u64, recording: u64) {
    if let Some(board) = board() {
        board.recorded.store(recorded, Ordering::Relaxed);
        // Pairs with the load of the watcher, which reads it after the end of this process.
        board.recording.store(recording, Ordering::Release);
    }
}

/// Returns the count of changes that the recording loses, if this process has a board.
pub(crate) fn lost() -> Option<&'static AtomicU64> {
    board().map(|board| &board.lost)
}

/// Publishes the programs of the instance.
pub(super) fn set_programs(programs: &[c_int]) {
    let Some(board) = board() else { return };
    let all = programs.iter().copied().chain(core::iter::repeat(0));
    for (place, program) in board.programs.iter().zip(all) {
        place.store(program, Ordering::Relaxed);
    }
}
