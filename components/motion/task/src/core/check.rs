//! The check of the whole program, before its first step and ahead of its motion.
//!
//! Before the start, the check has [`BUDGET`] of time. What it finds wrong until then refuses the program, with all reasons, and
//! nothing begins. A longer program begins, and the check goes on ahead of it. The job pauses before the first line that is
//! wrong.

use super::{
    Core, Ticket,
    checking::{Checking, Start},
};
use crate::outside::{Level, Outside};
use hal_component::StopEpoch;
use hal_gcode::{Dialect, Interpreter, Text, foreign};
use hal_job::{
    check::{Check, Seen},
    effects::Outputs,
    world,
};
use std::path::{Path, PathBuf};

/// Seconds of the check before the start.
const BUDGET: f64 = 0.2;
/// Number of codes of another control that a refusal names.
const SHOWN_CODES: usize = 5;
/// Number of lines in one step of the worker before the start.
const LINES_BEFORE: u32 = 4000;
/// Number of lines in one step of the worker while the program runs.
const LINES_AHEAD: u32 = 250;
/// Number of lines that the check may be ahead of the program, which may have no end.
const MAX_AHEAD: u64 = 1_000_000;

impl Core {
    /// Begins the check of a program, which begins at its end.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn check_before_start(
        &mut self,
        path: PathBuf,
        ticket: Ticket,
        given: StopEpoch,
        stepping: bool,
        out: &mut impl Outside,
    ) -> Result<(), String> {
        let text = world::program_of(&self.world.machine, &path)?;
        self.forget_dry_run("another job has begun", out);
        self.take_over(out);
        let mut interpreter = Interpreter::from_state(self.interpreter.state.clone());
        interpreter.load(&Self::name_of(&path), text.clone());
        let check = Box::new(Check::new(interpreter, self.given()));
        let since = out.now();
        self.checking = Checking::default();
        self.checking.start = Some(Start { check, path, text, ticket, given, stepping, since });
        self.advance_start(out);
        Ok(())
    }

    /// Checks the next lines of a program that begins, or that runs.
    pub(super) fn advance_check(&mut self, out: &mut impl Outside) {
        self.advance_start(out);
        let number = self.interpreter.state.lines_run;
        let Some(ahead) = &mut self.checking.ahead else { return };
        if ahead.check.number() < number.saturating_add(MAX_AHEAD) {
            ahead.check.advance(&self.world, LINES_AHEAD);
        }
        let Some(first) = ahead.check.reasons().first().filter(|_| !ahead.told) else { return };
        ahead.told = true;
        // What was read already reports itself.
        ahead.pause = Some(first.number).filter(|n| *n >= number);
        let text = format!("{}: the program pauses before this line", first.text);
        if ahead.pause.is_some() {
            self.tell(Level::Error, &text, out);
        }
    }

    fn advance_start(&mut self, out: &mut impl Outside) {
        let Some(mut start) = self.checking.start.take() else { return };
        start.check.advance(&self.world, LINES_BEFORE);
        let has_time = self.is_checked_whole() || out.now() - start.since < BUDGET;
        if start.check.seen() == Seen::Part && has_time {
            self.checking.start = Some(start);
            return;
        }
        let Start { check, path, text, ticket, given, stepping, .. } = start;
        let may = self
            .may_begin(super::Mode::Auto, "a program", out)
            .and_then(|()| refusal(&check).map_err(|why| self.with_control(&text, why)));
        if let Err(why) = may {
            return out.finish(ticket, Err(why));
        }
        self.take_over(out);
        self.interpreter.load(&Self::name_of(&path), text);
        self.begin_job(true, Some(ticket), given, stepping, out);
        self.begin_journal(&path, &Outputs::default(), out);
        self.checking.go_on(check);
    }

    /// Tells whether a program is checked to its end before anything moves: one in RS274-D, which has no loops.
    fn is_checked_whole(&self) -> bool {
        self.interpreter.state.settings.dialect == Dialect::Rs274d
    }

    /// Checks the first lines of a program from its middle, from which it begins now.
    ///
    /// # Errors
    /// They are wrong; all reasons.
    pub(super) fn check_rest(
        &self,
        mut interpreter: Interpreter,
        path: &Path,
    ) -> Result<Box<Check>, String> {
        // A job that goes on may have been opened under another name for the same path.
        let name = interpreter.state.levels.first().map(|level| level.file.clone());
        let text = world::program_of(&self.world.machine, path)?;
        interpreter.supply(&name.unwrap_or_default(), text.clone());
        let mut check = Box::new(Check::new(interpreter, self.given()));
        check.advance(&self.world, LINES_BEFORE);
        // The rest of a program in RS274-D too is checked before anything moves.
        while self.is_checked_whole() && check.seen() == Seen::Part {
            check.advance(&self.world, LINES_BEFORE);
        }
        refusal(&check).map(|()| check).map_err(|why| self.with_control(&text, why))
    }

    /// Puts the control that a refused program was written for before the reasons, if it is another one.
    fn with_control(&self, text: &Text, why: String) -> String {
        let settings = &self.interpreter.state.settings;
        if settings.dialect != Dialect::LinuxCnc {
            return why;
        }
        // A file that cannot be read has that as its reason.
        match foreign::survey(text, &settings.remaps, &self.world) {
            Ok(Some(found)) => format!("{}; {why}", found.summary(SHOWN_CODES)),
            Ok(None) | Err(_) => why,
        }
    }

    /// Ends the check of a program, which does not begin or has ended.
    pub(super) fn forget_check(&mut self, why: &str, out: &mut impl Outside) {
        if let Some(start) = core::mem::take(&mut self.checking).start {
            out.finish(start.ticket, Err(why.to_owned()));
        }
    }

    /// Returns an estimate of the seconds until the end of the program; `None` while it is not known.
    pub(crate) fn time_left(&self) -> Option<f64> {
        self.job.as_ref()?;
        self.checking.time_left(self.unfinished().0)
    }
}

/// Returns all reasons that a check has found.
fn refusal(check: &Check) -> Result<(), String> {
    let reasons: Vec<&str> = check.reasons().iter().map(|reason| &*reason.text).collect();
    if reasons.is_empty() { Ok(()) } else { Err(reasons.join("; ")) }
}
