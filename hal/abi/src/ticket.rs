//! Realtime. Result of a command that takes machine time.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicPtr, AtomicU32, AtomicU64, AtomicUsize,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// Progress of a command.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TicketState {
    /// The command is still executing.
    Pending,
    /// The command has completed.
    Done,
    /// The command was aborted, for this reason.
    Failed(&'static str),
}

/// Record in which a function reports the end of a command. The engine owns it.
#[repr(C)]
#[derive(Debug, Default)]
pub struct Ticket {
    state: AtomicU32,
    /// Since minor 3: number of valid entries in `numbers`.
    count: AtomicU32,
    len: AtomicUsize,
    text: AtomicPtr<u8>,
    /// Since minor 3: bits of the floats that replace each `{}` of the text.
    numbers: [AtomicU64; TICKET_NUMBERS],
}

/// Maximum number of floats in a failure.
pub const TICKET_NUMBERS: usize = 4;

const WORD: usize = size_of::<usize>();
const _: () = assert!(offset_of!(Ticket, len) == WORD && offset_of!(Ticket, text) == 2 * WORD);

impl Ticket {
    /// Returns the ticket of a command that is still executing.
    pub const fn new() -> Self {
        Self {
            state: AtomicU32::new(0),
            count: AtomicU32::new(0),
            len: AtomicUsize::new(0),
            text: AtomicPtr::new(core::ptr::null_mut()),
            numbers: [const { AtomicU64::new(0) }; TICKET_NUMBERS],
        }
    }

    /// Makes the ticket of a command that has ended that of another one, which is still executing.
    pub fn reopen(&self) {
        self.count.store(0, Relaxed);
        self.state.store(0, Release); // Pairs with `state`.
    }

    /// Reports success. This must be the last access by the function that executes the command.
    pub fn done(&self) {
        self.state.store(1, Release); // Pairs with `state`.
    }

    /// Reports failure. This must be the last access by the function that executes the command.
    pub fn fail(&self, why: &'static str) {
        self.text.store(why.as_ptr().cast_mut(), Relaxed);
        self.len.store(why.len(), Relaxed);
        self.state.store(2, Release); // Pairs with `state`.
    }

    /// Reports failure with a text in which each `{}` stands for the next of `numbers`, at most
    /// [`TICKET_NUMBERS`]. This must be the last access by the function that executes the command.
    pub fn fail_with(&self, why: &'static str, numbers: &[f64]) {
        let mut count = 0;
        for (place, number) in self.numbers.iter().zip(numbers) {
            place.store(number.to_bits(), Relaxed);
            count += 1;
        }
        self.count.store(count, Relaxed);
        self.fail(why);
    }

    /// Returns the numbers of a failure, and how many of them are valid. Returns zeros and a count
    /// of zero before the command has failed.
    pub fn numbers(&self) -> ([f64; TICKET_NUMBERS], usize) {
        // Pairs with `fail`.
        if self.state.load(Acquire) < 2 {
            return ([0.0; TICKET_NUMBERS], 0);
        }
        let count = self.count.load(Relaxed) as usize;
        let number = |n: &AtomicU64| f64::from_bits(n.load(Relaxed));
        (self.numbers.each_ref().map(number), count.min(TICKET_NUMBERS))
    }

    /// Returns the progress of the command. The text lives in the plugin's library: copy it before
    /// the library can be unloaded.
    pub fn state(&self) -> TicketState {
        // Pairs with `done` and `fail`.
        match self.state.load(Acquire) {
            0 => TicketState::Pending,
            1 => TicketState::Done,
            _ => {
                let (text, len) = (self.text.load(Relaxed), self.len.load(Relaxed));
                if text.is_null() {
                    return TicketState::Failed("failed");
                }
                // SAFETY: `fail` stored a static string before it set the state.
                let bytes = unsafe { core::slice::from_raw_parts(text, len) };
                TicketState::Failed(core::str::from_utf8(bytes).unwrap_or("failed"))
            }
        }
    }
}
