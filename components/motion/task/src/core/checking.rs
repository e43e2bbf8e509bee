//! The state of the check of a program: before its start, or ahead of it.

use crate::outside::Ticket;
use hal_component::StopEpoch;
use hal_gcode::Text;
use hal_job::check::Check;
use std::path::PathBuf;

/// Seconds of motion from which the estimate of the time follows the machine.
const SETTLED: f64 = 10.0;

/// The check, before the start of a program or ahead of it.
#[derive(Default)]
pub(super) struct Checking {
    pub(super) start: Option<Start>,
    pub(super) ahead: Option<Ahead>,
}

/// A program that begins when its check allows it.
pub(super) struct Start {
    pub(super) check: Box<Check>,
    pub(super) path: PathBuf,
    pub(super) text: Text,
    pub(super) ticket: Ticket,
    pub(super) given: StopEpoch,
    pub(super) stepping: bool,
    pub(super) since: f64,
}

/// A check ahead of the program.
pub(super) struct Ahead {
    pub(super) check: Box<Check>,
    /// Number of lines before the first wrong line, before which the job pauses.
    pub(super) pause: Option<u64>,
    /// The first reason was told.
    pub(super) told: bool,
    /// Seconds in which the job moved.
    moved: f64,
    /// Number of lines before the one in progress, and the seconds in which the job moved before it.
    line: (u64, f64),
}

impl Checking {
    /// Returns whether a program is checked before its start.
    pub(super) fn is_before_start(&self) -> bool {
        self.start.is_some()
    }

    /// Returns the stop epoch in which the program was started that is checked before its start.
    pub(super) fn given(&self) -> Option<StopEpoch> {
        self.start.as_ref().map(|start| start.given)
    }

    /// Goes on with a check ahead of the program, which begins now.
    pub(super) fn go_on(&mut self, check: Box<Check>) {
        self.ahead = Some(Ahead { check, pause: None, told: false, moved: 0.0, line: (0, 0.0) });
    }

    /// Ends the check ahead of the program.
    pub(super) fn end_ahead(&mut self) {
        self.ahead = None;
    }

    /// Adds seconds in which the job moved on the line after `number` lines.
    pub(super) fn pass(&mut self, seconds: f64, number: u64) {
        if let Some(ahead) = &mut self.ahead {
            if ahead.line.0 != number {
                ahead.line = (number, ahead.moved);
            }
            ahead.moved += seconds;
        }
    }

    /// Returns true once, before the first wrong line.
    pub(super) fn pauses_before(&mut self, number: u64) -> bool {
        self.ahead.as_mut().is_some_and(|ahead| ahead.pause.take_if(|n| *n == number).is_some())
    }

    /// Returns the estimate of the seconds that the program still takes before a line has run.
    pub(super) fn time_left(&self, number: u64) -> Option<f64> {
        let ahead = self.ahead.as_ref()?;
        let before = |number| ahead.check.seconds(number).0;
        let whole = ahead.check.seconds(number).1?;
        let moved = if ahead.line.0 == number { ahead.line.1 } else { ahead.moved };
        // Accelerations and overrides make the lines so far slower or faster than their estimate.
        let done = before(number) - before(ahead.check.first());
        let pace = (moved + SETTLED) / (done + SETTLED);
        // The line in progress takes its part of the estimate; what follows it is not shorter for a line that takes longer.
        let after = (whole - before(number.saturating_add(1))).max(0.0) * pace;
        Some(((whole - before(number)).max(0.0) * pace - (ahead.moved - moved)).max(after))
    }
}
