//! The state machine of the tool changer: requests, answers, and the tool in the spindle.
//!
//! ```text
//!              prepare                tool-prepared
//! idle ─▶ (wait) ─▶ preparing ───────────────────────▶ idle, with a tool prepared
//! idle ─▶ (wait) ─▶ changing  ───────────────────────▶ idle, with the tool in the spindle
//!              change                 tool-changed
//! ```
//!
//! A request waits while the answer to the request before it is still TRUE, so that no answer counts twice. An abort or
//! an e-stop withdraws the request. After a withdrawn change the tool in the spindle is unknown, so the next change is made
//! whatever tool is asked for. `states.md` has every state and transition; `tests/explore.rs` finds them.

/// Requested tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Tool {
    pub(crate) number: i32,
    pub(crate) pocket: i32,
    pub(crate) index: i32,
}

/// Number of the tool in the spindle if it is unknown.
pub(crate) const UNKNOWN: i32 = -1;
/// Number of cycles for an answer to end after its request.
const RELEASE_CYCLES: u32 = 10;

const CHANGING: &str = "a tool is being changed";
const STALE_PREPARED: &str = "{iocontrol.0.tool-prepared} stays TRUE without a request: an answer ends with \
     its request. Link tool-prepare to tool-prepared where nothing answers";
const STALE_CHANGED: &str = "{iocontrol.0.tool-changed} stays TRUE without a request: an answer ends with its \
     request. Link tool-change to tool-changed where nothing answers";

/// Progress of the current request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Phase {
    Idle,
    /// The answer to the request before is still TRUE, for at most these cycles.
    WaitToPrepare(u32),
    Preparing,
    /// As `WaitToPrepare`.
    WaitToChange(u32),
    Changing,
}

/// Levels of the two answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Answers {
    pub(crate) prepared: bool,
    pub(crate) changed: bool,
}

/// End of the current request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Prepared,
    Changed,
    Failed(&'static str),
}

/// The tool changer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Changer {
    pub(crate) phase: Phase,
    /// Tool that is prepared or being prepared.
    shown: Tool,
    pub(crate) is_prepared: bool,
    /// Tool in the spindle; unknown after a withdrawn change, until a change ends or the tool is stated.
    spindle: Tool,
}

impl Changer {
    pub(crate) const fn new() -> Self {
        let none = Tool { number: 0, pocket: 0, index: 0 };
        let phase = Phase::Idle;
        Self { phase, shown: none, is_prepared: false, spindle: none }
    }

    /// Returns the tool that is prepared or being prepared.
    pub(crate) const fn shown(&self) -> Tool {
        self.shown
    }

    pub(crate) const fn spindle(&self) -> Tool {
        self.spindle
    }

    /// Returns the levels of tool-prepare and tool-change.
    pub(crate) const fn requests(&self) -> (bool, bool) {
        (matches!(self.phase, Phase::Preparing), matches!(self.phase, Phase::Changing))
    }

    /// Begins to prepare a tool.
    pub(crate) fn prepare(&mut self, tool: Tool, answers: Answers) -> Result<(), &'static str> {
        self.needs_idle()?;
        (self.shown, self.is_prepared) = (tool, false);
        self.phase = match answers.prepared {
            true => Phase::WaitToPrepare(RELEASE_CYCLES),
            false => Phase::Preparing,
        };
        Ok(())
    }

    /// Begins to change the tool. Returns true if the tool is in the spindle already.
    pub(crate) fn change(&mut self, answers: Answers) -> Result<bool, &'static str> {
        self.needs_idle()?;
        if !self.is_prepared {
            return Err("no tool is prepared: iocontrol.prepare tool=N comes first");
        }
        if self.shown.number == self.spindle.number {
            return Ok(true);
        }
        self.phase = match answers.changed {
            true => Phase::WaitToChange(RELEASE_CYCLES),
            false => Phase::Changing,
        };
        Ok(false)
    }

    /// States the tool in the spindle.
    pub(crate) fn set_tool(&mut self, tool: Tool) -> Result<(), &'static str> {
        if self.phase == Phase::Changing {
            return Err(CHANGING);
        }
        self.spindle = tool;
        Ok(())
    }

    /// Withdraws the current request. Returns whether there was one. A prepared tool stays prepared.
    pub(crate) fn withdraw(&mut self) -> bool {
        if self.phase == Phase::Changing {
            self.spindle = Tool { number: UNKNOWN, pocket: UNKNOWN, index: 0 };
        }
        core::mem::replace(&mut self.phase, Phase::Idle) != Phase::Idle
    }

    /// Follows the answers for one cycle.
    pub(crate) fn follow(&mut self, answers: Answers) -> Option<End> {
        match self.phase {
            Phase::WaitToPrepare(_) if !answers.prepared => self.phase = Phase::Preparing,
            Phase::WaitToChange(_) if !answers.changed => self.phase = Phase::Changing,
            Phase::WaitToPrepare(0) => return Some(self.fail(STALE_PREPARED)),
            Phase::WaitToChange(0) => return Some(self.fail(STALE_CHANGED)),
            Phase::WaitToPrepare(left) => self.phase = Phase::WaitToPrepare(left - 1),
            Phase::WaitToChange(left) => self.phase = Phase::WaitToChange(left - 1),
            Phase::Preparing if answers.prepared => {
                (self.phase, self.is_prepared) = (Phase::Idle, true);
                return Some(End::Prepared);
            }
            Phase::Changing if answers.changed => {
                (self.phase, self.is_prepared) = (Phase::Idle, false);
                self.spindle = core::mem::take(&mut self.shown);
                return Some(End::Changed);
            }
            Phase::Idle | Phase::Preparing | Phase::Changing => {}
        }
        None
    }

    fn fail(&mut self, why: &'static str) -> End {
        self.phase = Phase::Idle;
        End::Failed(why)
    }

    fn needs_idle(&self) -> Result<(), &'static str> {
        match self.phase {
            Phase::Idle => Ok(()),
            Phase::WaitToPrepare(_) | Phase::Preparing => Err("a tool is being prepared"),
            Phase::WaitToChange(_) | Phase::Changing => Err(CHANGING),
        }
    }
}
