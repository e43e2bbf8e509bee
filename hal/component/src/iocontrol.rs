//! The service `iocontrol`: e-stop, coolant and tool changer for the worker that controls jobs.

use crate::{
    Estop, Touch, Uses,
    abi::{self, IoCommand, IoOutcome, IoStatus, Record, Str},
    service::Found,
    shim,
};
use core::ffi::c_void;

const MIST: u32 = 1;
const FLOOD: u32 = 2;
const LUBE: u32 = 4;
const LUBE_LEVEL: u32 = 8;

/// A request to the controls of a machine other than motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoRequest {
    /// Puts the machine into e-stop, at once.
    Estop,
    /// Leaves e-stop.
    EstopReset,
    /// Asks the changer to prepare a tool.
    Prepare {
        /// Number of the tool, 0 for none.
        tool: i32,
        /// Pocket of the tool.
        pocket: i32,
        /// Place in the tool table.
        index: i32,
    },
    /// Puts the prepared tool into the spindle.
    Change,
    /// States which tool is in the spindle.
    SetTool {
        /// Number of the tool, 0 for none.
        tool: i32,
        /// Pocket that it came from.
        pocket: i32,
    },
    /// Switches coolant and lubrication; `None` leaves an output as it is.
    Coolant {
        /// Mist.
        mist: Option<bool>,
        /// Flood.
        flood: Option<bool>,
        /// Lubrication.
        lube: Option<bool>,
    },
    /// Switches coolant off and withdraws requests to the changer.
    Abort,
}

/// Result of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoResult {
    /// Number of the request.
    pub id: u64,
    /// Reason of its failure; `None` if it succeeded.
    pub failure: Option<&'static str>,
}

/// State of the controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoState {
    /// E-stop.
    pub estop: Estop,
    /// Mist coolant is on.
    pub mist: bool,
    /// Flood coolant is on.
    pub flood: bool,
    /// Lubrication is on.
    pub lube: bool,
    /// There is enough lubricant.
    pub lube_level: bool,
    /// Number of the tool in the spindle.
    pub tool: i32,
    /// Pocket that it came from.
    pub pocket: i32,
    /// Number of the prepared tool.
    pub prepared: i32,
}

/// Controls that a component offers. Several workers may send requests at once; one of them takes the results.
pub trait IoControl: Touch + Send + Sync + 'static {
    /// Begins a request and returns its number, above 0; `None` if too many requests wait.
    fn request(&self, request: IoRequest) -> Option<u64>;
    /// Takes the oldest result.
    fn result(&self) -> Option<IoResult>;
    /// Returns the current state.
    fn state(&self) -> IoState;
}

impl IoRequest {
    fn record(self) -> IoCommand {
        let mut record = IoCommand {
            size: abi::size::<IoCommand>(),
            kind: 0,
            tool: 0,
            pocket: 0,
            index: 0,
            changes: 0,
            values: 0,
        };
        match self {
            Self::Estop => record.kind = 1,
            Self::EstopReset => record.kind = 2,
            Self::Prepare { tool, pocket, index } => {
                (record.kind, record.tool, record.pocket, record.index) = (3, tool, pocket, index);
            }
            Self::Change => record.kind = 4,
            Self::SetTool { tool, pocket } => {
                (record.kind, record.tool, record.pocket) = (5, tool, pocket);
            }
            Self::Coolant { mist, flood, lube } => {
                record.kind = 6;
                for (bit, value) in [(MIST, mist), (FLOOD, flood), (LUBE, lube)] {
                    record.changes |= if value.is_some() { bit } else { 0 };
                    record.values |= if value == Some(true) { bit } else { 0 };
                }
            }
            Self::Abort => record.kind = 7,
        }
        record
    }

    /// Decodes a record. Unknown kinds, negative tools and unknown outputs are no request.
    fn of(record: &IoCommand) -> Option<Self> {
        let IoCommand { tool, pocket, index, .. } = *record;
        let output = |bit| (record.changes & bit != 0).then_some(record.values & bit != 0);
        Some(match record.kind {
            1 => Self::Estop,
            2 => Self::EstopReset,
            3 if tool >= 0 && pocket >= 0 => Self::Prepare { tool, pocket, index },
            4 => Self::Change,
            5 if tool >= 0 && pocket >= 0 => Self::SetTool { tool, pocket },
            6 if record.changes & !(MIST | FLOOD | LUBE) == 0 => {
                Self::Coolant { mist: output(MIST), flood: output(FLOOD), lube: output(LUBE) }
            }
            7 => Self::Abort,
            _ => return None,
        })
    }
}

/// Returns the table for a value of this type.
pub(crate) const fn table<C: IoControl>() -> abi::IoControl {
    abi::IoControl {
        size: abi::size::<abi::IoControl>(),
        flags: 0,
        ctx: core::ptr::null(),
        request: Some(request::<C>),
        result: Some(result::<C>),
        state: Some(state::<C>),
    }
}

/// # Safety
/// `ctx` must point to a live `C`, and `record` to a live record.
unsafe extern "C" fn request<C: IoControl>(ctx: *const c_void, record: *const IoCommand) -> u64 {
    // SAFETY: this is the table's own context.
    let control = unsafe { &*ctx.cast::<C>() };
    // SAFETY: guaranteed by the caller.
    let record = unsafe { IoCommand::read(record) };
    let request = record.and_then(|r| IoRequest::of(&r));
    request.and_then(|r| shim::guarded(|| control.request(r)).ok().flatten()).unwrap_or(0)
}

/// # Safety
/// `ctx` must point to a live `C`, and `out` to a live record.
unsafe extern "C" fn result<C: IoControl>(ctx: *const c_void, out: *mut IoOutcome) -> u32 {
    // SAFETY: this is the table's own context.
    let control = unsafe { &*ctx.cast::<C>() };
    let Ok(Some(result)) = shim::guarded(|| control.result()) else { return 0 };
    let why = Str::new(result.failure.unwrap_or_default());
    // SAFETY: guaranteed by the caller.
    unsafe { out.write(IoOutcome { id: result.id, why }) };
    1
}

/// # Safety
/// `ctx` must point to a live `C`, and `out` to a live record.
unsafe extern "C" fn state<C: IoControl>(ctx: *const c_void, out: *mut IoStatus) {
    // SAFETY: this is the table's own context.
    let control = unsafe { &*ctx.cast::<C>() };
    // After a panic, the record stays as the caller made it: in e-stop.
    let Ok(state) = shim::guarded(|| control.state()) else { return };
    let bit = |on: bool, bit: u32| if on { bit } else { 0 };
    let status = IoStatus {
        interlock: state.estop.bits(),
        outputs: bit(state.mist, MIST)
            | bit(state.flood, FLOOD)
            | bit(state.lube, LUBE)
            | bit(state.lube_level, LUBE_LEVEL),
        tool: state.tool,
        pocket: state.pocket,
        prepared: state.prepared,
        reserved: 0,
    };
    // SAFETY: guaranteed by the caller.
    unsafe { out.write(status) };
}

/// Controls that another plugin offers.
#[derive(Clone, Debug)]
pub struct IoControlRef(pub(crate) Found<abi::IoControl>);

impl IoControlRef {
    /// Begins a request and returns its number; `None` if too many requests wait.
    pub fn request(&mut self, request: IoRequest) -> Option<u64> {
        let record = request.record();
        let begin = self.0.table.request?;
        // SAFETY: this is the provider's function with its own context; the record lives during the call.
        let id = unsafe { begin(self.0.table.ctx, &raw const record) };
        (id != 0).then_some(id)
    }

    /// Takes the oldest result.
    pub fn result(&mut self) -> Option<IoResult> {
        let mut out = IoOutcome { id: 0, why: Str::new("") };
        let take = self.0.table.result?;
        // SAFETY: this is the provider's function with its own context; the record lives during the call.
        if unsafe { take(self.0.table.ctx, &raw mut out) } == 0 {
            return None;
        }
        // SAFETY: the provider's reasons are static.
        let why = unsafe { out.why.get() }.unwrap_or_default();
        Some(IoResult { id: out.id, failure: (!why.is_empty()).then_some(why) })
    }

    /// Returns the current state. Without a provider's function the machine is in e-stop.
    #[must_use]
    pub fn state(&self) -> IoState {
        let mut out =
            IoStatus { interlock: 0, outputs: 0, tool: 0, pocket: 0, prepared: 0, reserved: 0 };
        if let Some(state) = self.0.table.state {
            // SAFETY: this is the provider's function with its own context; the record lives during the call.
            unsafe { state(self.0.table.ctx, &raw mut out) };
        }
        IoState {
            estop: Estop::of(out.interlock),
            mist: out.outputs & MIST != 0,
            flood: out.outputs & FLOOD != 0,
            lube: out.outputs & LUBE != 0,
            lube_level: out.outputs & LUBE_LEVEL != 0,
            tool: out.tool,
            pocket: out.pocket,
            prepared: out.prepared,
        }
    }
}

impl Touch for IoControlRef {
    fn touch(&self, uses: &mut Uses) {
        self.0.touch(uses);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_keep_their_meaning_as_records() {
        for request in [
            IoRequest::Estop,
            IoRequest::EstopReset,
            IoRequest::Prepare { tool: 3, pocket: 7, index: 2 },
            IoRequest::Change,
            IoRequest::SetTool { tool: 3, pocket: 7 },
            IoRequest::Coolant { mist: Some(true), flood: None, lube: Some(false) },
            IoRequest::Abort,
        ] {
            assert_eq!(IoRequest::of(&request.record()), Some(request));
        }
        let good = IoRequest::Prepare { tool: 1, pocket: 1, index: 0 }.record();
        assert_eq!(IoRequest::of(&IoCommand { kind: 0, ..good }), None);
        assert_eq!(IoRequest::of(&IoCommand { kind: 8, ..good }), None);
        assert_eq!(IoRequest::of(&IoCommand { tool: -1, ..good }), None);
        assert_eq!(IoRequest::of(&IoCommand { kind: 6, changes: 8, ..good }), None);
    }
}
