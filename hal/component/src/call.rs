//! Services for a component after its creation: messages, the clock, and the current command.

use crate::{
    Error, Touch, Uses,
    abi::{ArgValue, CallHost, FROM_AFAR, Record, Status, Str, Ticket, host_flags, level},
};

/// Realtime. Logs messages from any thread. Never blocks; the engine writes the log later.
///
/// Messages with the same text are joined, regardless of their numbers. The first is logged at
/// once, and the following ones as one line per second of machine time, with their count. Report a
/// lasting condition once, when it begins.
#[derive(Clone, Copy, Debug)]
pub struct Messages(pub(crate) &'static CallHost);

impl Messages {
    /// Logs text for the operator, whatever the message level is. Otherwise as [`Self::error`].
    pub fn notice(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::NOTICE, text, numbers);
    }

    /// Logs an error. Each `{}` of `text` is replaced by the next of `numbers`. A pin named as
    /// `{NAME}` is shown with its wiring.
    pub fn error(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::ERR, text, numbers);
    }

    /// Logs a warning.
    pub fn warn(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::WARN, text, numbers);
    }

    /// Logs information.
    pub fn info(&self, text: &'static str, numbers: &[f64]) {
        self.say(level::INFO, text, numbers);
    }

    fn say(&self, level: u8, text: &'static str, numbers: &[f64]) {
        if let Some(message) = self.0.message {
            // SAFETY: this is the engine's function with the engine's context; `text` is static.
            unsafe { message(self.0.ctx, level, Str::new(text), numbers.as_ptr(), numbers.len()) };
        }
    }
}

/// Realtime. Access to the machine's clock.
#[derive(Clone, Copy, Debug)]
pub struct Clock(pub(crate) &'static CallHost);

impl Clock {
    /// Returns machine time in nanoseconds. The virtual clock does not advance within a function.
    #[must_use]
    pub fn now_ns(&self) -> i64 {
        // SAFETY: this is the engine's function with the engine's context.
        self.0.now.map_or(0, |now| unsafe { now(self.0.ctx) })
    }

    /// Returns the number of gaps in time so far: times in which nothing ran because the process or the computer stood
    /// still, or the threads were stopped and started. The first cycle after a gap sees the new number.
    #[must_use]
    pub fn gaps(&self) -> u32 {
        // SAFETY: this is the engine's function with the engine's context.
        self.0.gaps.map_or(0, |gaps| unsafe { gaps(self.0.ctx) })
    }

    /// Returns whether the clock is virtual. A function must then not wait for time to pass.
    #[must_use]
    pub const fn is_virtual(&self) -> bool {
        self.0.flags & host_flags::VIRTUAL != 0
    }
}

/// Realtime. One part of a driver's hardware: a port, a card, a line. While any part of any driver has failed, the motion
/// controller is off and refuses to be switched on.
#[derive(Clone, Debug)]
pub struct Hardware {
    host: &'static CallHost,
    failed: bool,
}

impl Hardware {
    pub(crate) const fn new(host: &'static CallHost) -> Self {
        Self { host, failed: false }
    }

    /// Notes whether the part has failed. Returns true when it has failed just now.
    pub fn note(&mut self, failed: bool) -> bool {
        if core::mem::replace(&mut self.failed, failed) == failed {
            return false;
        }
        if let Some(hardware) = self.host.hardware {
            // SAFETY: this is the engine's function with the engine's context.
            unsafe { hardware(self.host.ctx, failed.into()) };
        }
        failed
    }

    /// Returns the failures of all drivers' hardware.
    #[must_use]
    pub fn failures(&self) -> Failures {
        // SAFETY: this is the engine's function with the engine's context.
        let both = self.host.failed_hardware.map_or(0, |failed| unsafe { failed(self.host.ctx) });
        let [a, b, c, d, e, f, g, h] = both.to_le_bytes();
        Failures { now: u32::from_le_bytes([a, b, c, d]), ever: u32::from_le_bytes([e, f, g, h]) }
    }
}

/// Failures of all drivers' hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failures {
    /// Number of parts that have failed now.
    pub now: u32,
    /// Number of failures so far, which goes round. It tells of a failure that has begun and ended between two looks.
    pub ever: u32,
}

impl Touch for Hardware {
    fn touch(&self, _: &mut Uses) {}
}

/// Values of pins, parameters and signals by name, for a worker. The control side of the engine answers between two looks at
/// its clients: on the virtual clock before the worker's next step, on the real clock within 0.1 s.
#[derive(Clone, Copy, Debug)]
pub struct HalValues(pub(crate) &'static CallHost);

impl HalValues {
    /// Asks for the value of a pin, a parameter or a signal, in this order, and returns the number of the question. Of the
    /// questions that nobody takes the answers to, the last 256 are kept.
    #[must_use]
    pub fn ask(&self, name: &str) -> u64 {
        // SAFETY: this is the engine's function with the engine's context; `name` lives for the duration of the call.
        self.0.ask_value.map_or(0, |ask| unsafe { ask(self.0.ctx, Str::borrow(name)) })
    }

    /// Takes the answer to a question, once: `None` while there is none, and `Some(None)` if nothing has the name. A bit is 0
    /// or 1.
    #[must_use]
    pub fn answer(&self, question: u64) -> Option<Option<f64>> {
        let Some(take) = self.0.take_value else { return Some(None) };
        let mut value = 0.0;
        // SAFETY: this is the engine's function with the engine's context; `value` lives for the duration of the call.
        match unsafe { take(self.0.ctx, question, &raw mut value) } {
            Status::EAGAIN => None,
            status => Some(status.is_ok().then_some(value)),
        }
    }
}

impl Touch for HalValues {
    fn touch(&self, _: &mut Uses) {}
}
impl Touch for Messages {
    fn touch(&self, _: &mut Uses) {}
}
impl Touch for Clock {
    fn touch(&self, _: &mut Uses) {}
}

/// A command or action that is executing on the control thread.
#[derive(Debug)]
pub struct Call<'c>(pub(crate) &'c CallHost);

impl Call<'_> {
    fn value(&self, name: &str) -> Option<ArgValue> {
        let arg = self.0.arg?;
        // SAFETY: this is the engine's function; the pointers live for the duration of the call.
        read_arg(|out| unsafe { arg(self.0.ctx, Str::borrow(name), out) })
    }

    /// Returns an integer or boolean argument that was given or has a default.
    #[must_use]
    pub fn int(&self, name: &str) -> Option<i64> {
        self.value(name).map(|v| v.int)
    }

    /// Returns a floating-point argument that was given or has a default.
    #[must_use]
    pub fn float(&self, name: &str) -> Option<f64> {
        self.value(name).map(|v| v.float)
    }

    /// Returns whether a client that speaks for people elsewhere has given the command.
    #[must_use]
    pub fn is_from_afar(&self) -> bool {
        self.bit(FROM_AFAR).unwrap_or(false)
    }

    /// Returns a boolean argument that was given or has a default.
    #[must_use]
    pub fn bit(&self, name: &str) -> Option<bool> {
        self.value(name).map(|v| v.int != 0)
    }

    /// Returns a string argument that was given or has a default.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        // SAFETY: the engine keeps the string until the call returns.
        self.value(name).and_then(|v| unsafe { v.text.get() }.map(str::to_owned))
    }

    /// Adds a line to the answer.
    pub fn reply(&self, text: &str) {
        if let Some(reply) = self.0.reply {
            // SAFETY: this is the engine's function; `text` lives for the duration of the call.
            unsafe { reply(self.0.ctx, Str::borrow(text)) };
        }
    }

    /// Returns a ticket through which a function later reports the end of this command. The answer
    /// tells the caller the ticket to wait for.
    ///
    /// # Errors
    /// The engine has no free ticket.
    pub fn ticket(&self) -> Result<TicketHandle, Error> {
        // SAFETY: this is the engine's function with the engine's context.
        let ticket = self.0.ticket.map_or(core::ptr::null(), |t| unsafe { t(self.0.ctx) });
        // SAFETY: the engine keeps a ticket until it is no longer pending.
        unsafe { ticket.as_ref() }
            .map(TicketHandle)
            .ok_or_else(|| Error::new("too many commands are in progress"))
    }

    /// As [`ticket`](Self::ticket), but the caller waits for the ticket even if it did not ask to.
    /// Use this for a command whose failure must not be missed.
    ///
    /// # Errors
    /// The engine has no free ticket.
    pub fn awaited_ticket(&self) -> Result<TicketHandle, Error> {
        let ticket = self.ticket()?;
        if let Some(awaited) = self.0.awaited {
            // SAFETY: this is the engine's function with the engine's context.
            unsafe { awaited(self.0.ctx) };
        }
        Ok(ticket)
    }
}

/// Realtime. Handle through which a function reports the end of a command. Call exactly one of
/// `done` and `fail`, once, as the last action.
#[derive(Clone, Copy, Debug)]
pub struct TicketHandle(pub(crate) &'static Ticket);

impl TicketHandle {
    pub(crate) const fn new(ticket: &'static Ticket) -> Self {
        Self(ticket)
    }

    /// Reports that the command has completed.
    pub fn done(self) {
        self.0.done();
    }

    /// Reports that the command was aborted. A pin that `why` names as `{NAME}` is shown with its
    /// wiring.
    pub fn fail(self, why: &'static str) {
        self.0.fail(why);
    }

    /// Reports that the command was aborted. Each `{}` of `why` is replaced by the next of
    /// `numbers`, at most four.
    pub fn fail_with(self, why: &'static str, numbers: &[f64]) {
        self.0.fail_with(why, numbers);
    }
}

pub(crate) fn read_arg(ask: impl Fn(*mut ArgValue) -> Status) -> Option<ArgValue> {
    let mut out = ArgValue::NONE;
    if !ask(&raw mut out).is_ok() {
        return None;
    }
    // SAFETY: the engine filled the record, including its size.
    let value = unsafe { ArgValue::read(&raw const out) }?;
    (value.given != 0).then_some(value)
}
