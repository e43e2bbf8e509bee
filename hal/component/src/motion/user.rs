//! The side of the service `motion` that uses it.

use crate::{
    MotionStatus, Plain, StopEpoch, Touch, Uses,
    abi::{self, MotionAnswer, MotionCommand, Status, Str},
    service::Found,
};

/// The motion controller that another plugin offers. For tasks, workers and commands.
#[derive(Clone, Debug)]
pub struct MotionRef(pub(crate) Found<abi::Motion>);

/// Proof that a component owns motion. A later owner of the same name makes it void.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionToken(pub(super) u64);

impl MotionToken {
    /// Token of every local source: it needs no ownership.
    pub const LOCAL: Self = Self(0);
}

/// Number of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MotionId(pub(super) u64);

/// Reason for which a command was not accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionRefusal {
    /// There is no room: try again later.
    Full,
    /// The token is void.
    NotOwner,
    /// The command is refused, for this reason.
    Refused(String),
}

/// Progress of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionEnd {
    /// In progress.
    Pending,
    /// Complete.
    Done,
    /// Aborted or refused, for this reason.
    Failed(String),
    /// Unknown: a command that ended too long ago, or never existed.
    Forgotten,
}

impl MotionRef {
    /// Becomes the owner of motion. A component that asks again under its name gets a new token.
    ///
    /// # Errors
    /// Another component owns motion.
    pub fn acquire(&self, name: &str) -> Result<MotionToken, MotionRefusal> {
        let mut out = MotionAnswer::EMPTY;
        let acquire = self.0.table.acquire.ok_or_else(missing)?;
        // SAFETY: this is the provider's function with its own context; both live for the call.
        let status = unsafe { acquire(self.0.table.ctx, Str::borrow(name), &raw mut out) };
        if status.is_ok() {
            Ok(MotionToken(out.id))
        } else {
            Err(MotionRefusal::Refused(text(&out)))
        }
    }

    /// Ends the ownership and the claim. A void token changes nothing.
    pub fn release(&self, token: MotionToken) {
        if let Some(release) = self.0.table.release {
            // SAFETY: this is the provider's function with its own context.
            unsafe { release(self.0.table.ctx, token.0) };
        }
    }

    /// Begins or ends the claim: while it lasts, no other source may begin motion, even if nothing
    /// moves. An abort ends it too. Returns false if the token is void.
    pub fn claim(&self, token: MotionToken, on: bool) -> bool {
        // SAFETY: this is the provider's function with its own context.
        self.0
            .table
            .claim
            .is_some_and(|f| unsafe { f(self.0.table.ctx, token.0, on.into()) }.is_ok())
    }

    /// Returns the number of moves for which there is room.
    #[must_use]
    pub fn room(&self) -> u32 {
        // SAFETY: this is the provider's function with its own context.
        self.0.table.room.map_or(0, |room| unsafe { room(self.0.table.ctx) })
    }

    /// Sends a command and returns its number. With [`MotionToken::LOCAL`] it is a local command, or a
    /// remote one if it says so.
    ///
    /// # Errors
    /// There is no room, the token is void, or the command is refused.
    pub fn push(
        &self,
        token: MotionToken,
        command: &MotionCommand,
    ) -> Result<MotionId, MotionRefusal> {
        let mut out = MotionAnswer::EMPTY;
        let push = self.0.table.push.ok_or_else(missing)?;
        // The record is this side's own, whatever the caller wrote into the field.
        let command = MotionCommand { size: abi::size::<MotionCommand>(), ..*command };
        // SAFETY: this is the provider's function with its own context; both live for the call.
        let status = unsafe { push(self.0.table.ctx, token.0, &raw const command, &raw mut out) };
        match status {
            Status::EAGAIN => Err(MotionRefusal::Full),
            Status::EBUSY => Err(MotionRefusal::NotOwner),
            status if status.is_ok() => Ok(MotionId(out.id)),
            _ => Err(MotionRefusal::Refused(text(&out))),
        }
    }

    /// Returns the progress of a command. The ends of the last 4096 commands are known.
    #[must_use]
    pub fn poll(&self, id: MotionId) -> MotionEnd {
        let Some(poll) = self.0.table.poll else { return MotionEnd::Forgotten };
        let mut out = MotionAnswer::EMPTY;
        // SAFETY: this is the provider's function with its own context; `out` lives for the call.
        match unsafe { poll(self.0.table.ctx, id.0, &raw mut out) } {
            Status::OK => MotionEnd::Done,
            Status::EAGAIN => MotionEnd::Pending,
            Status::ENOENT => MotionEnd::Forgotten,
            _ => MotionEnd::Failed(text(&out)),
        }
    }

    /// Returns the status of the latest cycle, always of one cycle. Fields that the provider does
    /// not have are zero. Returns `None` if there is no status.
    #[must_use]
    pub fn status(&self) -> Option<MotionStatus> {
        let mut words = vec![0_u64; MotionStatus::WORDS];
        let n = u32::try_from(words.len()).ok()?;
        let status = self.0.table.status?;
        // SAFETY: this is the provider's function with its own context; the words live for the call.
        let has = unsafe { status(self.0.table.ctx, words.as_mut_ptr(), n) };
        let mut words = words.into_iter();
        (has > 0).then(|| MotionStatus::load(&mut || words.next().unwrap_or(0)))
    }

    /// Returns the stop epoch, in which an order that is given now is given; zeros if the provider has none.
    #[must_use]
    pub fn epoch(&self) -> StopEpoch {
        // SAFETY: this is the provider's function with its own context.
        let number = self.0.table.epoch.map_or(0, |epoch| unsafe { epoch(self.0.table.ctx) });
        StopEpoch::of(number).unwrap_or_default()
    }

    /// Returns the setting that a command of the kind CONFIGURE names, if it exists.
    #[must_use]
    pub fn setting(&self, command: &MotionCommand) -> Option<f64> {
        let setting = self.0.table.setting?;
        let command = MotionCommand { size: abi::size::<MotionCommand>(), ..*command };
        let mut value = 0.0;
        // SAFETY: this is the provider's function with its own context; both live for the call.
        let status = unsafe { setting(self.0.table.ctx, &raw const command, &raw mut value) };
        status.is_ok().then_some(value)
    }
}

impl Touch for MotionRef {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

fn missing() -> MotionRefusal {
    MotionRefusal::Refused("the motion controller does not have this function".to_owned())
}

fn text(out: &MotionAnswer) -> String {
    let len = usize::try_from(out.len).unwrap_or(0);
    let text = out.text.get(..len).unwrap_or(&out.text);
    String::from_utf8_lossy(text).into_owned()
}
