//! Values of HAL that a line reads, `#<_hal[NAME]>`: the machine is asked for them before the line is run, so that they are those
//! behind the motion of the lines before.

use super::{Interpreter, Step, execute::failed};
use crate::{
    canon::Issued,
    environment::{Environment, Text},
    error::{Error, Problem},
    question::{Answer, Request},
    state::{Cursor, Level, Pending},
    text::{comment::Kind, line::Line},
    tool::Tool,
};
use core::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// Values that the machine has answered; `None` for a name that nothing has.
pub(super) type Known = BTreeMap<Box<str>, Option<f64>>;

/// The environment of a line, with the values that are known. It notes those that are not.
pub(super) struct Asking<'a> {
    env: &'a dyn Environment,
    known: &'a Known,
    missing: RefCell<BTreeSet<Box<str>>>,
}

/// The place before a line: the line, the number of open loops and conditions, and the pass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before(Cursor, usize, u64);

impl<'a> Asking<'a> {
    pub(super) fn new(env: &'a dyn Environment, known: &'a Known) -> Self {
        Self { env, known, missing: RefCell::default() }
    }

    /// Returns whether a line reads values that are not known, and notes them.
    pub(super) fn lacks(&self, line: &Line, cleaned: &[u8]) -> bool {
        if !cleaned.contains(&b'#') {
            return false;
        }
        let mut rest = cleaned;
        while !rest.is_empty() {
            let code = rest.iter().position(|b| matches!(b, b'(' | b';')).unwrap_or(rest.len());
            self.note(rest.get(..code).unwrap_or_default());
            let comment = rest.get(code..).unwrap_or_default();
            let end =
                comment.iter().position(|b| *b == b')').filter(|_| comment.first() == Some(&b'('));
            rest = end.and_then(|end| comment.get(end + 1..)).unwrap_or_default();
        }
        if let Some(remark) = &line.remark
            && matches!(remark.kind, Kind::Debug | Kind::Print | Kind::Log | Kind::Abort)
        {
            self.note(remark.text.as_bytes());
        }
        !self.missing.borrow().is_empty()
    }

    /// Reads every value that a text names.
    pub(super) fn note(&self, text: &[u8]) {
        const MARK: &[u8] = b"_hal[";
        // Comments keep their capitals and spaces.
        let spaceless = text.iter().filter(|b| !b.is_ascii_whitespace());
        let text: Vec<u8> = spaceless.map(u8::to_ascii_lowercase).collect();
        let mut rest = &*text;
        while let Some(at) = rest.windows(MARK.len()).position(|w| w == MARK) {
            rest = rest.get(at + MARK.len()..).unwrap_or_default();
            let end = rest.windows(2).position(|w| w == b"]>");
            let name = end.and_then(|end| core::str::from_utf8(rest.get(..end)?).ok());
            name.map(|name| self.hal(name));
        }
    }

    /// Returns the names that were read and are not known.
    pub(super) fn missing(self) -> Vec<Box<str>> {
        self.missing.into_inner().into_iter().collect()
    }
}

impl Environment for Asking<'_> {
    fn open(&self, name: &str) -> Option<Text> {
        self.env.open(name)
    }
    fn refusal(&self, name: &str) -> Option<Box<str>> {
        self.env.refusal(name)
    }
    fn tool(&self, number: i32) -> Option<Tool> {
        self.env.tool(number)
    }
    fn ini(&self, section: &str, key: &str) -> Option<f64> {
        self.env.ini(section, key)
    }
    fn hal(&self, name: &str) -> Option<f64> {
        if let Some(known) = self.known.get(name) {
            return *known;
        }
        let value = self.env.hal(name);
        if value.is_none() {
            self.missing.borrow_mut().insert(name.into());
        }
        value
    }
    fn function(&self, name: &str) -> bool {
        self.env.function(name)
    }
    fn tool_slot(&self, number: i32) -> Option<i32> {
        self.env.tool_slot(number)
    }
    fn user_code(&self, code: u16) -> Result<bool, Box<str>> {
        self.env.user_code(code)
    }
}

impl Before {
    pub(super) fn of(level: &Level) -> Self {
        Self(level.cursor, level.open.len(), level.pass)
    }
}

impl Interpreter {
    /// Asks for values of HAL, and goes back to the place before the line that reads them.
    pub(super) fn ask_hal(&mut self, before: Before, names: Vec<Box<str>>, known: Known) -> Step {
        let Before(cursor, open, pass) = before;
        if let Some(level) = self.state.levels.last_mut() {
            (level.cursor, level.pass) = (cursor, pass);
            level.open.truncate(open);
        }
        self.state.lines_run = self.state.lines_run.saturating_sub(1);
        self.state.lines_quiet = self.state.lines_quiet.saturating_sub(1);
        self.hal = known;
        let request = Request::Hal { names };
        let pending = Pending { request: request.clone(), block: Default::default(), step: 0 };
        self.state.pending = Some(pending);
        Step::Ask(request)
    }

    /// Runs the line that has asked for values of HAL.
    pub(super) fn go_on_with_hal(
        &mut self,
        request: Request,
        answer: &Answer,
        env: &dyn Environment,
        out: &mut Vec<Issued>,
    ) -> Result<Step, Error> {
        let values = match answer {
            Answer::Hal(values) => values,
            Answer::Failed(reason) => {
                return Err(self.error(failed(&request, reason.clone()).into(), &[]));
            }
            _ => return Err(self.error(Problem::WrongAnswer.into(), &[])),
        };
        let Request::Hal { names } = request else {
            return Err(self.error(Problem::WrongAnswer.into(), &[]));
        };
        // A name without an answer is one that nothing has.
        self.hal.extend(names.into_iter().map(|name| (name, None)));
        self.hal.extend(values.iter().cloned());
        self.run_line(env, out)
    }
}
