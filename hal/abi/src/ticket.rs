//! Realtime. The answer to a command that takes machine time.

use core::{
    mem::offset_of,
    sync::atomic::{
        AtomicPtr, AtomicU32, AtomicU64, AtomicUsize,
        Ordering::{Acquire, Relaxed, Release},
    },
};

/// How far a command has come.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum TicketState {
    /// Under way.
    Pending,
    /// Carried out.
    Done,
    /// Given up, with the reason.
    Failed(&'static str),
}

/// A place where a function reports the end of a command. Owned by the engine.
#[repr(C)]
#[derive(Debug, Default)]
pub struct Ticket {
    state: AtomicU32,
    /// Since minor 3: how many of `numbers` belong to the text.
    count: AtomicU32,
    len: AtomicUsize,
    text: AtomicPtr<u8>,
    /// Since minor 3: the bits of the floats that replace each `{}` of the text.
    numbers: [AtomicU64; TICKET_NUMBERS],
}

/// The number of floats that a failure can carry.
pub const TICKET_NUMBERS: usize = 4;

const WORD: usize = size_of::<usize>();
const _: () = assert!(offset_of!(Ticket, len) == WORD && offset_of!(Ticket, text) == 2 * WORD);

impl Ticket {
    /// A command under way.
    pub const fn new() -> Self {
        Self {
            state: AtomicU32::new(0),
            count: AtomicU32::new(0),
            len: AtomicUsize::new(0),
            text: AtomicPtr::new(core::ptr::null_mut()),
            numbers: [const { AtomicU64::new(0) }; TICKET_NUMBERS],
        }
    }

    /// Reports success; the last access by the function that carries the command out.
    pub fn done(&self) {
        self.state.store(1, Release); // Pairs with `state`.
    }

    /// Reports failure; the last access by the function that carries the command out.
    pub fn fail(&self, why: &'static str) {
        self.text.store(why.as_ptr().cast_mut(), Relaxed);
        self.len.store(why.len(), Relaxed);
        self.state.store(2, Release); // Pairs with `state`.
    }

    /// Reports failure with a text in which each `{}` stands for the next of `numbers`, at most
    /// [`TICKET_NUMBERS`]; the last access by the function that carries the command out.
    pub fn fail_with(&self, why: &'static str, numbers: &[f64]) {
        let mut count = 0;
        for (place, number) in self.numbers.iter().zip(numbers) {
            place.store(number.to_bits(), Relaxed);
            count += 1;
        }
        self.count.store(count, Relaxed);
        self.fail(why);
    }

    /// The numbers of a failure, and how many of them count. Zeros and none before the command
    /// has failed.
    pub fn numbers(&self) -> ([f64; TICKET_NUMBERS], usize) {
        // Pairs with `fail`.
        if self.state.load(Acquire) < 2 {
            return ([0.0; TICKET_NUMBERS], 0);
        }
        let count = self.count.load(Relaxed) as usize;
        let number = |n: &AtomicU64| f64::from_bits(n.load(Relaxed));
        (self.numbers.each_ref().map(number), count.min(TICKET_NUMBERS))
    }

    /// How far the command has come. The text lives in the plugin's library: copy it before that
    /// can be unloaded.
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
                // SAFETY: `fail` stored a static string before the state.
                let bytes = unsafe { core::slice::from_raw_parts(text, len) };
                TicketState::Failed(core::str::from_utf8(bytes).unwrap_or("failed"))
            }
        }
    }
}
