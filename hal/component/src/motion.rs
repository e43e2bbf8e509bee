//! The service `motion`: commands for the motion controller, and its status.

mod commands;
mod user;

use crate::{
    Error, MotionStatus, Plain, TicketHandle, Touch, Uses,
    abi::{self, MOTION_TEXT, MotionAnswer, MotionCommand, Record, Status, Str, motion_source},
    shim,
};
use commands::CommandTickets;
use core::ffi::c_void;
use std::sync::{Mutex, PoisonError};
pub use user::{MotionEnd, MotionId, MotionRef, MotionRefusal, MotionToken};

/// Origin of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotionSource {
    /// The owner of the token: a program or MDI.
    Task,
    /// An operator at the machine: text commands, `halui`, jog wheels.
    #[default]
    Local,
    /// A remote operator. Local sources end its motion, so it needs no token.
    Remote,
}

/// Numbers of stops and of pauses so far. An order carries the epoch in which it was given; after a stop since then it begins
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StopEpoch {
    /// E-stops, switches to off, aborts and faults; 0 where nothing counts them.
    pub stops: u32,
    /// Pauses.
    pub pauses: u32,
}

impl StopEpoch {
    /// Decodes the number in a record or an argument; 0 is none.
    #[must_use]
    pub const fn of(number: u64) -> Option<Self> {
        if number == 0 {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "the low half")]
        let pauses = number as u32;
        let stops = (number >> 32) as u32;
        Some(Self { stops, pauses })
    }

    /// Returns the number in records and arguments.
    #[must_use]
    pub const fn number(self) -> u64 {
        (self.stops as u64) << 32 | self.pauses as u64
    }

    /// Returns whether a stop has come since.
    #[must_use]
    pub const fn is_stopped_by(self, now: Self) -> bool {
        now.stops.wrapping_sub(self.stops).cast_signed() > 0
    }

    /// Returns whether a pause has come since.
    #[must_use]
    pub const fn is_paused_by(self, now: Self) -> bool {
        now.pauses.wrapping_sub(self.pauses).cast_signed() > 0
    }
}

/// A motion controller that a component offers. Its methods never run in a realtime thread.
pub trait Motion: Touch + Send + Sync + 'static {
    /// Checks a command and sends it on. Exactly one of the functions of the component reports the
    /// end to `end`, unless the command is refused here.
    ///
    /// # Errors
    /// The command is refused, or there is no room for it ([`Error::again`]). All fields of a
    /// command are untrusted, numbers included.
    fn push(
        &self,
        source: MotionSource,
        command: &MotionCommand,
        end: TicketHandle,
    ) -> Result<(), Error>;
    /// Returns the number of moves for which there is room.
    fn room(&self) -> u32;
    /// Begins or ends the claim of the owner: while it lasts, no other source may begin motion.
    fn claim(&self, on: bool);
    /// Returns the status of the latest cycle, if there is one.
    fn status(&self) -> Option<MotionStatus>;
    /// Returns the stop epoch: stops so far in the high half, pauses in the low one. It is never 0.
    fn epoch(&self) -> u64;
    /// Returns the setting that a command of the kind CONFIGURE names.
    ///
    /// # Errors
    /// There is no such setting.
    fn setting(&self, command: &MotionCommand) -> Result<f64, Error>;
}

/// A motion controller, and the state of its service.
pub(crate) struct Offered<M> {
    motion: M,
    commands: Mutex<CommandTickets>,
}

impl<M: Motion> Offered<M> {
    pub(crate) fn new(motion: M) -> Self {
        Self { motion, commands: Mutex::new(CommandTickets::default()) }
    }
}

impl<M: Motion> Touch for Offered<M> {
    fn touch(&self, uses: &mut Uses) {
        self.motion.touch(uses);
    }
}

/// Returns the table for a value of this type.
pub(crate) const fn table<M: Motion>() -> abi::Motion {
    abi::Motion {
        size: abi::size::<abi::Motion>(),
        flags: 0,
        ctx: core::ptr::null(),
        acquire: Some(acquire::<M>),
        release: Some(release::<M>),
        claim: Some(claim::<M>),
        room: Some(room::<M>),
        push: Some(push::<M>),
        poll: Some(poll::<M>),
        status: Some(status::<M>),
        setting: Some(setting::<M>),
        epoch: Some(epoch::<M>),
    }
}

/// Status, number and text of an answer.
type Answer = (Status, u64, String);

/// Runs a function of the service. A panic is an error.
///
/// # Safety
/// `ctx` must be null or point to a live `Offered<M>`; `answer` must be null or point to a live
/// record whose size is its own.
unsafe fn answer<M: Motion>(
    ctx: *const c_void,
    answer: *mut MotionAnswer,
    run: impl FnOnce(&Offered<M>, &mut CommandTickets) -> Answer,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let offered = unsafe { ctx.cast::<Offered<M>>().as_ref() };
    // SAFETY: guaranteed by the caller.
    let out = unsafe { MotionAnswer::read(answer) };
    let (Some(offered), Some(mut out)) = (offered, out) else { return Status::EINVAL };
    let done = shim::guarded(|| {
        let mut commands = offered.commands.lock().unwrap_or_else(PoisonError::into_inner);
        run(offered, &mut commands)
    });
    let (status, id, text) = done.unwrap_or_else(|text| (Status::EFAULT, 0, text));
    out.id = id;
    let len = text.floor_char_boundary(MOTION_TEXT);
    for (place, byte) in out.text.iter_mut().zip(text.bytes().take(len)) {
        *place = byte;
    }
    out.len = u32::try_from(len).unwrap_or(0);
    // SAFETY: the record is live, and `read` checked that it has at least this size.
    unsafe { answer.write(out) };
    status
}

/// # Safety
/// As [`answer`]; `name` must be live.
unsafe extern "C" fn acquire<M: Motion>(
    ctx: *const c_void,
    name: Str,
    out: *mut MotionAnswer,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let name = unsafe { name.get() };
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer::<M>(ctx, out, |offered, commands| {
            let Some(name) = name.filter(|n| !n.is_empty()) else {
                return (Status::EINVAL, 0, "the owner of motion needs a name".to_owned());
            };
            match commands.acquire(name) {
                Ok(token) => {
                    offered.motion.claim(false);
                    (Status::OK, token, String::new())
                }
                Err(text) => (Status::EBUSY, 0, text),
            }
        })
    }
}

/// # Safety
/// As [`answer`].
unsafe extern "C" fn release<M: Motion>(ctx: *const c_void, token: u64) -> Status {
    let mut out = MotionAnswer::EMPTY;
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer::<M>(ctx, &raw mut out, |offered, commands| {
            let was = commands.release(token);
            if was {
                offered.motion.claim(false);
            }
            (if was { Status::OK } else { Status::EBUSY }, 0, String::new())
        })
    }
}

/// # Safety
/// As [`answer`].
unsafe extern "C" fn claim<M: Motion>(ctx: *const c_void, token: u64, on: u32) -> Status {
    let mut out = MotionAnswer::EMPTY;
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer::<M>(ctx, &raw mut out, |offered, commands| {
            let owns = commands.owns(token);
            if owns {
                offered.motion.claim(on != 0);
            }
            (if owns { Status::OK } else { Status::EBUSY }, 0, String::new())
        })
    }
}

/// # Safety
/// `ctx` must be null or point to a live `Offered<M>`.
unsafe extern "C" fn room<M: Motion>(ctx: *const c_void) -> u32 {
    // SAFETY: guaranteed by the caller.
    let offered = unsafe { ctx.cast::<Offered<M>>().as_ref() };
    offered.map_or(0, |o| shim::guarded(|| o.motion.room()).unwrap_or(0))
}

/// # Safety
/// As [`answer`]; `command` must be null or point to a live record whose size is its own.
unsafe extern "C" fn push<M: Motion>(
    ctx: *const c_void,
    token: u64,
    command: *const MotionCommand,
    out: *mut MotionAnswer,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let command = unsafe { MotionCommand::read(command) };
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer::<M>(ctx, out, |offered, commands| match command {
            Some(command) => send(offered, commands, token, &command),
            None => (Status::EINVAL, 0, "the command is no complete record".to_owned()),
        })
    }
}

fn send<M: Motion>(
    offered: &Offered<M>,
    commands: &mut CommandTickets,
    token: u64,
    command: &MotionCommand,
) -> Answer {
    let source = match command.source {
        _ if token != 0 && !commands.owns(token) => {
            return (Status::EBUSY, 0, "the caller does not own motion".to_owned());
        }
        motion_source::REMOTE => MotionSource::Remote,
        _ if token == 0 => MotionSource::Local,
        motion_source::TASK => MotionSource::Task,
        motion_source::LOCAL => MotionSource::Local,
        other => return (Status::EINVAL, 0, format!("there is no source {other}")),
    };
    let Some((id, ticket)) = commands.open() else {
        return (Status::EAGAIN, 0, "too many commands are in progress".to_owned());
    };
    // SAFETY: tickets are freed with the component alone, when none of its functions runs
    // any more.
    let ticket = unsafe { &*ticket };
    match offered.motion.push(source, command, TicketHandle::new(ticket)) {
        Ok(()) => (Status::OK, id, String::new()),
        Err(why) => {
            ticket.fail("refused");
            let status = if why.status == Status::EAGAIN { why.status } else { Status::EINVAL };
            (status, 0, why.text().unwrap_or("refused").to_owned())
        }
    }
}

/// # Safety
/// As [`answer`].
unsafe extern "C" fn poll<M: Motion>(
    ctx: *const c_void,
    id: u64,
    out: *mut MotionAnswer,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer::<M>(ctx, out, |_, commands| match commands.end_of(id) {
            MotionEnd::Done => (Status::OK, id, String::new()),
            MotionEnd::Pending => (Status::EAGAIN, id, String::new()),
            MotionEnd::Failed(why) => (Status::EINVAL, id, why),
            MotionEnd::Forgotten => (Status::ENOENT, id, String::new()),
        })
    }
}

/// # Safety
/// `ctx` must be null or point to a live `Offered<M>`; `words` must be null or point to `n` live
/// words.
unsafe extern "C" fn status<M: Motion>(ctx: *const c_void, words: *mut u64, n: u32) -> u32 {
    // SAFETY: guaranteed by the caller.
    let offered = unsafe { ctx.cast::<Offered<M>>().as_ref() };
    let (Some(offered), false) = (offered, words.is_null() || !words.is_aligned()) else {
        return 0;
    };
    let Ok(Some(status)) = shim::guarded(|| offered.motion.status()) else { return 0 };
    // SAFETY: guaranteed by the caller.
    let words = unsafe { core::slice::from_raw_parts_mut(words, n as usize) };
    let mut words = words.iter_mut();
    status.store(&mut |bits| {
        if let Some(word) = words.next() {
            *word = bits;
        }
    });
    u32::try_from(MotionStatus::WORDS).unwrap_or(0)
}

/// # Safety
/// `ctx` must be null or point to a live `Offered<M>`; `command` must be null or point to a live
/// record whose size is its own; `value` must be null or point to a live number.
unsafe extern "C" fn setting<M: Motion>(
    ctx: *const c_void,
    command: *const MotionCommand,
    value: *mut f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let offered = unsafe { ctx.cast::<Offered<M>>().as_ref() };
    // SAFETY: guaranteed by the caller.
    let command = unsafe { MotionCommand::read(command) };
    // SAFETY: guaranteed by the caller.
    let value = unsafe { value.as_mut() };
    let (Some(offered), Some(command), Some(value)) = (offered, command, value) else {
        return Status::EINVAL;
    };
    match shim::guarded(|| offered.motion.setting(&command)) {
        Ok(Ok(now)) => {
            *value = now;
            Status::OK
        }
        Ok(Err(_)) => Status::EINVAL,
        Err(_) => Status::EFAULT,
    }
}

/// # Safety
/// `ctx` must be null or point to a live `Offered<M>`.
unsafe extern "C" fn epoch<M: Motion>(ctx: *const c_void) -> u64 {
    // SAFETY: guaranteed by the caller.
    let offered = unsafe { ctx.cast::<Offered<M>>().as_ref() };
    offered.map_or(0, |o| shim::guarded(|| o.motion.epoch()).unwrap_or(0))
}

#[cfg(test)]
mod tests;
