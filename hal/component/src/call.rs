//! What a component may use after it was created: messages, the clock, and the call it answers.

use crate::{
    Error, Touch, Uses,
    abi::{ArgValue, CallHost, Record, Status, Str, Ticket, host_flags, level},
};

/// Realtime. Says things from anywhere; never blocks, and the engine logs it later.
///
/// Messages with the same text are joined, whatever their numbers: the first is logged at once, and
/// those that follow as one line in a second of machine time, with their number. Report a lasting
/// condition once, as it begins.
#[derive(Clone, Copy, Debug)]
pub struct Messages(pub(crate) &'static CallHost);

impl Messages {
    /// An error: each `{}` of `text` is replaced by the next of `numbers`, and a pin that it names
    /// as `{NAME}` is shown with its wiring.
    pub fn error(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::ERR, text, numbers);
    }

    /// A warning.
    pub fn warn(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::WARN, text, numbers);
    }

    /// Information.
    pub fn info(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::INFO, text, numbers);
    }

    fn say(&self, level: u8, text: &'static str, numbers: &[f64]) {
        if let Some(message) = self.0.message {
            // SAFETY: the engine's function with the engine's context; `text` is static.
            unsafe { message(self.0.ctx, level, Str::new(text), numbers.as_ptr(), numbers.len()) };
        }
    }
}

/// Realtime. The machine's clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub(crate) &'static CallHost);

impl Clock {
    /// Machine time in nanoseconds. Under the virtual clock it stands still within a function.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        // SAFETY: the engine's function with the engine's context.
        self.0.now.map_or(0, |now| unsafe { now(self.0.ctx) })
    }

    /// Whether the clock is virtual: then nothing may wait for it within a function.
    #[must_use]
    pub const fn is_virtual(&self) -> bool {
        self.0.flags & host_flags::VIRTUAL != 0
    }
}

impl Touch for Messages {
    fn touch(&self, _: &mut Uses) {}
}
impl Touch for Clock {
    fn touch(&self, _: &mut Uses) {}
}

/// A command or action being carried out on the control side.
#[derive(Debug)]
pub struct Call<'c>(pub(crate) &'c CallHost);

impl Call<'_> {
    fn value(&self, name: &str) -> Option<ArgValue> {
        let arg = self.0.arg?;
        // SAFETY: the engine's function; the pointers live across the call.
        read_arg(|out| unsafe { arg(self.0.ctx, Str::borrow(name), out) })
    }

    /// An integer or truth value that was given or has a default.
    #[must_use]
    pub fn int(&self, name: &str) -> Option<i64> {
        self.value(name).map(|v| v.int)
    }

    /// A floating-point number that was given or has a default.
    #[must_use]
    pub fn float(&self, name: &str) -> Option<f64> {
        self.value(name).map(|v| v.float)
    }

    /// A truth value that was given or has a default.
    #[must_use]
    pub fn bit(&self, name: &str) -> Option<bool> {
        self.value(name).map(|v| v.int != 0)
    }

    /// A string that was given or has a default.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        // SAFETY: the engine keeps the string until the call returns.
        self.value(name).and_then(|v| unsafe { v.text.get() }.map(str::to_owned))
    }

    /// Adds a line to the answer.
    pub fn reply(&self, text: &str) {
        if let Some(reply) = self.0.reply {
            // SAFETY: the engine's function; `text` lives across the call.
            unsafe { reply(self.0.ctx, Str::borrow(text)) };
        }
    }

    /// A place to report the end of this command later, from the function that carries it out:
    /// the caller is told to wait for it.
    ///
    /// # Errors
    /// The engine has none left.
    pub fn ticket(&self) -> Result<TicketHandle, Error> {
        // SAFETY: the engine's function with the engine's context.
        let ticket = self.0.ticket.map_or(core::ptr::null(), |t| unsafe { t(self.0.ctx) });
        // SAFETY: the engine keeps a ticket until it is no longer pending.
        unsafe { ticket.as_ref() }
            .map(TicketHandle)
            .ok_or_else(|| Error::new("too many commands are under way"))
    }

    /// As [`ticket`](Self::ticket), and the caller waits for it, whether it asked to or not: for a
    /// command whose failure nobody may miss.
    ///
    /// # Errors
    /// The engine has none left.
    pub fn awaited_ticket(&self) -> Result<TicketHandle, Error> {
        let ticket = self.ticket()?;
        if let Some(awaited) = self.0.awaited {
            // SAFETY: the engine's function with the engine's context.
            unsafe { awaited(self.0.ctx) };
        }
        Ok(ticket)
    }
}

/// Realtime. Where a function reports the end of a command; exactly one of `done` and `fail` is
/// called, once, as the last thing.
#[derive(Clone, Copy, Debug)]
pub struct TicketHandle(&'static Ticket);

impl TicketHandle {
    /// The command is carried out.
    pub fn done(self) {
        self.0.done();
    }

    /// The command was given up. A pin that `why` names as `{NAME}` is shown with its wiring.
    pub fn fail(self, why: &'static str) {
        self.0.fail(why);
    }

    /// The command was given up: each `{}` of `why` is replaced by the next of `numbers`, at most
    /// four.
    pub fn fail_with(self, why: &'static str, numbers: &[f64]) {
        self.0.fail_with(why, numbers);
    }
}

pub(crate) fn read_arg(ask: impl Fn(*mut ArgValue) -> Status) -> Option<ArgValue> {
    let mut out = ArgValue::NONE;
    if !ask(&raw mut out).is_ok() {
        return None;
    }
    // SAFETY: the engine filled it, with its size.
    let value = unsafe { ArgValue::read(&raw const out) }?;
    (value.given != 0).then_some(value)
}
