//! The service `operator`: buttons and lamps of an operator for the task.

use crate::{
    StopEpoch, Touch, Uses,
    abi::{self, OPERATOR_TEXT, OperatorCommand, OperatorView, Record, Status},
    service::Found,
    shim,
};
use core::ffi::c_void;

/// A request of the operator to the task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OperatorRequest {
    /// Changes the mode: 0 manual, 1 auto, 2 MDI.
    Mode(u32),
    /// Runs the open program.
    Run,
    /// Pauses the program.
    Pause,
    /// Goes on after a pause.
    Resume,
    /// Goes on to the next line.
    Step,
    /// Ends the program.
    Stop,
    /// Switches the optional stop (M1) on or off.
    OptionalStop(bool),
    /// Switches on or off that lines that begin with / are left out.
    BlockDelete(bool),
    /// Executes a line, in whatever mode, and returns to the mode before it.
    Mdi(String),
}

/// Buttons and lamps that a component offers to the task.
pub trait Operator: Touch + Send + Sync + 'static {
    /// Takes the oldest request, with the stop epoch in which it was made. A task calls it in every step of its worker.
    fn take(&self) -> Option<(OperatorRequest, StopEpoch)>;
    /// Shows the state of the task.
    fn show(&self, view: &OperatorView);
}

impl OperatorRequest {
    /// Returns the record of a request. A text beyond the record's length gives none.
    fn record(&self) -> Option<OperatorCommand> {
        let mut record = OperatorCommand::EMPTY;
        (record.kind, record.value) = match self {
            Self::Mode(mode) => (1, *mode),
            Self::Run => (2, 0),
            Self::Pause => (3, 0),
            Self::Resume => (4, 0),
            Self::Step => (5, 0),
            Self::Stop => (6, 0),
            Self::OptionalStop(on) => (7, u32::from(*on)),
            Self::BlockDelete(on) => (8, u32::from(*on)),
            Self::Mdi(line) => {
                let len = u32::try_from(line.len()).ok()?;
                record.text.get_mut(..line.len())?.copy_from_slice(line.as_bytes());
                record.len = len;
                (9, 0)
            }
        };
        Some(record)
    }

    fn of(record: &OperatorCommand) -> Option<Self> {
        Some(match (record.kind, record.value) {
            (1, mode @ 0..=2) => Self::Mode(mode),
            (2, _) => Self::Run,
            (3, _) => Self::Pause,
            (4, _) => Self::Resume,
            (5, _) => Self::Step,
            (6, _) => Self::Stop,
            (7, on) => Self::OptionalStop(on != 0),
            (8, on) => Self::BlockDelete(on != 0),
            (9, _) => {
                let text = record.text.get(..usize::try_from(record.len).ok()?)?;
                Self::Mdi(core::str::from_utf8(text).ok()?.to_owned())
            }
            _ => return None,
        })
    }
}

/// Returns the table for a value of this type.
pub(crate) const fn table<O: Operator>() -> abi::Operator {
    abi::Operator {
        size: abi::size::<abi::Operator>(),
        flags: 0,
        ctx: core::ptr::null(),
        take: Some(take::<O>),
        show: Some(show::<O>),
    }
}

/// # Safety
/// `ctx` must point to a live `O`; `out` must be null or point to a live record whose size is its
/// own.
unsafe extern "C" fn take<O: Operator>(ctx: *const c_void, out: *mut OperatorCommand) -> Status {
    // SAFETY: this is the table's own context.
    let operator = unsafe { &*ctx.cast::<O>() };
    // SAFETY: guaranteed by the caller.
    let Some(given) = (unsafe { OperatorCommand::read(out) }) else { return Status::EINVAL };
    let taken = shim::guarded(|| operator.take());
    let Ok(request) = taken else { return Status::EFAULT };
    let record = request.and_then(|(request, epoch)| Some((request.record()?, epoch.number())));
    let Some((record, epoch)) = record else { return Status::EAGAIN };
    // SAFETY: the record is live, and `read` checked that it has at least this size.
    unsafe { out.write(OperatorCommand { size: given.size, epoch, ..record }) };
    Status::OK
}

/// # Safety
/// `ctx` must point to a live `O`; `view` must be null or point to a live record.
unsafe extern "C" fn show<O: Operator>(ctx: *const c_void, view: *const OperatorView) -> Status {
    // SAFETY: this is the table's own context.
    let operator = unsafe { &*ctx.cast::<O>() };
    // SAFETY: guaranteed by the caller.
    let Some(view) = (unsafe { OperatorView::read(view) }) else { return Status::EINVAL };
    let shown = shim::guarded(|| operator.show(&view));
    if shown.is_ok() { Status::OK } else { Status::EFAULT }
}

/// Buttons and lamps that another plugin offers, for the task.
#[derive(Clone, Debug)]
pub struct OperatorRef(pub(crate) Found<abi::Operator>);

impl OperatorRef {
    /// Takes the oldest request of the operator, with the stop epoch in which it was made. A record that is none ends the list for this time.
    #[must_use]
    pub fn take(&self) -> Option<(OperatorRequest, Option<StopEpoch>)> {
        let take = self.0.table.take?;
        let mut out = OperatorCommand::EMPTY;
        // SAFETY: this is the provider's function with its own context; `out` lives for the call.
        let status = unsafe { take(self.0.table.ctx, &raw mut out) };
        let request = if status.is_ok() { OperatorRequest::of(&out) } else { None };
        request.map(|request| (request, StopEpoch::of(out.epoch)))
    }

    /// Shows the state of the task.
    pub fn show(&self, view: &OperatorView) {
        let view = OperatorView { size: abi::size::<OperatorView>(), ..*view };
        if let Some(show) = self.0.table.show {
            // SAFETY: this is the provider's function with its own context.
            unsafe { show(self.0.table.ctx, &raw const view) };
        }
    }
}

impl Touch for OperatorRef {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

const _: () = assert!(OPERATOR_TEXT <= u32::MAX as usize);

#[cfg(test)]
mod tests {
    use super::{OPERATOR_TEXT, OperatorCommand, OperatorRequest};

    #[test]
    fn a_record_gives_the_request_back() {
        use OperatorRequest as R;
        let line = "G0 X1 (ä)".to_owned();
        let all = [
            R::Mode(2),
            R::Run,
            R::Pause,
            R::Resume,
            R::Step,
            R::Stop,
            R::OptionalStop(true),
            R::BlockDelete(false),
            R::Mdi(line),
        ];
        for request in all {
            assert_eq!(R::of(&request.record().unwrap()), Some(request));
        }
        assert!(R::Mdi("x".repeat(OPERATOR_TEXT)).record().is_some());
        assert!(R::Mdi("x".repeat(OPERATOR_TEXT + 1)).record().is_none());
    }

    #[test]
    fn records_that_are_none_give_nothing() {
        let record = OperatorCommand::EMPTY;
        for wrong in [
            record,
            OperatorCommand { kind: 10, ..record },
            OperatorCommand { kind: 1, value: 3, ..record },
            OperatorCommand { kind: 9, len: u32::MAX, ..record },
            OperatorCommand { kind: 9, len: 2, text: [0xff; OPERATOR_TEXT], ..record },
        ] {
            assert_eq!(OperatorRequest::of(&wrong), None, "{wrong:?}");
        }
    }
}
