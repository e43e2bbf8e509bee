//! Realtime. What an instance is at, in memory that outlives it: the watcher reads it when the
//! process has ended.

use crate::sync::{AtomicI32, AtomicPtr, AtomicU8, AtomicU32, AtomicU64, Ordering};
use core::{ffi::c_int, ptr::null_mut};

/// How many threads of a machine have a row.
pub(super) const ROWS: usize = 64;
/// How much text there is room for.
const ROOM: usize = 1 << 20;
/// No function, no piece of other code.
pub(crate) const NOBODY: u32 = u32::MAX;

/// The memory.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Board {
    /// Whether the end of the process is to be told of.
    pub(super) untold: AtomicU32,
    /// The code that the control side runs, by its number.
    pub(super) doing: AtomicU32,
    /// For each thread, the function that it is in; and whether the row is taken.
    pub(super) rows: [Row; ROWS],
    /// How long the recording's file is at its last whole record, and how long it becomes by the
    /// write that is under way.
    pub(super) recorded: AtomicU64,
    pub(super) recording: AtomicU64,
    /// Programs that the instance has started; 0: none.
    pub(super) programs: [AtomicI32; 64],
    /// How much of the text counts.
    len: AtomicU64,
    text: [AtomicU8; ROOM],
}

/// A thread's row.
#[repr(C)]
#[derive(Debug)]
pub(super) struct Row {
    pub(super) funct: AtomicU32,
    taken: AtomicU32,
}

/// The board of this process, if it has one.
static BOARD: AtomicPtr<Board> = AtomicPtr::new(null_mut());

/// Has a board made, once.
pub(super) fn make() {
    // What is new is zero, as is a board on which nothing is written but its rows.
    let board = super::sys::shared(size_of::<Board>()).cast::<Board>();
    // SAFETY: new memory of this size, or null; all zero is a valid board.
    if let Some(made) = unsafe { board.as_ref() } {
        made.rows.iter().for_each(|r| r.funct.store(NOBODY, Ordering::Relaxed));
        made.doing.store(NOBODY, Ordering::Relaxed);
        BOARD.store(board, Ordering::Release); // Pairs with `board`.
    }
}

/// The board.
pub(super) fn board() -> Option<&'static Board> {
    // SAFETY: it is never unmapped.
    unsafe { BOARD.load(Ordering::Acquire).as_ref() } // Pairs with `make`.
}

impl Board {
    /// Adds a line of text; control side only. A line that has no room is left out.
    pub(super) fn add(&self, line: &str) {
        let at = self.len.load(Ordering::Relaxed);
        let from = usize::try_from(at).unwrap_or(ROOM);
        let rest = self.text.get(from..).unwrap_or_default();
        if rest.len() <= line.len() {
            return;
        }
        // What ends a line must not be in it.
        let bytes = line.bytes().map(|b| if b == b'\n' { b' ' } else { b }).chain([b'\n']);
        for (place, byte) in rest.iter().zip(bytes) {
            place.store(byte, Ordering::Relaxed);
        }
        self.len.store(at + line.len() as u64 + 1, Ordering::Release); // Pairs with `byte`.
    }

    /// A byte of the text; none behind its end.
    pub(super) fn byte(&self, at: usize) -> Option<u8> {
        let len = self.len.load(Ordering::Acquire); // Pairs with `add`.
        let byte = self.text.get(at).filter(|_| (at as u64) < len);
        byte.map(|b| b.load(Ordering::Relaxed))
    }
}

/// Which function a thread is in, by its number: on the board if there is one.
#[derive(Debug)]
pub(crate) struct Current {
    row: Option<&'static Row>,
    own: AtomicU32,
}

impl Current {
    /// In no function. With the thread's name for those who look on.
    pub(crate) fn new(thread: &str) -> Self {
        let own = AtomicU32::new(NOBODY);
        let Some(board) = board() else { return Self { row: None, own } };
        let take =
            |r: &&Row| r.taken.compare_exchange(0, 1, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        let row = board.rows.iter().position(|r| take(&r));
        let row = row.and_then(|i| Some((i, board.rows.get(i)?)));
        if let Some((i, _)) = row {
            super::note(format_args!("t {i} {thread}"));
        }
        Self { row: row.map(|r| r.1), own }
    }

    /// It is in this one now.
    #[inline]
    pub(crate) fn store(&self, funct: u32, order: Ordering) {
        self.place().store(funct, order);
    }

    /// The function that it is in.
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

/// The recording's file is so long at its last whole record, and is about to become so long.
pub(crate) fn record(recorded: u64, recording: u64) {
    if let Some(board) = board() {
        board.recorded.store(recorded, Ordering::Relaxed);
        board.recording.store(recording, Ordering::Release); // Pairs with the process's end.
    }
}

/// The programs of the instance.
pub(super) fn set_programs(programs: &[c_int]) {
    let Some(board) = board() else { return };
    let all = programs.iter().copied().chain(core::iter::repeat(0));
    for (place, program) in board.programs.iter().zip(all) {
        place.store(program, Ordering::Relaxed);
    }
}
