//! The record of what the job waits for: who, since when, and how it goes on.

use super::{
    Core, Reading, Waiting,
    awaited::{PageHold, WaitRecord},
};
use crate::outside::{MotionState, Outside};
use hal_component::Wait;
use hal_gcode::Request;

/// The pin by which a lost page holds motion.
const PAGE: &str = "remote.hold";
/// Seconds between two looks at that pin, while the feed is inhibited.
const LOOK: f64 = 1.0;

/// A wait as it is found in one step.
struct FoundWait {
    kind: Wait,
    number: i32,
    since: Option<f64>,
    until: Option<f64>,
    ends: bool,
}

impl FoundWait {
    const fn of(kind: Wait, number: i32) -> Self {
        Self { kind, number, since: None, until: None, ends: kind.ends_by_itself() }
    }

    const fn until(self, until: f64) -> Self {
        Self { until: Some(until), ends: true, ..self }
    }

    /// Returns what motion waits for.
    fn of_motion(motion: &MotionState) -> Self {
        let Self { kind, number, .. } = Self::of(Wait::of(motion.wait), motion.wait_number);
        let ends = kind.ends_by_itself() || motion.wait_ends;
        Self { kind, number, since: Some(motion.wait_since), until: None, ends }
    }
}

impl Core {
    /// Returns what the job waits for.
    pub(crate) const fn wait_record(&self) -> &WaitRecord {
        &self.waits.record
    }

    /// Keeps the record of what the job waits for.
    pub(super) fn follow_wait(&mut self, out: &mut impl Outside) {
        let motion = out.motion();
        if let Some(job) = self.job.as_mut().filter(|job| !job.paused) {
            job.why_paused = Wait::Pause;
        }
        let mut found = self.find_wait(&motion);
        if found.kind == Wait::FeedInhibit {
            found.kind = if self.is_page_lost(out) { Wait::Page } else { found.kind };
        } else {
            self.waits.page = PageHold::default();
        }
        let record = &self.waits.record;
        let is_same = (record.kind, record.number) == (found.kind, found.number);
        let detail = self.detail(&found, &motion);
        if is_same && detail == self.waits.detail {
            (self.waits.record.until, self.waits.record.ends) = (found.until, found.ends);
            return;
        }
        let since = if is_same { record.since } else { found.since.unwrap_or_else(|| out.now()) };
        self.waits.detail = detail;
        self.waits.record = WaitRecord {
            kind: found.kind,
            number: found.number,
            since,
            until: found.until,
            ends: found.ends,
            text: self.wait_text(&found, &motion).into(),
        };
    }

    fn find_wait(&self, motion: &MotionState) -> FoundWait {
        let Some(job) = &self.job else { return FoundWait::of_motion(motion) };
        if job.paused {
            let kind = match job.why_paused {
                Wait::Pause if motion.spindles_stopped != 0 => Wait::SpindleStopped,
                why => why,
            };
            let is_spindle = kind == Wait::SpindleStopped;
            return FoundWait::of(
                kind,
                if is_spindle { first(motion.spindles_stopped) } else { 0 },
            );
        }
        if let Some(tool) = self.awaited_tool() {
            return FoundWait::of(Wait::Tool, tool);
        }
        match &self.waiting {
            Some(Waiting::Dwell { until }) => FoundWait::of(Wait::Dwell, 0).until(*until),
            Some(Waiting::Input { index, until, .. }) => {
                FoundWait::of(Wait::Input, i32::try_from(*index).unwrap_or(0)).until(*until)
            }
            Some(Waiting::Oriented { .. }) => FoundWait::of(Wait::Orient, motion.wait_number),
            Some(Waiting::Program(code)) => FoundWait::of(Wait::Program, i32::from(*code)),
            Some(Waiting::Io(_)) => FoundWait::of(Wait::Io, 0),
            Some(Waiting::Change { tool, .. }) => FoundWait::of(Wait::Tool, *tool),
            Some(Waiting::Order(_)) => FoundWait::of_motion(motion),
            None if !self.flight.is_empty() => FoundWait::of_motion(motion),
            None if job.is_stepping_function
                && matches!(job.reading, Reading::Asked(Request::Function { .. })) =>
            {
                FoundWait::of(Wait::Function, 0)
            }
            None => FoundWait::of(Wait::Nothing, 0),
        }
    }

    /// Returns what the text of a wait depends on, besides its kind and number.
    fn detail(&self, found: &FoundWait, motion: &MotionState) -> u32 {
        match (found.kind, &self.waiting) {
            (Wait::Input, Some(Waiting::Input { analog, mode, .. })) => {
                u32::from(*analog) << 8 | u32::from(*mode)
            }
            (Wait::Stop | Wait::OptionalStop | Wait::Pallet | Wait::Step, _) => {
                motion.spindles_stopped
            }
            (Wait::SpindleStopped, _) => motion.spindles_inhibited,
            _ => 0,
        }
    }

    fn wait_text(&self, found: &FoundWait, motion: &MotionState) -> String {
        let owner = if self.job.is_some() { "task" } else { "motion" };
        let n = found.number;
        let text = found.kind.text(owner, n);
        match (found.kind, &self.waiting) {
            (Wait::Input, Some(Waiting::Input { analog, mode, .. })) => {
                let pin = if *analog { "analog-in" } else { "digital-in" };
                let what = match mode {
                    1 => "rises",
                    2 => "falls",
                    3 => "is TRUE",
                    4 => "is FALSE",
                    _ => "is read",
                };
                format!(
                    "input {n} at M66: it goes on when motion.{pin}-{n:02} {what}, or its time is over"
                )
            }
            (Wait::AtSpeed, _) => {
                let seconds = self.rules.at_speed_timeout;
                format!("{text}; the job ends after {seconds} s")
            }
            (Wait::SpindleStopped, _) if motion.spindles_inhibited >> n & 1 != 0 => {
                format!("{text}; spindle.{n}.inhibit must be FALSE first")
            }
            (Wait::Stop | Wait::OptionalStop | Wait::Pallet | Wait::Step, _)
                if motion.spindles_stopped != 0 =>
            {
                let stopped = first(motion.spindles_stopped);
                format!("{text}; spindle {stopped}, which was stopped, turns again then")
            }
            _ => text,
        }
    }

    /// Asks whether it is a lost page that inhibits the feed, and returns the last answer.
    fn is_page_lost(&mut self, out: &mut impl Outside) -> bool {
        let now = out.now();
        let page = &mut self.waits.page;
        match page.question {
            Some(question) => {
                if let Some(answer) = out.take_value(question) {
                    page.question = None;
                    page.holds = answer.is_some_and(|value| value != 0.0);
                }
            }
            None if page.asked == 0.0 || now - page.asked >= LOOK => {
                (page.question, page.asked) = (Some(out.ask_value(PAGE)), now);
            }
            None => {}
        }
        page.holds
    }
}

/// Returns the lowest number in a set of bits.
fn first(bits: u32) -> i32 {
    bits.trailing_zeros().cast_signed()
}
